"""How sure an output-error estimate is: the errors are coloured, as the loop colours noise.

Noise of the position comes back through the law, differentiated, so that errors follow one another
with alternating signs; what the model lacks lasts. Both are told by an autoregression of the errors
``a(q) e = w``, of each record its own, with which

    Sigma = (J'J)^-1 (sum_r J_r' C_r J_r) (J'J)^-1,    C the covariances of such errors,

as the prediction-error method has it for errors that are not white [Ljung1999]_ (9.42). C is of
errors that were under way before a stretch begins, so that short stretches count as long ones do.
Friction that remembers answers to noise otherwise at rest than in motion: there C is of no one
colour, and twins with noise tell it too, see `uneven`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.choices.outputs import POSITION
from axisid.estimation.predictions import Predictions, whole_lanes
from axisid.estimation.records import Record
from axisid.estimation.searches import Found, Unknowns, Weighing
from axisid.estimation.thresholds.estimates import MIN_DISTANCE_FROM_NOISE
from axisid.estimation.thresholds.fitting import (
    FEWEST_TWINS,
    MIN_MOVED_BY_NOISE,
    MIN_SHOWN,
    MIN_WIDENED_BY_FEW,
    MIN_WIDENED_BY_NOISE,
)
from axisid.estimation.told_by_outputs import (
    Colour,
    Scattering,
    added,
    autoregression_of,
    by_colour,
    by_windows,
    larger,
    uneven,
)
from axisid.support.arrays import Array

from .basis import NoisyLoops

_NOTHING = MIN_SHOWN.value / 2  # what is nearer to being shown is said to be vague instead
_FEW = 4  # pairs of twins, that tell whether more are asked
_FEWEST_OF_MANY, _MOST, _VALUES = 48, 144, 5_000_000  # a deviation is known to 10 or 6 % then


@dataclass(frozen=True, kw_only=True)
class Scores:
    """What the covariance of an estimate is made of.

    Attributes
    ----------
    jacobian : (n, k) array
        Of the weighted errors by the parameters that are free.
    errors : (n,) array
        Weighted, as the loss lets them count.
    curvature : (n,) array
        Of the loss: by how much each counted error changes with its error.
    known : (j, k) array
        Rows of what was known before, over its deviations.
    counted : (n,) array of bool
        Which rows are measured; the others are 0.
    spans : tuple of tuple of slice
        Stretches by record.
    periods : tuple of float
        By record, s.
    outputs : int
        Whose rows of a sample are neighbours.
    twins : (n, B) array or None
        What noise makes of the weighted errors, where their colour changes on the way.
    remembers : bool
        Whether friction remembers, and scores are held against them in place of autoregressions.
    """

    jacobian: Array
    errors: Array
    curvature: Array
    known: Array
    counted: NDArray[np.bool_]
    spans: tuple[tuple[slice, ...], ...]
    periods: tuple[float, ...]
    outputs: int = 1
    twins: Array | None = None
    remembers: bool = True

    @cached_property
    def inverse(self) -> Array:
        """Of the curvature of the cost, (k, k), from a triangle of columns of one size.

        What changes nothing is left out, whose variances are told as infinite: the rounding in it
        would else be in those of every other parameter.
        """
        rows = np.vstack([np.sqrt(self.curvature)[:, None] * self.jacobian, self.known])
        size = np.linalg.norm(rows, axis=0)
        size = np.where(size > 0, size, 1.0)
        triangle = np.linalg.qr(rows / size, mode="r")
        factor = np.linalg.pinv(triangle, rcond=_NOTHING) / size[:, None]
        return np.asarray(factor @ factor.T)

    @cached_property
    def autoregressions(self) -> tuple[Colour, ...]:
        """Of the errors, by record."""
        return tuple(
            autoregression_of(
                [self.errors[rows] for rows in spans],
                period,
                [self.counted[rows] for rows in spans],
                self.outputs,
            )
            for spans, period in zip(self.spans, self.periods, strict=True)
        )

    def coloured(self, models: Sequence[Colour]) -> Scattering:
        """Covariance for errors that follow these autoregressions, or are as twins', (k, k)."""
        columns = self.jacobian @ self.inverse
        if self.twins is not None:
            found = self._by_twins(columns, self.twins, models)
        else:
            found = added([self._by_colour(columns, model, r) for r, model in enumerate(models)])
        return found.beside(self.by_known())

    def by_windows(self) -> Scattering:
        """Covariance by the scatter over stretches that are windows of an open loop, (k, k)."""
        windows = [rows for spans in self.spans for rows in spans]
        columns = self.jacobian @ self.inverse
        taken = float(columns.shape[1])
        return by_windows(columns, self.errors, windows, taken).beside(self.by_known())

    def independent(self) -> Array:
        """Covariance for independent errors, of each record its own variance, (k, k)."""
        return self._sandwich(sum(map(self._independent, self.spans), self._of_known))

    def by_known(self) -> Array:
        """What the deviations of what was known before add to a covariance, (k, k)."""
        return self._sandwich(self._of_known)

    def effects(self) -> Array:
        """How much more each record's errors tell of what was known if they are independent, (r,).

        Over the variances of what was known: a record whose weights are divided by its square root
        counts beside what was known as its coloured errors allow, for one parameter exactly.
        """
        reach, found = self.known @ self.inverse, []
        columns = self.jacobian @ reach.T
        for r, spans in enumerate(self.spans):
            told = float(np.trace(self._of_record(columns, r)))
            white = float(np.einsum("ij,jk,ik", reach, self._independent(spans), reach))
            found.append(told / white if told > 0 and white > 0 else 1.0)
        return np.array(found)

    @property
    def _of_known(self) -> Array:
        return np.asarray(self.known.T @ self.known)

    def _of_record(self, columns: Array, r: int) -> Array:
        """Covariance of what columns (n, j) make of a record's errors, (j, j)."""
        if self.twins is not None:
            return self._uneven(columns, self.twins, r, self.autoregressions).matrix
        return _coloured(columns, self.autoregressions[r], self.spans[r])

    def _by_twins(self, columns: Array, twins: Array, models: Sequence[Colour]) -> Scattering:
        """Of each column, such as a parameter's: by what of it is more."""
        return added([self._uneven(columns, twins, r, models) for r in range(len(self.spans))])

    def _uneven(self, columns: Array, twins: Array, r: int, models: Sequence[Colour]) -> Scattering:
        spans = self.spans[r]
        if self.remembers:
            return uneven(columns, self.errors, twins, spans, self.periods[r], self.outputs)
        return larger(self._by_colour(columns, models[r], r), columns, twins, spans)

    def _by_colour(self, columns: Array, model: Colour, r: int) -> Scattering:
        """Of columns (n, k), less what the fit took of the record's errors."""
        spans = self.spans[r]
        rows = np.concatenate([np.arange(len(self.errors))[each] for each in spans])
        curved = self.curvature[rows, None] * self.jacobian[rows]
        taken = float(np.sum((self.jacobian[rows] @ self.inverse) * curved))
        return by_colour(columns, model, spans, int(self.counted[rows].sum()), taken)

    def _independent(self, spans: Sequence[slice]) -> Array:
        J = np.concatenate([self.jacobian[rows] for rows in spans])
        e = np.concatenate([self.errors[rows] for rows in spans])
        used = sum(int(self.counted[rows].sum()) for rows in spans)
        return np.asarray(float(e @ e) / max(used - J.shape[1], 1) * (J.T @ J))

    def _sandwich(self, meat: Array) -> Array:
        found = self.inverse @ meat @ self.inverse
        return np.asarray((found + found.T) / 2)


