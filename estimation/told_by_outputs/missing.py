"""What a model lacks, by the errors of its outputs: a test of each force that it may lack.

Of a column of slopes ``c`` by such a force, less what the parameters make of it, the errors tell
``g = c'e / c'c`` with the variance ``c' C c / (c'c)**2``. C are the covariances of errors that
follow the autoregression of what is left beside that column: so a lack does not hide behind the
colour that it gives the errors itself, and a slow noise is not taken for one. How sure that
variance is follows from the autoregression's own, and Student's distribution of as many degrees of
freedom has the chance of g over its deviation.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import repeat

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr

from axisid.estimation.thresholds import FEWEST_WINDOWS, MIN_OWN_SLOPE
from axisid.support.arrays import Array

from .colour import Colour, autoregression_of
from .uneven import Scattering, added, by_colour, by_windows, larger, uneven

_FEWEST = 1.0  # degrees of freedom of slow errors, from which they tell what is chance


@dataclass(frozen=True, slots=True, kw_only=True)
class Left:
    """Errors of outputs at the parameters that were found.

    Attributes
    ----------
    errors : (n,) array
        Weighted, as their loss lets them count.
    weights : (n,) array
    curvature : (n,) array
        Of the loss.
    jacobian : (n, k) array
        Of the weighted errors by the parameters that move.
    inverse : (k, k) array
        Of the curvature of the cost.
    known : (j, k) array
        Of what was known before.
    counted : (n,) array of bool
    spans : tuple of tuple of slice
        By record.
    periods : tuple of float
        s, by record.
    outputs : int
        Whose rows of a sample are neighbours.
    by_windows : bool
        Whether the stretches are windows of an open loop. What moved the axis besides the recorded
        control is summed up twice there, as no autoregression of errors is; windows are
        independent, and their scores tell the variance.
    twins : (n, B) array or None
        What errors of the measured position make of these, weighted, where no colour tells that:
        they tell the variance then where it is more than by another way.
    remembers : bool
        Whether that way is neighbouring scores, as of friction that remembers, see `uneven`; else
        autoregressions.
    """

    errors: Array
    weights: Array
    curvature: Array
    jacobian: Array
    inverse: Array
    known: Array
    counted: NDArray[np.bool_]
    spans: tuple[tuple[slice, ...], ...]
    periods: tuple[float, ...]
    outputs: int = 1
    by_windows: bool = False
    twins: Array | None = None
    remembers: bool = True

    def beside(self, columns: Array) -> tuple[Array, Array]:
        """Columns (n, m) less what parameters make of them, and those parameters, (k, m)."""
        made = self.inverse @ (self.jacobian.T @ (self.curvature[:, None] * columns))
        return columns - self.jacobian @ made, made

    @property
    def used(self) -> tuple[int, ...]:
        """Errors that count, by record."""
        return tuple(sum(int(self.counted[rows].sum()) for rows in spans) for spans in self.spans)

    def autoregressions(self, errors: Array) -> tuple[Colour, ...]:
        """Of errors (n,), by record."""
        return tuple(
            autoregression_of(
                [errors[rows] for rows in spans],
                period,
                [self.counted[rows] for rows in spans],
                self.outputs,
            )
            for spans, period in zip(self.spans, self.periods, strict=True)
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Lacking:
    """One force beside the model.

    Attributes
    ----------
    number : int
        Of the column.
    factor, deviation : float
        What the errors tell of it.
    chance : float
        That noise tells as much.
    """

    number: int
    factor: float
    deviation: float
    chance: float

    @property
    def ratio(self) -> float:
        """Of the factor, in deviations."""
        return abs(self.factor) / self.deviation if self.deviation > 0 else np.inf


def lacking_of(left: Left, columns: Array, most: int, level: float) -> tuple[Lacking, ...]:
    """The columns that the errors ask for, one after the other, the strongest first.

    Parameters
    ----------
    left : Left
    columns : (n, m) array
        Slopes of the errors by what may be lacking; not weighted.
    most : int
        How many at most.
    level : float
        Chance of the strongest of noise, up to which it is one, for all columns together.

    Returns
    -------
    tuple of Lacking
        The first is given whatever its chance is; none where no column is any but the parameters',
        or each is in too few windows to tell what is chance.
    """
    weighed = left.weights[:, None] * columns
    net, made = left.beside(weighed)
    sizes = np.linalg.norm(weighed, axis=0)
    there = [j for j in range(columns.shape[1]) if _is_own(net[:, j], sizes[j])]
    errors, found = left.errors, list[Lacking]()
    while there and len(found) < most:
        every = (_tested(left, errors, net[:, j], made[:, j], j) for j in there)
        tests = [each for each in every if each is not None]
        if not tests:
            break
        best = min(tests, key=lambda each: (each.chance, -each.ratio))
        best = replace(best, chance=min(1.0, best.chance * len(tests)))
        if found and best.chance > level:
            break
        found.append(best)
        if best.chance > level:
            break
        unit = net[:, best.number] / np.linalg.norm(net[:, best.number])
        errors = errors - unit * (unit @ errors)
        net = net - np.outer(unit, unit @ net)
        there = [j for j in there if j != best.number and _is_own(net[:, j], sizes[j])]
    return tuple(found)


def _is_own(net: Array, size: float) -> bool:
    return bool(np.isfinite(size) and np.linalg.norm(net) > MIN_OWN_SLOPE.value * size)


def _tested(left: Left, errors: Array, net: Array, made: Array, number: int) -> Lacking | None:
    """A column; None where too few degrees of freedom are left to tell what is chance."""
    size = float(net @ net)
    told = float(net @ errors) / size
    beside = errors - told * net
    coloured, whole = _scattering(left, beside, net)
    freedom = whole - left.jacobian.shape[1] - 1  # of slow errors, with the column's
    if freedom < (FEWEST_WINDOWS.value - 1 if left.by_windows else _FEWEST):
        return None
    variance = coloured * _inflation(whole, freedom) + float(np.sum((left.known @ made) ** 2))
    deviation = np.sqrt(max(variance, 0.0)) / size
    ratio = abs(told) / deviation if deviation > 0 else np.inf
    return Lacking(
        number=number,
        factor=-told,
        deviation=float(deviation),
        chance=2 * float(stdtr(freedom, -ratio)),
    )


def _inflation(whole: float, freedom: float) -> float:
    return whole / freedom if np.isfinite(whole) else 1.0


def _scattering(left: Left, errors: Array, column: Array) -> tuple[float, float]:
    """Variance of what a column makes of errors, and of how many degrees of freedom it is."""
    if left.by_windows:
        return _of_windows(left, errors, column)
    return _of(left, errors, column) if left.twins is None else _by_twins(left, errors, column)


def _of(left: Left, errors: Array, column: Array) -> tuple[float, float]:
    """The same by autoregressions."""
    models = left.autoregressions(errors)
    return _of_records(map(by_colour, repeat(column[:, None]), models, left.spans, left.used))


def _of_records(found: Iterable[Scattering]) -> tuple[float, float]:
    """The sum of the variances of one column, and of how many degrees of freedom it is."""
    whole = added([*found])
    return float(whole.matrix[0, 0]), float(whole.freedom[0])


def _by_twins(left: Left, errors: Array, column: Array) -> tuple[float, float]:
    """The same by twins with noise, and by neighbouring scores, as `uneven` has it."""
    twins = np.zeros((len(errors), 0)) if left.twins is None else left.twins
    wide = column[:, None]
    if left.remembers:
        pairs = zip(left.spans, left.periods, strict=True)
        return _of_records(uneven(wide, errors, twins, *pair, left.outputs) for pair in pairs)
    models = left.autoregressions(errors)
    told = map(by_colour, repeat(wide), models, left.spans, left.used)
    return _of_records(map(larger, told, repeat(wide), repeat(twins), left.spans))


def _of_windows(left: Left, errors: Array, column: Array) -> tuple[float, float]:
    """The same by the scores of windows, of which as many count as the column is alike in."""
    windows = [rows for spans in left.spans for rows in spans]
    found = by_windows(column[:, None], errors, windows)
    return float(found.matrix[0, 0]), float(found.freedom[0])
