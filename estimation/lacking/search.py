"""What a model lacks: score tests of named terms and of changes in time, the strongest first.

Each family of candidates is tested by the best of its kind, beside the model's own columns, a
constant and what was found before. A candidate is found where it is significant among all of them
(Benjamini and Yekutieli, as the tests depend on each other) and large enough to matter; of those
the one that takes most of the residuals comes first, and the others are tested again beside it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import Hac, joint_p, score_products
from axisid.estimation.signals import FilteredRecord, Neighbours
from axisid.estimation.thresholds.lacking import (
    FALSE_DISCOVERY_RATE,
    MAX_SCORE_CHANCE,
    MAX_SHARE_TO_DOUBT,
    MIN_EXPLAINED_BY_LAST,
    MIN_EXPLAINED_SHARE,
    MIN_MISSING_FORCE,
    MIN_OWN_PART_OF_PLAIN,
    MIN_STEPS_EXCESS,
)
from axisid.support.arrays import Array
from axisid.support.missing import Missing

from .candidates import Family, families
from .examined_rows import ExaminedRows, examined, examined_again
from .terms import OF_KIND, PLAIN, Kind, terms_for

_MOST = 3  # that are told


@dataclass(frozen=True, slots=True, kw_only=True)
class Lack:
    """Something that the model lacks.

    Attributes
    ----------
    kind : str
    parameter : str
        What changes in time; empty for a term.
    values, deviations : tuple of float
        Factors of its columns, and their HAC deviations.
    before : float
        Of a parameter that changes: its value before, or at the start; 0 for a term.
    at : float
        Speed, period, or time of the change in s since the record's start; NaN for none.
    share : float
        Of the force that is its part of it, root mean square.
    explained : float
        Share of the residuals' sum of squares that it takes.
    p_value, score_p : float
        By Wald of the family, over all its candidates; of the score test of this one alone.
    """

    kind: Kind
    parameter: str
    values: tuple[float, ...]
    deviations: tuple[float, ...]
    before: float
    at: float
    share: float
    explained: float
    p_value: float
    score_p: float


def lacking(data: FilteredRecord, preferred: Estimate) -> tuple[Lack, ...] | Missing:
    """What the judged estimate's model lacks on a record, the strongest first."""
    x = examined(data, preferred)
    return x if isinstance(x, Missing) else found_on(x, data, preferred)


def found_on(x: ExaminedRows, data: FilteredRecord, preferred: Estimate) -> tuple[Lack, ...]:
    """`lacking` of rows."""
    names = tuple(q.name for q in preferred.quantities)
    values = dict(zip(names, map(float, preferred.theta), strict=True))
    again = WithNothingLacking(data, preferred, x)
    basis = _basis(np.column_stack([x.regressor, x.weights]))
    looked_for = [f for f in _looked_for(x, data, preferred) if not _is_declared(f, basis)]
    found: list[Lack] = []
    while looked_for and len(found) < _MOST:
        residuals = x.residuals - basis @ (basis.T @ x.residuals)
        one = _strongest(x, looked_for, basis, residuals, values, again)
        if one is None:
            break
        family, number, lack = one
        found.append(lack)
        looked_for = [f for f in looked_for if not family.tells(f)]
        basis = _basis(np.column_stack([basis, family.columns(number)]))
    return tuple(found)


def _looked_for(x: ExaminedRows, data: FilteredRecord, preferred: Estimate) -> list[Family]:
    """The families of rows of a record, or of loops that are measured as it is."""
    axis, names = data.axis.axis, tuple(q.name for q in preferred.quantities)
    drive = axis.drive
    commanded = data.record.force is None and drive.is_gain and not drive.logs_what_acts
    return families(x, names, terms_for(axis, commanded=commanded))


def _is_declared(family: Family, basis: Array) -> bool:
    """Whether it is friction that the model has, but for where its loop turns."""
    if family.kind not in PLAIN:
        return False
    column = family.columns(0)
    own = column - basis @ (basis.T @ column)
    return bool(np.linalg.norm(own) < MIN_OWN_PART_OF_PLAIN.value * np.linalg.norm(column))


def _strongest(
    x: ExaminedRows,
    looked_for: Sequence[Family],
    basis: Array,
    residuals: Array,
    values: Mapping[str, float],
    again: "WithNothingLacking",
) -> tuple[Family, int, Lack] | None:
    """The largest of what is discovered, with its family and its number there."""
    tested = [
        _tested(x, family, number, basis, residuals, values)
        for family, number in _ranked(looked_for, basis, residuals)
    ]
    least = _discovered([lack.p_value for *_, lack in tested], len(looked_for))
    for family, number, lack in tested:
        large = lack.share >= MIN_MISSING_FORCE.value
        if not (large and lack.p_value <= least and _is_confirmed(lack) and _is_possible(lack)):
            continue
        taken = lack.explained * float(residuals @ residuals)
        if taken > MIN_STEPS_EXCESS.value * again.taken_by(family):
            return family, number, lack
    return None


def _is_possible(lack: Lack) -> bool:
    """Whether it has the sign that it must have, and is most of what is left if it is the last.

    Of friction, of a load behind a spring.
    """
    if lack.parameter:
        return True
    term = OF_KIND[lack.kind]
    enough = lack.explained >= MIN_EXPLAINED_BY_LAST.value or not term.is_last
    return enough and (lack.values[0] > 0 or not term.is_positive)


def _is_confirmed(lack: Lack) -> bool:
    """Whether the score test confirms what is lacking, or has nothing else left to be told by."""
    return lack.score_p <= MAX_SCORE_CHANCE.value or lack.explained > MAX_SHARE_TO_DOUBT.value


