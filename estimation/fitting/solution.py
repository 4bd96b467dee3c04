"""Where the searches of a fit ended: deviations, intervals, what noise and starts move."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr, ndtri_exp

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import told_or, unless_faulty
from axisid.estimation.choices import SQUARES
from axisid.estimation.parameters import Unknowns, are_starts, axis_at, bounded_quadratic_minimum
from axisid.estimation.predictions import Predictions
from axisid.estimation.problems import ParameterAtBound
from axisid.estimation.records import Record
from axisid.estimation.regression import CovarianceEstimate, Form, widened
from axisid.estimation.searches import (
    EquallyGoodPoint,
    Search,
    SearchResult,
    WeightedLoss,
)
from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.estimation.twins import Chain
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError, Missing

from .rests import Rests
from .spread import (
    MovedByStart,
    Scores,
    Unseen,
    moved_by_start,
    scores_of,
    unseen_directions,
)
from .starting import Searched
from .twins import RecordLoops, calibrated_covariance, outputs_by_noise

_OF_POSITION = 16  # twins with noise of the position alone
_EXPONENTIAL = 1e4  # deviations, beyond which a normal's tail is an exponential to rounding


#: Of a value that is known with a deviation: form and predictions where it is larger by that.
Doubt = tuple[Form, Predictions]


@dataclass(frozen=True, kw_only=True, eq=False)
class FitSolution:
    """Where the searches of a fit ended, and what follows of it for the parameters.

    Attributes
    ----------
    axis, records, outputs, loss, known, bootstrap, seed
        As `fit` takes them.
    whose : Searched
    unknowns : Unknowns
    predictions : Predictions
    start, scale : (P,) array
        Where the first search begins, and by how much its parameters change.
    started : str
        Where the start is from: ``instruments``, ``least-squares``, ``nominal`` or ``given``.
    weighing : WeightedLoss
    remarks : tuple of str
    best : SearchResult
        The search that is told.
    searches : tuple of SearchResult
    doubts : tuple of Doubt
    rests : Rests
    alone : SearchResult or None
        The search without what was known before.
    """

    axis: GeneratedAxis
    records: tuple[Record, ...]
    whose: Searched = field(repr=False, compare=False)
    outputs: tuple[str, ...]
    loss: str
    unknowns: Unknowns = field(repr=False, compare=False)
    predictions: Predictions = field(repr=False, compare=False)
    start: Array
    started: str
    scale: Array
    weighing: WeightedLoss = field(repr=False, compare=False)
    remarks: tuple[str, ...]
    best: SearchResult
    searches: tuple[SearchResult, ...]
    bootstrap: int
    seed: int
    known: tuple[str, ...]
    doubts: tuple[Doubt, ...] = field(repr=False, compare=False)
    rests: Rests = field(repr=False, compare=False)
    alone: SearchResult | None = field(repr=False, compare=False)

    @property
    def horizon(self) -> float | None:
        """Length of the windows of an open loop, s."""
        return self.predictions.horizon

    def begun_as(self, other: Self) -> Self:
        """The same, told to begin where another does, which led to it."""
        return replace(self, start=other.start, started=other.started, remarks=other.remarks)

    @cached_property
    def axes(self) -> tuple[GeneratedAxis, ...]:
        """By record, under the law with the gains that were found."""
        form, physical = self.whose.form, self.physical
        return tuple(axis_at(axis, form, physical) for axis in self.whose.axes)

    @cached_property
    def own(self) -> tuple[Array, ...]:
        """Parameters of each record's axis, (p,)."""
        form, physical = self.whose.form, self.physical
        return tuple(form.own(physical, i) for i in range(len(self.records)))

    @property
    def inner(self) -> NDArray[np.bool_]:
        """Which parameters are free and not at a bound, (P,)."""
        return np.asarray(self.unknowns.free & (self.sides == 0))

    @cached_property
    def rows(self) -> Array:
        """Slopes of the weighted errors by all free parameters, (n, P)."""
        return np.asarray(self.weighing.weights[:, None] * self.best.slopes.jacobian)

    @cached_property
    def scores(self) -> Scores:
        """Of the parameters that are free and not at a bound."""
        return self._scores(self.inner)

    def _scores(self, chosen: NDArray[np.bool_]) -> Scores:
        return scores_of(
            self.best,
            self.weighing,
            self.unknowns,
            self.predictions,
            self.records,
            chosen,
        )

    @property
    def twins(self) -> Array | None:
        """What noise makes of the outputs where the search ended, (n, R); None without."""
        return None if isinstance(self.twins_or_why, str) else self.twins_or_why

    @cached_property
    def twins_or_why(self) -> Array | str:
        """With the noise of the records; or why there are none, empty where none were asked for.

        Windows have the noise of what is measured alone: forces beside the control move their
        errors in proportion, which is no bias, and what their parameters scatter by is seen from
        window to window.
        """
        if not self.bootstrap:
            return ""
        if self.loss != SQUARES:
            return "errors count by their size, and outliers are no noise of a loop"
        disturbed = self.horizon is None
        found = unless_faulty(
            lambda: outputs_by_noise(*self._there, self.bootstrap, disturbed=disturbed, paired=True)
        )
        if isinstance(found, Missing):
            return found.reason
        return found if found.any() else "no noise that is measured reaches what is followed."

    @cached_property
    def by_position(self) -> Array:
        """What noise of what is measured makes of the outputs, (n, B); 0 where it is not known.

        A chain takes for forces what the model lacks.
        """
        none = np.zeros((len(self.weighing.weights), 1))
        alone = partial(outputs_by_noise, disturbed=False, paired=False)
        return told_or(none, lambda: alone(*self._there, _OF_POSITION))

    @property
    def _there(self) -> tuple[Sequence[RecordLoops | Missing], Array, Predictions]:
        return self.loops, self.best.physical, self.predictions

    @cached_property
    def loops(self) -> tuple[RecordLoops | Missing, ...]:
        """The loops of each record where the search ended, with its noise."""
        form, physical = self.whose.form, self.best.physical
        return tuple(
            unless_faulty(
                partial(
                    RecordLoops.at, axis_at(axis, form, physical), record, form.own(physical, place)
                )
            )
            for place, (axis, record) in enumerate(zip(self.whose.axes, self.records, strict=True))
        )

    @cached_property
    def chains(self) -> tuple[Chain | None, ...]:
        """The noise of each record; None where it cannot be measured."""
        return tuple(None if isinstance(of, Missing) else of.chain for of in self.loops)

    @cached_property
    def why_no_twins(self) -> str:
        """Empty where there are twins, or none were asked for."""
        return self.twins_or_why if isinstance(self.twins_or_why, str) else ""

    @cached_property
    def rests_count(self) -> bool:
        """Whether samples near rests count, as without them a parameter is hardly shown."""
        return self.rests.count

    @property
    def of_start(self) -> NDArray[np.bool_]:
        """Which parameters are first positions and velocities of loops, (P,)."""
        return are_starts(self.whose.form)

    @property
    def _scattered(self) -> Array | None:
        """Twins that tell deviations; None where windows do, or nothing but the errors."""
        return self.twins if self.horizon is None else None

    @property
    def errors_in_common(self) -> Array | None:
        """What noise makes of the errors in the mean, (n,), where twins tell it."""
        return None if self.twins is None else self.twins.mean(axis=1)

    @cached_property
    def moved(self) -> Array | None:
        """What noise in the loop moves the parameters by, (P,), where twins tell it."""
        return None if self.twins is None else self.best.physical - self.physical

    @property
    def physical(self) -> Array:
        """The parameters less what noise in the loop moves them by, (P,)."""
        return self._told_at[0]

    @property
    def sides(self) -> NDArray[np.int8]:
        """Which of them are at a bound, -1 at the lower, 1 at the upper one, (P,)."""
        return self._told_at[1]

    @cached_property
    def _told_at(self) -> tuple[Array, NDArray[np.int8]]:
        """The parameters that are told, and which are at a bound.

        What is taken off may lead one to its bound, or from there; the others are what they are
        with it.
        """
        at, side, u = self.best.physical, self.best.at_bound, self.unknowns
        common = self.errors_in_common
        if common is None:
            return at, side
        scores = self.at_liberty
        uphill = scores.jacobian.T @ (scores.curvature * self.weighing.weights * common)
        # The search stands still but for what a bound holds.
        held = scores.jacobian.T @ scores.errors + scores.known.T @ u.known_errors(at)
        downhill = -uphill - np.where(side[u.free] != 0, held, 0.0)
        physical = at.copy()
        physical[u.free] += scores.inverse @ downhill
        if not side.any() and np.all(((u.lower < physical) & (physical < u.upper))[u.free]):
            return physical, side
        rows = np.vstack([np.sqrt(scores.curvature)[:, None] * scores.jacobian, scores.known])
        physical, side = at.copy(), np.zeros_like(side)
        lower, upper, start = (each[u.free] for each in (u.lower, u.upper, at))
        physical[u.free], side[u.free] = bounded_quadratic_minimum(
            lower, upper, start, rows, downhill
        )
        return physical, side

    @cached_property
    def at_liberty(self) -> Scores:
        """Of every free parameter, as if no bound were there.

        What a bound holds is not known: the others are as unsure as its parameter lets them be. A
        bounded estimate is nearer to whatever is within the bounds than the free one is, so that
        the free one's deviations about it are enough.
        """
        return self._scores(self.unknowns.free)

    @cached_property
    def errors_left(self) -> Array:
        """Weighted errors, (n,), less what noise makes of them by its square.

        That comes at every reversal alike, so that it scatters nothing.
        """
        common, errors = self.errors_in_common, self.scores.errors
        if common is None:
            return errors
        beside = common - self.best.slopes.jacobian @ (self.influence @ common)
        return errors + self.weighing.weights * beside

    @cached_property
    def not_shown(self) -> Unseen:
        """What neither outputs nor what was known before show."""
        chosen = self.unknowns.free
        rows = np.vstack([self.rows, self.unknowns.known_rows])[:, chosen]
        return unseen_directions(rows, self.scale[chosen]).among(chosen)

    @cached_property
    def covariances(self) -> dict[str, Array]:
        """By name, (P, P) each: 0 of what is at a bound, infinite of what is not shown."""
        inner, free = self.inner, self.unknowns.free
        lost, found = np.flatnonzero(self.not_shown.parts.any(axis=0)), {}
        for name, matrix in self.free_covariances.items():
            whole = np.zeros((len(free), len(free)))
            whole[np.ix_(free, free)] = matrix
            whole[lost, lost] = np.inf
            found[name] = np.where(inner[:, None] & inner, whole, 0.0)
        return found

    @cached_property
    def free_covariances(self) -> dict[str, Array]:
        """Of every free parameter, as if no bound were there, by name, (k, k) each."""
        scores = self.at_liberty
        found = {
            "coloured": self._with_starts(self.coloured.matrix + self._by_mean(scores), scores),
            "iid": scores.independent(),
        }
        if self._scattered is not None:
            by_twins = self._by_twins(scores, self._scattered) + scores.by_known()
            found["bootstrap"] = self._with_starts(by_twins, scores)
        moved = self._influence(scores) @ self._by_doubts
        return {name: matrix + moved @ moved.T for name, matrix in found.items()}

    def _by_mean(self, scores: Scores) -> Array:
        """What the mean of so many twins is unsure by, (k, k), where windows tell deviations.

        Of two opposite twins it is what they do alike, which is what is taken off.
        """
        if self.twins is None or self._scattered is not None:
            return np.zeros((len(scores.inverse), len(scores.inverse)))
        moved = self._influence(scores) @ self.twins
        alike = moved[:, : moved.shape[1] // 2 * 2].reshape(len(moved), -1, 2).mean(axis=2)
        return np.asarray(np.cov(alike).reshape(len(moved), -1) / alike.shape[1])

    @cached_property
    def _by_doubts(self) -> Array:
        """What a deviation of each value that is known with one changes the errors by, (n, d)."""
        errors = self.best.slopes.errors[:, None]
        there = dict(zip(self.unknowns.names, self.best.physical, strict=True))
        moved = [errors[:, :0]]
        for form, predictions in self.doubts:
            at = np.array([there.get(q.name, 0.0) for q in form.physical_quantities])
            predictions.settle(at)
            lanes = predictions(at[None, :])
            if lanes.failures:
                raise EstimationError(lanes.failures[0], code="simulation")
            moved.append(lanes.errors - errors)
        return np.hstack(moved)

    @cached_property
    def coloured(self) -> CovarianceEstimate:
        """By coloured errors, of every free parameter, as if no bound were there."""
        scores = self.at_liberty
        if self.horizon is None:
            return scores.coloured()
        found = scores.clustered()  # of few windows next to nothing, as a fit makes their sum 0
        return replace(found, matrix=widened(found.matrix, np.diag(scores.independent())))

    @property
    def freedom(self) -> Array:
        """Degrees of freedom of each variance that is told, (P,)."""
        found, freedom = np.full(len(self.scale), np.inf), self.coloured.freedom
        if self._scattered is not None:
            freedom = np.full(len(freedom), self._scattered.shape[1] / 2)  # of pairs
        found[self.unknowns.free] = freedom
        return found

    def _with_starts(self, covariance: Array, scores: Scores) -> Array:
        """Covariance of the parameters of scores with what the starts of the loops add.

        No error of a record tells that.
        """
        starts = self._slopes_by_start
        moved = moved_by_start(scores, self.weighing.weights, starts, covariance).moved
        return covariance + np.outer(moved, moved)

    @cached_property
    def _slopes_by_start(self) -> tuple[tuple[slice, Array], ...]:
        with np.errstate(all="ignore"):
            return self.predictions.slopes_by_start(self.best.physical)

    @cached_property
    def by_start(self) -> MovedByStart:
        """What other starts move all parameters by, (P,), where that matters."""
        at = self.at_liberty, self.weighing.weights, self._slopes_by_start
        found = moved_by_start(*at, self.coloured.matrix)
        moved, far = np.zeros((2, len(self.scale)))
        moved[self.unknowns.free], far[self.unknowns.free] = found.moved, found.far
        return MovedByStart(moved=moved, far=far)

    @cached_property
    def judged_scores(self) -> Scores:
        """Of the parameters that are free and not at a bound, less what noise makes in the mean."""
        scores, made = self.scores, self._scattered
        twins = None if made is None else scores.counts[:, None] * made
        return replace(scores, errors=self.errors_left, twins=twins)

    @cached_property
    def elsewhere(self) -> EquallyGoodPoint | None:
        """A place as good as the end that is claimed to be far from it."""
        told, independent = (np.diag(self.covariances[name]) for name in (self.chosen, "iid"))
        search = Search(self.predictions, self.unknowns, self.scale, self.weighing)
        return search.equally_good_point(self.searches, told, independent)

    @cached_property
    def without_prior(self) -> Mapping[str, tuple[float, float]]:
        """What the records alone say of what was known before, with deviations, by name."""
        if self.alone is None:
            return {}
        one, prior = self.alone, self.unknowns.has_prior
        without = replace(self, unknowns=self.unknowns.without_prior, best=one, searches=(one,))
        told = np.full(len(prior), np.inf)
        told[self.unknowns.free] = np.diag(without.free_covariances[without.chosen])
        return {
            self.unknowns.names[j]: (float(without.physical[j]), math.sqrt(max(told[j], 0.0)))
            for j in map(int, np.flatnonzero(prior))
        }

    def _by_twins(self, scores: Scores, twins: Array) -> Array:
        """Covariance of the parameters of scores by twins, (k, k)."""
        weights = self.weighing.weights[:, None]
        apart = twins - twins.mean(axis=1, keepdims=True)
        moved = -self._influence(scores) @ apart
        left = weights * apart + scores.jacobian @ moved
        return calibrated_covariance(scores, self.errors_left, moved, left)

    @cached_property
    def chosen(self) -> str:
        """The covariance that is told."""
        return "coloured" if self._scattered is None else "bootstrap"

    @cached_property
    def influence(self) -> Array:
        """Of the errors on the parameters, (P, n)."""
        found = np.zeros((len(self.scale), len(self.weighing.weights)))
        chosen = self.inner
        if chosen.any():
            found[chosen] = self._influence(self.scores)
        return found

    def _influence(self, scores: Scores) -> Array:
        """Of the errors on the parameters of scores, (k, n)."""
        weighed = scores.curvature[:, None] * scores.jacobian * self.weighing.weights[:, None]
        return np.asarray(scores.inverse @ weighed.T)

    @cached_property
    def without_bounds(self) -> dict[int, tuple[float, float]]:
        """What each parameter at a bound would be without it, with its deviation, by place."""
        return {int(j): self._without_bound(int(j)) for j in np.flatnonzero(self.sides)}

    def _without_bound(self, j: int) -> tuple[float, float]:
        free = self.inner.copy()
        free[j] = True
        scores, place = self._scores(free), int(np.flatnonzero(np.flatnonzero(free) == j)[0])
        told = replace(scores, errors=self.errors_left).coloured()
        covariance = self._with_starts(told.matrix, scores)
        off = self.unknowns.known_errors(self.physical)
        errors, common = scores.errors, self.errors_in_common
        if common is not None:
            moved = self.rows @ (self.physical - self.best.physical)
            errors = errors + scores.curvature * (self.weighing.weights * common + moved)
        downhill = -(scores.jacobian.T @ errors + scores.known.T @ off)
        centre = float(self.physical[j]) + float((scores.inverse @ downhill)[place])
        return centre, float(np.sqrt(covariance[place, place]))

    def one_sided(self, j: int) -> tuple[float, float]:
        """Interval at a bound: of a normal about the estimate without it, cut off there.

        Other parameters at bounds may be elsewhere, so that the normal is as wide as without any,
        and as many deviations beyond as with the others at theirs.
        """
        at, side = float(self.physical[j]), int(self.sides[j])
        centre, deviation = self.without_bounds[j]
        free = np.flatnonzero(self.unknowns.free)
        place = int(np.flatnonzero(free == j)[0])
        wide = max(math.sqrt(self.free_covariances[self.chosen][place, place]), deviation)
        beyond = (centre - at) / deviation if deviation > 0 else 0.0
        return cut_interval(at, at + beyond * wide, wide, side)

    @cached_property
    def held(self) -> tuple[ParameterAtBound, ...]:
        """Parameters at their bounds, and what each would be without its own."""
        return tuple(
            ParameterAtBound(
                name=self.unknowns.names[j],
                unit=self.unknowns.quantities[j].unit,
                bound=float(self.physical[j]),
                is_lower=bool(self.sides[j] < 0),
                free=centre,
                deviation=deviation,
                reach=self.one_sided(j)[int(self.sides[j] < 0)],
            )
            for j, (centre, deviation) in self.without_bounds.items()
        )


def cut_interval(bound: float, centre: float, deviation: float, side: int) -> tuple[float, float]:
    """95 % of a normal distribution that is cut off at a bound, from there on.

    Parameters
    ----------
    bound, centre, deviation : float
    side : {-1, 1}
        Of a lower or of an upper bound.
    """
    if not deviation > 0:
        return bound, bound
    reach = side * (bound - centre) / deviation  # what lies beyond it, in deviations
    outside = np.log(1 - INTERVAL_LEVEL.value)
    if reach < -_EXPONENTIAL:
        beside = outside / -reach
    else:
        beside = float(ndtri_exp(outside + log_ndtr(reach))) - reach
    width = side * deviation * beside
    return (bound, bound + width) if side < 0 else (bound + width, bound)