def _coloured(columns: Array, model: Colour, spans: Sequence[slice]) -> Array:
    """Covariance of what columns make of errors of one record that follow an autoregression."""
    nothing = np.zeros((columns.shape[1], columns.shape[1]))
    return sum((model.coloured(columns[rows]) for rows in spans), nothing)


def is_uneven(axis: GeneratedAxis, outputs: Sequence[str]) -> bool:
    """Whether noise of the position makes errors that no autoregression has the colour of.

    Of friction that remembers, and of a position, which a stiff loop holds at rest and not in
    motion.
    """
    return bool(axis.states) or POSITION in outputs


def twins_errors(predictions: Predictions, physical: Array, seed: int) -> Array | None:
    """What noise of the position makes of the outputs, (n, B).

    None where too few of the twins can be simulated.
    """
    count = _many(predictions)
    with np.errstate(all="ignore"):
        errors = whole_lanes(predictions.by_noise(physical, count, np.random.default_rng(seed)))
    return errors if errors.shape[1] >= FEWEST_TWINS.value else None


@dataclass(frozen=True, slots=True)
class Shaken:
    """What noise makes of the outputs.

    Attributes
    ----------
    few : (n, b) array
        Of a few twins.
    twins : (n, B) array or None
        Of many, where they tell more than is told without.
    common : (n,) array or None
        What it makes in the mean, where that moves the parameters.
    loops : NoisyLoops or None
        Of the many, where they were asked.
    """

    few: Array
    twins: Array | None = None
    common: Array | None = None
    loops: NoisyLoops | None = None