def _ranked(
    looked_for: Sequence[Family], basis: Array, residuals: Array
) -> list[tuple[Family, int]]:
    """The best of each family by its gain, of those that take enough to be told."""
    least = MIN_EXPLAINED_SHARE.value * float(residuals @ residuals)
    best = [(family, *family.best(basis, residuals)) for family in looked_for]
    best.sort(key=lambda each: -each[1])
    return [(family, number) for family, gain, number in best if gain > least]


def _tested(
    x: ExaminedRows,
    family: Family,
    number: int,
    basis: Array,
    residuals: Array,
    values: Mapping[str, float],
) -> tuple[Family, int, Lack]:
    """The best candidate of a family, between the places of the grid too, as what is lacking."""
    near = family.finer(number)
    if near is not family:
        _, number = near.best(basis, residuals)
    columns = near.columns(number)
    own = columns - basis @ (basis.T @ columns)
    found = factors(own, residuals, x.neighbours)
    lack = Lack(
        kind=family.kind,
        parameter=family.parameter,
        values=tuple(map(float, found.values)),
        deviations=tuple(map(float, found.deviations)),
        before=_before(x, columns, found.values, family.parameter, values),
        at=near.at(number, basis, residuals),
        share=float(np.linalg.norm(columns @ found.values) / np.linalg.norm(x.left)),
        explained=float(np.sum((own @ found.values) ** 2) / (residuals @ residuals)),
        p_value=family.chance(found.wald_p),
        score_p=found.score_p,
    )
    return near, number, lack


def _before(
    x: ExaminedRows, columns: Array, factor: Array, parameter: str, values: Mapping[str, float]
) -> float:
    """What a parameter is where its further column is zero: the estimate is in between."""
    if not parameter:
        return 0.0
    model = np.column_stack([x.regressor, x.weights])
    taken = np.linalg.lstsq(model, columns @ factor, rcond=None)[0]
    return values[parameter] - float(taken[list(values).index(parameter)])


class WithNothingLacking:
    """Rows of loops that lack nothing, measured as the record is: what is found there is no lack.

    Noise that shakes friction, and an encoder's steps, leave what looks like a term. The loops are
    simulated when something is about to be told, and no more of them where the first leaves little.
    """

    def __init__(self, data: FilteredRecord, preferred: Estimate, x: ExaminedRows) -> None:
        self._data, self._preferred, self._x = data, preferred, x

    def taken_by(self, family: Family) -> float:
        """The most that a family's best takes of what is left there, as a sum of squares."""
        same = (family.kind, family.parameter)
        return max((taken.get(same, 0.0) for taken in self._gains), default=0.0)

    @cached_property
    def _gains(self) -> list[dict[tuple[Kind, str], float]]:
        """What the best of each family takes, loop by loop."""
        least = MIN_EXPLAINED_SHARE.value * float(self._x.residuals @ self._x.residuals)
        found: list[dict[tuple[Kind, str], float]] = []
        for x in examined_again(self._data, self._preferred):
            basis = _basis(np.column_stack([x.regressor, x.weights]))
            residuals = x.residuals - basis @ (basis.T @ x.residuals)
            if not float(residuals @ residuals) > least:
                break
            looked_for = _looked_for(x, self._data, self._preferred)
            gains = {(f.kind, f.parameter): f.best(basis, residuals)[0] for f in looked_for}
            found.append(gains)
        return found


@dataclass(frozen=True, slots=True, kw_only=True)
class Factors:
    """Factors of columns in residuals.

    Attributes
    ----------
    values, deviations : (g,) arrays
    wald_p, score_p : float
        P-values with the HAC covariance of the residuals that the columns leave, and of those
        without the columns. The first sees what stands out; the second is not misled where a few
        rows are followed closely.
    """

    values: Array
    deviations: Array
    wald_p: float
    score_p: float


def factors(own: Array, residuals: Array, neighbours: Neighbours) -> Factors:
    """Factors of columns (n, g), orthogonal to those that the residuals (n,) are of."""
    inverse = np.linalg.inv(own.T @ own)
    influence = own @ inverse
    values = influence.T @ residuals
    wald_p, covariance = _chance(influence, residuals - own @ values, values, neighbours)
    score_p, _ = _chance(influence, residuals, values, neighbours)
    deviations = np.sqrt(np.diag(covariance))
    return Factors(values=values, deviations=deviations, wald_p=wald_p, score_p=score_p)


def _chance(
    influence: Array, residuals: Array, values: Array, neighbours: Neighbours
) -> tuple[float, Array]:
    """P-value of factors under the HAC covariance of residuals, and that."""
    # Columns that the fit did not take: the kernel alone. Of residuals that they are taken of it is
    # too small on short records (Wald: 4 to 51 % at 5 %), of those without it is not (score: 0 to
    # 9 %), which is why both are asked.
    scores = influence * residuals[:, None]
    run = Hac().long_run(partial(score_products, scores, neighbours), len(residuals))
    square = float(values @ np.linalg.solve(run.covariance, values))
    return joint_p(square, len(values), float(np.min(run.freedom))), run.covariance


def _discovered(p_values: Sequence[float], tests: int) -> float:
    """The largest p-value that is a discovery among so many tests, 0 for none.

    References
    ----------
    [BenjaminiYekutieli2001]_
    """
    dependence = sum(1 / i for i in range(1, tests + 1))
    step = FALSE_DISCOVERY_RATE.value / (tests * dependence)
    return max((p for i, p in enumerate(sorted(p_values), 1) if p <= i * step), default=0.0)


def _basis(columns: Array) -> Array:
    """What columns span; a term that these rows do not show, as of an end stop, spans nothing."""
    sizes = np.linalg.norm(columns, axis=0)
    shown = columns[:, sizes > 0] / sizes[sizes > 0]
    return np.asarray(np.linalg.qr(shown)[0], dtype=float)
