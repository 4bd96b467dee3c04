"""Whether several records are of one machine, or one differs from the rest by more than chance.

The estimate from a record alone differs from that of all by ``d = (Z_i'X_i)^-1 Z_i' e_i`` with the
residuals of all, less what the filter alone leaves. To first order it is linear in the residuals of
every record, ``d = sum a_t e_t``, whose long-run covariance is the HAC one of all scores together;
none of it reaches from one record into another. ``d' V^-1 d`` is held against F with the degrees of
freedom that the covariance has. A record that differs most is put aside, and those that are left
are tested again: what one record does to the estimate of all would else speak against the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from axisid.estimation.checks import Check
from axisid.estimation.estimates import Estimate, part_of
from axisid.estimation.problems import Problem
from axisid.estimation.regression import (
    Hac,
    Solution,
    checked_columns,
    factor,
    instrumental_variables,
    joint_p,
)
from axisid.estimation.thresholds import MAX_RECORD_CHANCE, MIN_RECORD_DIRECTION, MIN_RECORD_SHARE
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy

from .differing import Difference, Differing

NAME = "records alike"


@dataclass(frozen=True, slots=True, kw_only=True)
class Apart:
    """One record beside the others.

    Attributes
    ----------
    names, units : tuple of str
        Of the parameters of the record's axis, length p.
    own, common : (p,) array
        As the record alone has them, and as the others have them with it.
    deviations : (p,) array
        Of the difference, HAC.
    statistic : float
        Wald's, over its degrees of freedom.
    freedom : (float, float)
        Of F.
    p_value : float
        That chance alone makes as much, of one record.
    share_percent : float
        Force that the difference makes, percent of the record's.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    own: Array
    common: Array
    deviations: Array
    statistic: float
    freedom: tuple[float, float]
    p_value: float
    share_percent: float

    def told(self) -> str:
        """The parameter that differs most, in words."""
        with np.errstate(all="ignore"):
            far = np.abs(self.own - self.common) / self.deviations
        j = int(np.argmax(np.nan_to_num(far)))
        return (
            f"{self.names[j]} = {self.own[j]:.4g} {self.units[j]} alone, "
            f"{self.common[j]:.4g} of all ({far[j]:.1f} deviations)"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Alike:
    """Several records, one against the others.

    Attributes
    ----------
    records : tuple of Apart or Missing
        By record: beside all of the others; missing where one alone does not tell the parameters.
    against : tuple of int
        Records that speak against the rest, the one that does most first.
    p_value : float
        The least of those that were tested first, allowed for their number.
    rejected : bool
        Whether chance explains it no more; then `against` may still be empty of differences that
        make no force to speak of.
    differing : Differing or None
        The parameters of the first that speaks against the rest that are not theirs; None where
        none is told.
    """

    records: tuple[Apart | Missing, ...]
    against: tuple[int, ...]
    p_value: float
    rejected: bool
    differing: Differing | None = None


def records_alike(problem: Problem, estimate: Estimate) -> Alike | Missing:
    """Hold each record against the others, by the method of an estimate of all."""
    if estimate.is_direct:
        return Missing("the rows of a direct model are accelerations")
    if estimate.counts is not None:
        return Missing("rows count by residuals, in a record alone by others than in all of them")
    try:
        rows = _OwnRows(problem, estimate)
    except EstimationError as error:
        return Missing.of(error.note)
    everyone = range(len(problem.data))
    first = tuple(rows.apart(i, everyone) for i in everyone)
    tested = [each for each in first if isinstance(each, Apart)]
    if not tested:
        return Missing("no record alone tells the parameters of its axis")
    left, against, found = [*everyone], list[int](), dict(enumerate(first))
    rejected = False
    while len(left) > 1:
        told = {i: each for i, each in found.items() if isinstance(each, Apart)}
        if not told:
            break
        worst = min(told, key=lambda i: (told[i].p_value, -told[i].statistic))
        if _allowed(told[worst].p_value, len(told)) >= MAX_RECORD_CHANCE.value:
            break
        rejected = True
        if told[worst].share_percent > MIN_RECORD_SHARE.value:
            against.append(worst)
        left.remove(worst)
        found = {i: rows.apart(i, left) for i in left} if len(left) > 1 else {}
    return Alike(
        records=first,
        against=tuple(against),
        p_value=_allowed(min(each.p_value for each in tested), len(tested)),
        rejected=rejected,
        differing=rows.differing(against[0], left) if against else None,
    )


def alike_check(found: Alike | Missing, names: Sequence[str]) -> Check | Missing:
    """Whether the records are alike, as a check; each record has a name."""
    if isinstance(found, Missing):
        return found
    untold = [n for n, each in zip(names, found.records, strict=True) if isinstance(each, Missing)]
    also = f" ({', '.join(untold)} alone would not tell them)" if untold else ""
    shares = [each.share_percent for each in found.records if isinstance(each, Apart)]
    return Check(
        name=NAME,
        status="fail" if found.against else "note" if found.rejected else "pass",
        figure=max(shares),
        threshold=MIN_RECORD_SHARE.value,
        p_value=found.p_value,
        source="percent of a record's force that the parameters it has alone make otherwise than "
        "those of all; fails where that is more, and chance would make as much in less than 1 % "
        "(Wald's test, HAC, allowed for the number of records)",
        meaning=_meaning(found, names) + also,
        remedy=_remedy(found),
    )


def _meaning(found: Alike, names: Sequence[str]) -> str:
    if not found.rejected:
        return "each record alone would give the same parameters, but for chance"
    if not found.against:
        return (
            "the records differ by more than chance, in what makes less than "
            f"{MIN_RECORD_SHARE.value:g} % of the force"
        )
    if len(names) == 2:
        lead = f"{names[0]} and {names[1]} speak against one another"
    else:
        of = " and ".join(names[i] for i in found.against)
        lead = f"{of} {'speaks' if len(found.against) == 1 else 'speak'} against the rest"
    differing, whose = found.differing, names[found.against[0]]
    if differing is not None:
        rest = next(n for n in names if n != whose) if len(names) == 2 else "the rest"
        return (
            f"{lead}: {differing.told(whose, rest)}. What is estimated of all is no record's, "
            "nor need the other parameters be"
        )
    first = found.records[found.against[0]]
    said = f": {whose} has {first.told()}" if isinstance(first, Apart) else ""
    return (
        f"{lead}{said}; check its load, its columns and what has changed, or declare what is each "
        "record's own or known of it"
    )


def _remedy(found: Alike) -> Remedy | None:
    if found.differing is None:
        return None
    return Remedy.of("; ", found.differing.remedy)


def _allowed(p_value: float, tests: int) -> float:
    """Bonferroni's; of two records there is one difference, which both tests are of."""
    return min(1.0, p_value * (tests if tests > 2 else 1))


class _OwnRows:
    """The rows of all records, weighted, and those of each in its own parameters."""

    def __init__(self, problem: Problem, estimate: Estimate) -> None:
        self._problem, self._estimate = problem, estimate
        weights = np.ones(len(estimate.y)) if estimate.weights is None else estimate.weights
        self._weights = weights
        self._X = estimate.X * weights[:, None]
        self._Z = estimate.score_columns * weights[:, None]
        self._residuals = estimate.net_residuals
        self._names = [q.label for q in estimate.form.quantities]
        self._parts = [part_of(estimate, problem, i) for i in range(len(problem.data))]

    def apart(self, record: int, others: Sequence[int]) -> Apart | Missing:
        """A record against those of a set that it is in."""
        try:
            return self._apart(record, others)
        except EstimationError as error:
            return Missing.of(error.note)

    def _apart(self, record: int, others: Sequence[int]) -> Apart:
        part = self._parts[record]
        inside = np.zeros(len(self._residuals), dtype=bool)
        for i in others:
            inside[self._problem.spans[i]] = True
        common, moved = self._common(inside)
        own = self._alone(part)
        to_own = self._estimate.form.slopes(record)
        span = self._problem.spans[record]
        # What all make of the record's parameters, and what the record alone makes of them.
        influence = -(common.influence @ to_own.T) * self._weights[:, None]
        influence[span] += own.influence
        solution = replace(common, influence=influence, residuals=moved)
        difference = influence.T @ moved
        # What parts the records is a direction that the fit of all did not take: the kernel alone.
        kernel = Hac(widened=False)
        applied = kernel.applied(solution)
        covariance, freedom = applied.matrix, float(np.min(applied.freedom))
        statistic, k = _wald(difference, covariance, kernel.matrix(own))
        base = part.corrected + to_own @ (common.influence.T @ (self._weights * moved))
        force = part.X @ difference
        return Apart(
            names=tuple(q.name for q in part.quantities),
            units=tuple(q.unit for q in part.quantities),
            own=base + difference,
            common=base,
            deviations=np.sqrt(np.maximum(np.diag(covariance), 0.0)),
            statistic=statistic / k,
            freedom=(float(k), max(freedom - k + 1, 1.0)),
            p_value=joint_p(statistic, k, freedom),
            share_percent=relative_error_percent(force, part.y),
        )

    def differing(self, record: int, others: Sequence[int]) -> Differing | None:
        """What of a record is otherwise than in others that it is not among."""
        try:
            return self._beside(record, others).explained()
        except EstimationError:
            return None

    def _beside(self, record: int, others: Sequence[int]) -> Difference:
        part, to_own = self._parts[record], self._estimate.form.slopes(record)
        inside = np.zeros(len(self._residuals), dtype=bool)
        for i in others:
            inside[self._problem.spans[i]] = True
        theirs, moved = self._common(inside)
        own = self._alone(part)
        influence = (theirs.influence @ to_own.T) * self._weights[:, None]
        change = theirs.influence.T @ (self._weights * moved)
        left = moved - np.where(inside, self._estimate.X @ change, 0.0)
        rest = replace(theirs, influence=influence, residuals=left)
        # Either is an estimate of its own rows.
        applied = Hac().applied(own), Hac().applied(rest)
        freedom = min(float(np.min(each.freedom)) for each in applied)
        return Difference(
            names=tuple(q.name for q in part.quantities),
            units=tuple(q.unit for q in part.quantities),
            own=part.corrected + own.influence.T @ part.net_residuals,
            others=part.corrected + influence.T @ moved,
            covariance=applied[0].matrix,
            others_covariance=applied[1].matrix,
            freedom=freedom,
            regressor=part.X,
            force=part.y,
        )

    def _common(self, inside: Array) -> tuple[Solution, Array]:
        """The solution of some records' rows: influence on the rows of all, and residuals there."""
        rows = np.flatnonzero(inside)
        neighbours = self._estimate.neighbours
        columns = checked_columns(self._X[rows], self._names, neighbours=neighbours[rows])
        instruments = factor(self._Z[rows], self._names)
        weighted = (self._residuals * self._weights)[rows]
        found = instrumental_variables(weighted, columns, instruments)
        influence = np.zeros_like(self._X)
        influence[rows] = found.influence
        residuals = np.where(inside, self._residuals, 0.0)
        whole = replace(found, influence=influence, residuals=residuals, neighbours=neighbours)
        return whole, residuals

    def _alone(self, part: Estimate) -> Solution:
        names = [q.label for q in part.quantities]
        span = part.net_residuals
        regressor = factor(part.X, names, neighbours=part.neighbours)
        Z = factor(part.score_columns, names)
        return instrumental_variables(span, regressor, Z)


def _wald(difference: Array, covariance: Array, alone: Array) -> tuple[float, int]:
    """``d' V^-1 d`` and its degrees of freedom, in the directions in which d has any variance.

    A record that alone tells a direction of the parameters has none there: it is what all have.
    """
    scale = np.sqrt(np.diag(alone))
    unit = np.outer(scale, scale)
    sizes, directions = np.linalg.eigh(covariance / unit)
    told = sizes > MIN_RECORD_DIRECTION.value * float(sizes.max(initial=0.0))
    parts = directions[:, told].T @ (difference / scale)
    return float(np.sum(parts**2 / sizes[told])), max(int(told.sum()), 1)
