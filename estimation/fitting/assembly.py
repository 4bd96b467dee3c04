"""From where a search ended to a result: deviations, intervals, what the law moves."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.diagnostics.loop import LawCheck, check_law
from axisid.estimation.estimates import Value, student_interval
from axisid.estimation.predictions import LoopPredictions
from axisid.estimation.records import Record
from axisid.estimation.thresholds.estimates import INTERVAL_LEVEL
from axisid.support.arrays import Array
from axisid.support.missing import Missing
from axisid.support.remedy import Note

from .judgement import Judged, judged
from .law_moves import move_by_record, moves_per_percent
from .result import OutputFit, RecordError
from .search import Found, Weighing
from .spread import Autoregression, Scores
from .starting import FitStart, Searched
from .unknowns import Unknowns
from .unseen import unseen_directions, unseen_text


@dataclass(frozen=True, kw_only=True)
class Ended:
    """A fit at its end, before it is told."""

    axis: GeneratedAxis
    records: tuple[Record, ...]
    whose: Searched
    output: str
    loss: str
    unknowns: Unknowns
    predictions: LoopPredictions
    start: FitStart
    begun: Array
    scale: Array
    weighing: Weighing
    remarks: tuple[Note, ...]
    best: Found
    ends: tuple[Found, ...]
    bootstrap: int
    seed: int

    @property
    def inner(self) -> NDArray[np.bool_]:
        """Which parameters are free and not at a bound, (P,)."""
        return self.unknowns.free & (self.best.at_bound == 0)

    @cached_property
    def rows(self) -> Array:
        """Slopes of the weighted errors by all free parameters, (n, P)."""
        return np.asarray(self.weighing.weights[:, None] * self.best.slopes.jacobian)

    @cached_property
    def scores(self) -> Scores:
        """Of the parameters that are free and not at a bound."""
        return self._scores(self.inner)

    def _scores(self, chosen: NDArray[np.bool_]) -> Scores:
        weighed = self.weighing.weights * self.best.slopes.errors
        z = (weighed / self.weighing.tuning) ** 2
        _, first, second = self.weighing.loss(z)
        known = np.diag(1 / self.unknowns.prior_sd)[self.unknowns.has_prior]
        return Scores(
            jacobian=self.rows[:, chosen],
            errors=first * weighed,
            curvature=np.maximum(first + 2 * z * second, 0.0),
            known=known[:, chosen],
            spans=self.predictions.spans,
            periods=tuple(record.period for record in self.records),
        )

    @cached_property
    def autoregressions(self) -> tuple[Autoregression, ...]:
        """Of the errors, by record."""
        return self.scores.autoregressions

    @cached_property
    def unseen(self) -> Array:
        """Directions that neither outputs nor what was known before show, (k, P)."""
        known = np.diag(1 / self.unknowns.prior_sd)[self.unknowns.has_prior]
        found = np.zeros((0, len(self.scale)))
        chosen = self.inner
        if chosen.any():
            rows = np.vstack([self.rows, known])[:, chosen]
            lost = unseen_directions(rows, self.scale[chosen])
            found = np.zeros((len(lost), len(self.scale)))
            found[:, chosen] = lost
        return found

    @cached_property
    def covariances(self) -> dict[str, Array]:
        """By name, (P, P) each."""
        chosen = self.inner
        if not chosen.any():
            nothing = np.zeros((len(chosen), len(chosen)))
            return {"coloured": nothing, "iid": nothing}
        inner = {
            "coloured": self.scores.coloured(self.autoregressions),
            "iid": self.scores.independent(),
        }
        return {name: self._whole(matrix, chosen) for name, matrix in inner.items()}

    def _whole(self, matrix: Array, chosen: NDArray[np.bool_]) -> Array:
        """A covariance among all parameters; infinite variances of what is not shown."""
        found = np.zeros((len(chosen), len(chosen)))
        found[np.ix_(chosen, chosen)] = matrix
        lost = np.flatnonzero(np.abs(self.unseen).max(axis=0, initial=0.0) > 0.1)
        found[lost, lost] = np.inf
        return found

    @cached_property
    def influence(self) -> Array:
        """Of the errors on the parameters, (P, n)."""
        found = np.zeros((len(self.scale), len(self.weighing.weights)))
        chosen = self.inner
        if chosen.any():
            s = self.scores
            weighed = s.curvature[:, None] * s.jacobian * self.weighing.weights[:, None]
            found[chosen] = s.inverse @ weighed.T
        return found

    def one_sided(self, j: int) -> tuple[float, float]:
        """Interval of a parameter at a bound: of a normal about its free estimate, cut off there."""
        side = int(self.best.at_bound[j])
        free = self.inner.copy()
        free[j] = True
        scores, place = self._scores(free), int(np.flatnonzero(np.flatnonzero(free) == j)[0])
        covariance = scores.coloured(self.autoregressions)
        downhill = -(scores.jacobian.T @ scores.errors)
        at = float(self.best.physical[j])
        centre = at + float((scores.inverse @ downhill)[place])
        deviation = float(np.sqrt(covariance[place, place]))
        return cut_interval(at, centre, deviation, side)


def cut_interval(
    bound: float, centre: float, deviation: float, side: int
) -> tuple[float, float]:
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
    tail = float(ndtr(reach))
    width = -side * deviation * (reach - float(ndtri((1 - INTERVAL_LEVEL.value) * tail)))
    return (bound, bound + width) if side < 0 else (bound + width, bound)


def assembled(ended: Ended) -> OutputFit:
    """The result of a fit."""
    names = ended.unknowns.names
    laws = [check_law(a, r) for a, r in zip(ended.whose.axes, ended.records, strict=True)]
    moves = moves_per_percent(ended.predictions, ended.best.physical, ended.influence)
    move = move_by_record(moves, laws)
    failing = (law for law in laws if isinstance(law, LawCheck) and not law.passed)
    law = next(failing, laws[0])
    at_bound = {
        n: "lower" if side < 0 else "upper"
        for n, side in zip(names, ended.best.at_bound, strict=True)
        if side
    }
    unseen = unseen_text(ended.unseen, names, ended.scale)
    values = _values(ended)
    of_records = _of_records(ended)
    return OutputFit(
        axis=ended.axis,
        records=ended.records,
        output=ended.output,
        unit=ended.predictions.unit,
        loss=ended.loss,
        quantities=ended.unknowns.quantities,
        physical=ended.best.physical,
        covariances=ended.covariances,
        chosen="coloured",
        values=values,
        at_bound=at_bound,
        bounds=_pairs(names, ended.unknowns.lower, ended.unknowns.upper),
        fixed=_chosen(names, ended.unknowns.fixed, ~ended.unknowns.free),
        prior=_priors(ended.unknowns),
        unseen=unseen,
        local=ended.whose.local,
        start=ended.begun,
        started=ended.start.named,
        remarks=ended.remarks,
        steps=ended.best.steps,
        ends=tuple((each.cost, each.physical) for each in ended.ends),
        of_records=of_records,
        errors=_errors(ended),
        law=law,
        law_moves=moves,
        law_move=move,
        checks=judged(
            Judged(
                output=ended.output,
                unknowns=ended.unknowns,
                best=ended.best,
                ends=ended.ends,
                deviations=np.array([value.deviation for value in values.values()]),
                at_bound=at_bound,
                unseen=unseen,
                law=law,
                law_moves=moves,
                law_move=move,
                percent=max(each.percent for each in of_records),
            )
        ),
    )


def _values(ended: Ended) -> dict[str, Value]:
    found, chosen = {}, "coloured"
    freedom = max(float(ended.weighing.weights.astype(bool).sum()) - ended.inner.sum(), 1.0)
    for j, q in enumerate(ended.unknowns.quantities):
        value = float(ended.best.physical[j])
        deviations = {n: float(np.sqrt(c[j, j])) for n, c in ended.covariances.items()}
        if ended.best.at_bound[j]:
            interval = ended.one_sided(j)
        else:
            interval = student_interval(value, deviations[chosen], freedom)
        found[q.name] = Value(
            value=value, unit=q.unit, deviations=deviations, interval=interval, chosen=chosen
        )
    return found


def _of_records(ended: Ended) -> tuple[RecordError, ...]:
    errors, measured = ended.best.slopes.errors, ended.predictions.measured
    counted, found = ended.predictions.counted > 0, []
    for spans, model in zip(ended.predictions.spans, ended.autoregressions, strict=True):
        rows = slice(spans[0].start, spans[-1].stop)
        used = counted[rows]
        e, y = errors[rows][used], measured[rows][used]
        size = float(np.linalg.norm(y))
        found.append(
            RecordError(
                rows=int(used.sum()),
                error=float(np.sqrt(np.mean(e**2))),
                percent=100 * float(np.linalg.norm(e)) / size if size else float("inf"),
                order=model.order,
            )
        )
    return tuple(found)


def _errors(ended: Ended) -> tuple[Array, ...]:
    errors = ended.best.slopes.errors
    return tuple(errors[s[0].start : s[-1].stop] for s in ended.predictions.spans)


def _pairs(names: tuple[str, ...], lower: Array, upper: Array) -> Mapping[str, tuple[float, float]]:
    return {n: (float(a), float(b)) for n, a, b in zip(names, lower, upper, strict=True)}


def _chosen(names: tuple[str, ...], values: Array, which: NDArray[np.bool_]) -> dict[str, float]:
    return {n: float(v) for n, v, kept in zip(names, values, which, strict=True) if kept}


def _priors(unknowns: Unknowns) -> dict[str, tuple[float, float]]:
    means = _chosen(unknowns.names, unknowns.prior, unknowns.has_prior)
    spreads = _chosen(unknowns.names, unknowns.prior_sd, unknowns.has_prior)
    return {name: (means[name], spreads[name]) for name in means}