def shaken_by_noise(
    predictions: Predictions,
    physical: Array,
    seed: int,
    influence: Array,
    deviations: Array,
    *,
    by_square: bool = False,
) -> Shaken:
    """What noise makes of the outputs, if it moves parameters in the mean, or by more than told.

    Noise goes round the loop and shakes the axis, whose friction is not that of its mean velocity
    then; an encoder's steps follow from the motion, and come again with it. Twins and those with
    the opposite noise tell: what both have in common is no straight line of the noise. A few of
    them say whether the others are asked.

    Parameters
    ----------
    predictions : Predictions
    physical : (P,) array
    seed : int
    influence : (k, n) array
        Of errors on parameters that are free.
    deviations : (k,) array
    by_square : bool
        Whether that alone is asked, as twins tell the scatter anyway.
    """
    wider = np.inf if by_square else 1.0
    told = np.where(np.isfinite(deviations) & (deviations > 0), deviations, np.inf)
    common, straight = _common_and_straight(predictions, physical, seed, _FEW)
    few = np.hstack([common + straight, common - straight])
    lost = common.shape[1] < _FEW  # what they would have told is not known
    if not (
        lost
        or _moves(influence @ common, told, surely=False)
        or _scatter(influence @ straight, told) > wider * MIN_WIDENED_BY_FEW.value
    ):
        return Shaken(few)
    asked = _many(predictions)
    common, straight = _common_and_straight(predictions, physical, seed, asked)
    loops = NoisyLoops(asked=asked, lost=asked - common.shape[1])
    if not loops.are_enough:
        return Shaken(few, loops=loops)
    moves = _moves(influence @ common, told)
    if moves or _scatter(influence @ straight, told) > wider * MIN_WIDENED_BY_NOISE.value:
        mean = common.mean(axis=1) if moves else None
        return Shaken(few, twins=common + straight, common=mean, loops=loops)
    return Shaken(few, loops=loops if loops.lost else None)


def _many(predictions: Predictions) -> int:
    """How many twins tell a scatter: fewer of a long record, whose outputs would fill memory."""
    return max(_FEWEST_OF_MANY, min(_MOST, _VALUES // len(predictions.measured)))


def _common_and_straight(
    predictions: Predictions, physical: Array, seed: int, count: int
) -> tuple[Array, Array]:
    """Of twins and those with the opposite noise: what both have in common, and the other half.

    Of the pairs of which both can be simulated.
    """
    with np.errstate(all="ignore"):
        more, less = (
            predictions.by_noise(physical, count, np.random.default_rng(seed), factor)
            for factor in (1.0, -1.0)
        )
    return whole_lanes(more + less) / 2, whole_lanes(more - less) / 2


def _scatter(moved: Array, deviations: Array) -> float:
    """Largest root mean square of moves (k, B), in deviations (k,)."""
    return float(np.max(np.sqrt(np.mean(moved**2, axis=1)) / deviations, initial=0.0))


def _moves(moved: Array, deviations: Array, *, surely: bool = True) -> bool:
    """Whether the mean of moves (k, B) matters, and is more than chance."""
    mean, chance = moved.mean(axis=1), moved.std(axis=1, ddof=1) / np.sqrt(moved.shape[1])
    least = MIN_MOVED_BY_NOISE.value * deviations
    if surely:
        least = np.maximum(least, MIN_DISTANCE_FROM_NOISE.value * chance)
    return bool(np.any(np.abs(mean) > least))


def scores_of(
    found: Found,
    weighing: Weighing,
    unknowns: Unknowns,
    predictions: Predictions,
    records: Sequence[Record],
    chosen: NDArray[np.bool_],
    twins: Array | None = None,
    remembers: bool = False,
) -> Scores:
    """Of the chosen parameters, (P,), where a search of the records' outputs ended.

    Twins are what noise makes of the outputs, (n, B), of an axis whose friction remembers or not.
    """
    weighed = weighing.weights * found.slopes.errors
    z = (weighed / weighing.tuning) ** 2
    _, first, second = weighing.counted(z)
    return Scores(
        jacobian=(weighing.weights[:, None] * found.slopes.jacobian)[:, chosen],
        errors=first * weighed,
        curvature=np.maximum(first + 2 * z * second, 0.0),
        known=unknowns.known_rows[:, chosen],
        counted=weighing.weights > 0,
        spans=predictions.spans,
        periods=tuple(record.period for record in records),
        outputs=len(predictions.units),
        remembers=remembers,
        twins=None if twins is None else (first * weighing.weights)[:, None] * twins,
    )


def moved_by_start(scores: Scores, weights: Array, starts: Sequence[tuple[slice, Array]]) -> Array:
    """What first positions and velocities move parameters by that are free with them, (k,).

    To first order, by the errors.

    Parameters
    ----------
    scores : Scores
    weights : (n,) array
    starts : sequence of (slice, array)
        Rows of a stretch, and slopes of its errors by its start, (m, 2).
    """
    together, gained, own = [], [], []
    for rows, slopes in starts:
        weighed = weights[rows, None] * slopes
        size = np.linalg.norm(weighed, axis=0)
        unit = weighed / np.where(size > 0, size, 1.0)
        counted = scores.curvature[rows, None] * unit
        together.append(scores.jacobian[rows].T @ counted)
        gained.append(unit.T @ scores.errors[rows])
        own.append(unit.T @ counted)
    if not together:
        return np.zeros(scores.jacobian.shape[1])
    beside = scores.inverse @ np.hstack(together)
    net = block_diag(*own) - np.hstack(together).T @ beside
    downhill = beside.T @ (scores.jacobian.T @ scores.errors) - np.concatenate(gained)
    return np.asarray(-beside @ (np.linalg.pinv(net, rcond=MIN_SHOWN.value) @ downhill))
