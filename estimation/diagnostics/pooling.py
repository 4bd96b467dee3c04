"""Whether several records are of one machine, or one differs from the rest by more than chance.

A record gets parameters of its own beside those of all: its columns of them, zero in every other
record, are added to the estimate, which is solved once more. What is found of them is the record's
difference from the others; its covariance is that of twins, and without them HAC for rows, and for
a fit that of its errors. ``d' V^-1 d`` is held against Hotelling's distribution with the degrees of
freedom of that. One that is odd makes the others differ from a rest that it is part of, by less:
that which differs most is named, with the parameters that differ by themselves, or all where only
together they do.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import stdtr

from axisid.estimation.estimates import Estimate, estimate_of_record
from axisid.estimation.estimation_problem import Problem
from axisid.estimation.regression import (
    CovarianceEstimate,
    Hac,
    checked_columns,
    factor,
    hotelling_p_value,
    instrumental_variables,
    wald,
)
from axisid.estimation.thresholds import MIN_ROWS_PER_PARAMETER
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Check, Levels
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError, Missing, first_case, unless_missing

_OWN_PART = 1e-3  # of a column, below which others span it: slopes by differences are as exact
_FEWEST = 5.0  # degrees of freedom from which scores tell what is chance
_LOAD_UNITS = ("kg", "kg m^2", "kg*m^2")


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordRegressor:
    """What a record has of an estimate's rows, by parameters that may be its own.

    Attributes
    ----------
    names, units : tuple of str
        Of its p parameters.
    values : (p,) array
        As all records have them.
    slopes : (p, k) array
        Of those by the parameters of all.
    span : slice
        Its rows.
    columns, instruments : (n, p) array
        There.
    size : float
        Norm of what their part is told of.
    every : int
        How many of these rows say as much as one whose neighbours are independent of it.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    slopes: Array
    span: slice
    columns: Array
    instruments: Array
    size: float
    every: int = 1

    @property
    def independent_rows(self) -> int:
        """Rows that tell a parameter, each as much as one beside independent neighbours."""
        return int(np.count_nonzero(self.instruments.any(axis=1))) // self.every


#: An estimate of all, once more with further columns and their instruments, (N, q) each: its change
#: from the estimate of all, and from zero, (m,), and the covariance and the degrees of freedom of
#: that, (m, m) and (m,).
Solved = Callable[[Array, Array], tuple[Array, Array, Array]]


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordDifference:
    """A record alone beside the others, in the parameters that both tell.

    Attributes
    ----------
    own : mapping of str to float
        As the record alone has them, SI.
    common : mapping of str to float
        As the others have them without it, SI.
    deviations : mapping of str to float
        Of the difference, as twins scatter, or HAC.
    statistic : float
        Hotelling's, over its degrees of freedom.
    freedom : (float, float)
        Of F.
    p_value : float
        That chance alone makes as much, of one record.
    share_percent : float
        What the difference makes, percent of the record's force, or of what the largest parameter
        makes of its output.
    untold : tuple of str
        Parameters that the record alone does not tell.
    units : mapping of str to str
    shares : mapping of str to float
        What each parameter's difference makes, of the same.
    """

    own: Mapping[str, float]
    common: Mapping[str, float]
    deviations: Mapping[str, float]
    statistic: float
    freedom: tuple[float, float]
    p_value: float
    share_percent: float
    untold: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    shares: Mapping[str, float] = field(default_factory=dict)

    @property
    def distances(self) -> dict[str, float]:
        """Of the record's own from the others, in deviations of the difference."""
        return {n: (own - self.common[n]) / self.deviations[n] for n, own in self.own.items()}

    def matters(self, levels: Levels) -> bool:
        """Whether it is beyond chance, and makes any force to speak of."""
        return self.p_value < levels.level and self.share_percent > 100 * levels.least_share

    def differing(self, levels: Levels) -> tuple[str, ...]:
        """Parameters that differ by themselves, and matter: all where none does.

        By Bonferroni's rule, and by what each makes.
        """
        q, freedom = len(self.own), sum(self.freedom) - 1
        chances = {n: 2 * q * float(stdtr(freedom, -abs(d))) for n, d in self.distances.items()}
        beyond = (n for n, p in chances.items() if p < levels.level)
        return tuple(n for n in beyond if self.shares[n] > levels.least_share) or tuple(self.own)

    def told(self, names: Sequence[str], whose: str, rest: str) -> str:
        """What parameters are in the record and in the others."""
        first, *further = (
            f"{n} is {self.own[n]:.4g} {self.units[n]} in {whose} and {self.common[n]:.4g} in "
            f"{rest} ({self.own[n] - self.common[n]:+.2g} +- {self.deviations[n]:.1g})"
            for n in names
        )
        load = ", as under another load" * any(self.units[n] in _LOAD_UNITS for n in names)
        return ", ".join([first, *further]) + load


def difference_of(
    units: Mapping[str, str],
    common: Array,
    difference: Array,
    covariance: Array,
    freedom: float,
    effects: Array,
    untold: Sequence[str] = (),
) -> RecordDifference:
    """What a record has more of its q parameters than the others, and the test of that.

    Parameters
    ----------
    units : mapping of str to str
        Of the q parameters, by name.
    common, difference : (q,) array
        As the others have them, and what the record has more.
    covariance : (q, q) array
        Of the difference.
    freedom : float
        Of that.
    effects : (n, q) array
        What each parameter's difference makes of the output, by the size of that.
    untold : sequence of str
        As of `RecordDifference`.
    """
    q, square = len(difference), wald(difference, covariance)[0]
    return RecordDifference(
        own=dict(zip(units, common + difference, strict=True)),
        common=dict(zip(units, common, strict=True)),
        deviations=dict(zip(units, np.sqrt(np.maximum(np.diag(covariance), 0.0)), strict=True)),
        statistic=square / q,
        freedom=(float(q), freedom - q + 1),
        p_value=hotelling_p_value(square, q, freedom),
        share_percent=100 * float(np.linalg.norm(effects.sum(axis=1))),
        untold=tuple(untold),
        units=units,
        shares=dict(zip(units, np.linalg.norm(effects, axis=0).tolist(), strict=True)),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class PoolingTest:
    """Whether several records may be pooled: each against the others.

    Attributes
    ----------
    records : tuple of RecordDifference or Missing
        By record: beside all of the others; missing where one alone does not tell the parameters.
    odd : int or None
        The record that differs most, one that makes any force to speak of first; None where chance
        explains all.
    p_value : float
        The least of them, allowed for their number.
    """

    records: tuple[RecordDifference | Missing, ...]
    odd: int | None
    p_value: float


def pooling_test(
    problem: Problem, estimate: Estimate, levels: Levels = DEFAULT_LEVELS
) -> PoolingTest | Missing:
    """Hold each record against the others, by the rows of an estimate of all.

    Chance is what twins of the records make of them, or HAC of too few.
    """
    if estimate.is_direct:
        return Missing("the rows of a direct model are accelerations")
    if estimate.counts is not None:
        return Missing("rows count by residuals, in a record alone by others than in all of them")
    weights, inference = estimate.weights, estimate.inference
    residuals, common = inference.twins_residuals, inference.twin_errors
    X, Z = (weights[:, None] * each for each in (estimate.X, estimate.score_columns))

    def extended(columns: Array, instruments: Array) -> tuple[Array, Array, Array]:
        names = [
            *(q.label for q in estimate.form.quantities),
            *["a record's own"] * columns.shape[1],
        ]
        solution = instrumental_variables(
            weights * estimate.net_residuals,
            checked_columns(np.hstack([X, columns]), names, neighbours=estimate.neighbours),
            factor(np.hstack([Z, instruments]), names),
        )
        by_twins = None
        if residuals is not None and common is not None:
            moved = solution.influence.T @ (weights[:, None] * residuals)
            # Twins' residuals are beside what each of them has in common, which scatters too.
            moved[: common.shape[1]] += common.T
            by_twins = covariance_of_twins(moved, columns.shape[1])
        applied = by_twins or Hac().applied(solution)
        return solution.theta, applied.matrix, applied.freedom

    parts = [estimate_of_record(estimate, problem, i) for i in range(len(problem.spans))]
    records = [
        RecordRegressor(
            names=tuple(q.name for q in part.quantities),
            units=tuple(q.unit for q in part.quantities),
            values=part.corrected,
            slopes=estimate.form.record_jacobian(number),
            span=span,
            columns=weights[span, None] * part.X,
            instruments=weights[span, None] * part.score_columns,
            size=float(np.linalg.norm(weights[span] * part.y)),
        )
        for number, (span, part) in enumerate(zip(problem.spans, parts, strict=True))
    ]
    return pooling_test_of(Z, records, extended, levels)


def covariance_of_twins(moved: Array, columns: int) -> CovarianceEstimate | None:
    """Covariance of an estimate by what twins make of it, (m, R); None of too few.

    Parameters
    ----------
    moved : (m, R) array
    columns : int
        Parameters that are held against zero.
    """
    pairs = moved.shape[1] / 2  # opposite twins are one sample
    if pairs - columns + 1 < _FEWEST:
        return None
    return CovarianceEstimate(
        matrix=np.atleast_2d(np.cov(moved)), freedom=np.full(len(moved), pairs)
    )


def pooling_test_of(
    instruments: Array,
    records: Sequence[RecordRegressor],
    extended: Solved,
    levels: Levels = DEFAULT_LEVELS,
) -> PoolingTest | Missing:
    """Hold each record against the others.

    Parameters
    ----------
    instruments : (N, k) array
        Of the parameters of all records: what residuals are without.
    records : sequence of RecordRegressor
    extended : callable
        Solves the estimate of all once more, see `Solved`.
    levels : Levels
    """
    found = tuple(_tested(instruments, records, extended, i) for i in range(len(records)))
    tests = {i: each for i, each in enumerate(found) if isinstance(each, RecordDifference)}
    if not tests:
        return next(each for each in found if isinstance(each, Missing))
    # Bonferroni's; of two records there is one difference, which both tests are of.
    number = len(tests) if len(found) > 2 else 1
    odd = min(
        [i for i, each in tests.items() if number * each.p_value < levels.level],
        key=lambda i: (not tests[i].matters(levels), tests[i].p_value, -tests[i].statistic),
        default=None,
    )
    least = min(each.p_value for each in tests.values())
    return PoolingTest(records=found, odd=odd, p_value=min(1.0, number * least))


@unless_missing
def pooling_check(
    found: PoolingTest,
    names: Sequence[str],
    levels: Levels = DEFAULT_LEVELS,
    output: str = "force",
) -> Check:
    """Whether the records are alike, as a check; each record has a name."""
    untold = "; ".join(
        f"{name} alone would not tell {'them' if isinstance(e, Missing) else ', '.join(e.untold)}"
        for name, e in zip(names, found.records, strict=True)
        if isinstance(e, Missing) or e.untold
    )
    odd = None if found.odd is None else found.records[found.odd]
    fails, said, advice = False, "", ""
    if found.odd is not None and isinstance(odd, RecordDifference):
        whose, fails, differing = names[found.odd], odd.matters(levels), odd.differing(levels)
        rest, lead = "the rest", f"{whose} speaks against the rest"
        if len(names) == 2:
            rest, lead = names[1 - found.odd], f"{' and '.join(names)} speak against one another"
        said = f"{lead}: {odd.told(differing, whose, rest)}"
        advice = (
            "; say what is known to differ, as a payload that the axis declares (known "
            f"NAME=V1,V2), or let each record have its own (local {','.join(differing)})"
        )
    meaning = first_case(
        (
            fails,
            f"{said}. What is estimated of all is no record's, nor need the other parameters be",
        ),
        (
            odd,
            "the records differ by more than chance, in what makes less than "
            f"{100 * levels.least_share:g} % of the {output}: {said}",
        ),
        (True, "each record alone would give the same parameters, but for chance"),
    )
    return Check(
        name="records alike",
        status="fail" if fails else "note" if odd else "pass",
        figure=max(e.share_percent for e in found.records if isinstance(e, RecordDifference)),
        threshold=100 * levels.least_share,
        p_value=found.p_value,
        source=f"percent of a record's {output} that the parameters it has alone make otherwise "
        "than those of the others; fails where that is more, and chance would make as much in less "
        f"than {100 * levels.level:g} % (Hotelling's test, allowed for the number of records)",
        meaning=f"{meaning}{f' ({untold})' * bool(untold)}{advice * fails}",
    )


def _tested(
    base: Array, records: Sequence[RecordRegressor], extended: Solved, number: int
) -> RecordDifference | Missing:
    """A record against the others."""
    record = records[number]
    around = (record.span.start, len(base) - record.span.stop), (0, 0)
    X, Z = (np.pad(each, around) for each in (record.columns, record.instruments))
    shown = _independent(Z, base[:, :0])
    if not (own := [shown[j] for j in _independent(Z[:, shown], base)]):
        return Missing("this record tells no parameter that it shares with the others")
    # An estimate follows few rows, so that what is left of them does not tell what is chance.
    needed = MIN_ROWS_PER_PARAMETER.value * len(own)
    others = sum(each.independent_rows for each in records if each is not record)
    for whose, rows in (("this record has", record.independent_rows), ("the others have", others)):
        if rows < needed:
            return Missing(
                f"{whose} {rows} rows for {len(own)} parameters, and {needed:g} are needed to "
                "compare the records; record a longer motion"
            )
    try:
        change, covariance, dof = extended(X[:, own], Z[:, own])
    except EstimationError as error:
        return Missing(str(error))
    q, freedom = len(own), float(np.min(dof[-len(own) :]))
    if freedom - q + 1 < _FEWEST:
        return Missing("too few of the residuals are independent to tell what is chance")
    return difference_of(
        {record.names[j]: record.units[j] for j in own},
        record.values[own] + record.slopes[own] @ change[:-q],
        change[-q:],
        covariance[-q:, -q:],
        freedom,
        record.columns[:, own] * change[-q:] / (record.size or 1.0),
        [name for j, name in enumerate(record.names) if j not in shown],
    )


def _independent(columns: Array, beside: Array) -> list[int]:
    """Which columns neither others nor those before them span."""
    every = np.hstack([beside, columns])
    sizes = np.linalg.norm(every, axis=0)
    own = np.diag(np.linalg.qr(every / np.where(sizes > 0, sizes, 1.0), mode="r"))
    return [*map(int, np.flatnonzero(np.abs(own[beside.shape[1] :]) > _OWN_PART))]
