"""Test of several records for equal parameters: each record against the others.

The record gets parameters of its own in addition to the common ones: the columns of its rows, with
zeros in the rows of every other record, are added to the regressor, and the estimate is solved
again. The added parameters are the difference d between the record and the others. The covariance V
of the difference is that of simulated replicas; without replicas it is HAC for a regression, and
that of the errors for a fit. ``d' V^-1 d`` is compared with Hotelling's distribution with the
degrees of freedom of the covariance.

A record with other parameters makes the remaining records differ too, by less, because it is among
the records that they are compared with. Only the record that differs most is named, with the
parameters that differ significantly alone, or with all parameters where they differ significantly
only together.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
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
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Check, Levels, Status
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing, unless_missing

from .pooling_findings import (
    ComparedRecords,
    DifferingParameter,
    OddRecord,
    UnidentifiedInRecord,
)

# norm of the part of a column, of norm 1, that other columns do not explain; with less, the column
# counts as a combination of the others, because numerical slopes have this accuracy
_MIN_OWN_PART = 1e-3
_MIN_FREEDOM = 5.0  # degrees of freedom that a covariance needs
_LOAD_UNITS = ("kg", "kg m^2", "kg*m^2")  # units of a mass or an inertia


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordRegressor:
    """Rows of one record in an estimate of several, with columns for parameters of its own.

    Attributes
    ----------
    names, units : tuple of str
        Names and units of the p parameters that act in the record.
    values : (p,) array
        Estimates of these parameters from all records.
    slopes : (p, k) array
        Derivatives of these values by the k common parameters.
    span : slice
        Rows of the record among those of all records.
    columns, instruments : (n, p) array
        Columns of the parameters and their instruments in these rows.
    size : float
        Norm of the output in these rows, to which effects of parameters are relative.
    every : int
        Number of rows that carry as much information as one independent row.
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
        """Number of independent rows with information on a parameter."""
        return int(np.count_nonzero(self.instruments.any(axis=1))) // self.every


#: Function that solves the common estimate again with q further columns and their instruments,
#: (N, q) each. It returns the changes of the common parameters followed by the q added parameters,
#: (m,), their covariance, (m, m), and its degrees of freedom, (m,).
Solved = Callable[[Array, Array], tuple[Array, Array, Array]]


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordDifference:
    """Difference of a record from the others, in the parameters that both identify.

    Attributes
    ----------
    own : mapping of str to float
        Estimates from the record alone, SI.
    common : mapping of str to float
        Estimates from the others without it, SI.
    deviations : mapping of str to float
        Standard errors of the difference, by simulated replicas or HAC.
    statistic : float
        Hotelling's statistic divided by its degrees of freedom.
    freedom : (float, float)
        Degrees of freedom of the F distribution.
    p_value : float
        Probability of such a difference by chance, for one record.
    share_percent : float
        Effect of the difference on the force in percent of the force of the record; for a fit, in
        percent of the effect of the largest parameter on the output.
    untold : tuple of str
        Parameters that the record alone does not identify.
    units : mapping of str to str
        Units of the parameters.
    shares : mapping of str to float
        Effect of the difference of each parameter, as a fraction of the quantity of
        `share_percent`.
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
        """Difference of the record from the others by parameter, in standard errors."""
        return {n: (own - self.common[n]) / self.deviations[n] for n, own in self.own.items()}

    def matters(self, levels: Levels) -> bool:
        """Return True if the difference is significant and its effect is relevant."""
        return self.p_value < levels.level and self.share_percent > 100 * levels.least_share

    def differing(self, levels: Levels) -> tuple[str, ...]:
        """Return the names of parameters whose difference is significant and relevant.

        Significance is by Student's distribution with Bonferroni's rule, relevance by the effect of
        the parameter on the output. All parameters are returned if none is both.
        """
        q, freedom = len(self.own), sum(self.freedom) - 1
        found = list[str]()
        for name, distance in self.distances.items():
            p_value = 2 * q * float(stdtr(freedom, -abs(distance)))
            if p_value < levels.level and self.shares[name] > levels.least_share:
                found.append(name)
        return tuple(found) or tuple(self.own)

    def parameters(self, names: Iterable[str]) -> tuple[DifferingParameter, ...]:
        """Return the named parameters with the estimates of the record and of the others."""
        found = list[DifferingParameter]()
        for name in names:
            found.append(
                DifferingParameter(
                    name=name,
                    own=float(self.own[name]),
                    common=float(self.common[name]),
                    standard_error=float(self.deviations[name]),
                    unit=self.units[name],
                    is_load=self.units[name] in _LOAD_UNITS,
                )
            )
        return tuple(found)


def difference_of(
    units: Mapping[str, str],
    common: Array,
    difference: Array,
    covariance: Array,
    freedom: float,
    effects: Array,
    untold: Sequence[str] = (),
) -> RecordDifference:
    """Return the difference of a record from the others in q parameters, with its test.

    Parameters
    ----------
    units : mapping of str to str
        Units of the q parameters, by name.
    common, difference : (q,) array
        Estimates from the others, and estimates from the record minus these.
    covariance : (q, q) array
        Covariance of the difference.
    freedom : float
        Degrees of freedom of the covariance.
    effects : (n, q) array
        Effect of the difference of each parameter on the output, relative to the norm of the
        output.
    untold : sequence of str
        Parameters that the record alone does not identify.
    """
    q, square = len(difference), wald(difference, covariance)[0]
    return RecordDifference(
        own=dict(zip(units, (common + difference).tolist(), strict=True)),
        common=dict(zip(units, common.tolist(), strict=True)),
        deviations=dict(
            zip(units, np.sqrt(np.maximum(np.diag(covariance), 0.0)).tolist(), strict=True)
        ),
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
    """Test of several records for equal parameters.

    Attributes
    ----------
    records : tuple of RecordDifference or Missing
        Difference of each record from all others; Missing, with the reason, for a record that
        cannot be compared.
    odd : int or None
        Index of the record that differs most, of those with a relevant effect if there are any;
        None where all differences are within chance.
    p_value : float
        Smallest p-value of all records, corrected for the number of records.
    """

    records: tuple[RecordDifference | Missing, ...]
    odd: int | None
    p_value: float


def pooling_test(
    problem: Problem, estimate: Estimate, levels: Levels = DEFAULT_LEVELS
) -> PoolingTest | Missing:
    """Return the test of each record against the others, by the rows of the common estimate.

    The covariance is that of simulated replicas, or HAC where there are too few. Missing for a
    direct model, and with a robust loss.

    Parameters
    ----------
    problem : Problem
        Several records.
    estimate : Estimate
        Common estimate from all records.
    levels : Levels
    """
    if estimate.is_direct:
        return Missing(
            "the rows of a direct model are accelerations, but records are compared by their forces"
        )
    if estimate.counts is not None:
        return Missing(
            "with this loss the weights of the rows depend on the residuals, which differ between "
            "one record and all records"
        )
    weights, inference = estimate.weights, estimate.inference
    residuals, common = inference.twins_residuals, inference.twin_errors
    X, Z = (weights[:, None] * each for each in (estimate.X, estimate.score_columns))

    def extended(columns: Array, instruments: Array) -> tuple[Array, Array, Array]:
        """Solve the common estimate again with further columns, see `Solved`."""
        names = [q.label for q in estimate.form.quantities]
        names += ["a parameter of one record"] * columns.shape[1]
        solution = instrumental_variables(
            weights * estimate.net_residuals,
            checked_columns(np.hstack([X, columns]), names, neighbours=estimate.neighbours),
            factor(np.hstack([Z, instruments]), names),
        )
        # Covariance by replicas if there are enough, otherwise HAC.
        by_twins = None
        if residuals is not None and common is not None:
            moved = solution.influence.T @ (weights[:, None] * residuals)
            # The residuals are those with the estimate of each replica, whose errors are added.
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
    """Return the covariance of the estimates from simulated replicas; None for too few replicas.

    Parameters
    ----------
    moved : (m, R) array
        Errors of the m estimated parameters in each of R replicas.
    columns : int
        Number of parameters that are tested for zero.
    """
    pairs = moved.shape[1] / 2  # antithetic replicas are one sample
    if pairs - columns + 1 < _MIN_FREEDOM:
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
    """Return the test of each record against the others; Missing where no record can be tested.

    Parameters
    ----------
    instruments : (N, k) array
        Instruments of the common parameters, to which the residuals are orthogonal.
    records : sequence of RecordRegressor
    extended : callable
        Solves the common estimate again, see `Solved`.
    levels : Levels
    """
    found = tuple(_tested(instruments, records, extended, i) for i in range(len(records)))
    tests = {i: each for i, each in enumerate(found) if isinstance(each, RecordDifference)}
    if not tests:
        return next(each for each in found if isinstance(each, Missing))
    # Bonferroni's rule; two records have a single difference, so that both tests are the same.
    number = len(tests) if len(found) > 2 else 1
    # Of the significant differences, a relevant one with the smallest p-value.
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
    """Return the check that all records have the same parameters.

    It fails where a significant difference has a relevant effect; a significant difference without
    a relevant effect is a note.

    Parameters
    ----------
    found : PoolingTest
    names : sequence of str
        Names of the records.
    levels : Levels
    output : str
        Quantity that the estimate explains: ``force``, or ``output`` for a fit.
    """
    odd = _odd_record(found, names, levels)
    status: Status = "pass"
    if odd is not None:
        status = "fail" if odd.matters else "note"
    tests = [each for each in found.records if isinstance(each, RecordDifference)]
    largest = max(each.share_percent for each in tests)
    return Check(
        name="records alike",
        status=status,
        figure=largest,
        threshold=100 * levels.least_share,
        p_value=found.p_value,
        source="largest effect of the difference between the parameters of one record and those of "
        f"the others, in percent of the {output} of the record (rms). The check fails where an "
        "effect is above the threshold and the difference is significant at "
        f"{100 * levels.level:g} % (Hotelling's test, corrected for the number of records)",
        finding=ComparedRecords(
            odd=odd,
            largest_percent=largest,
            least_percent=100 * levels.least_share,
            output=output,
            unidentified=_unidentified(found, names),
        ),
    )


def _odd_record(found: PoolingTest, names: Sequence[str], levels: Levels) -> OddRecord | None:
    """Return the finding of the record that differs most; None where all agree within chance."""
    if found.odd is None:
        return None
    odd = found.records[found.odd]
    if isinstance(odd, Missing):
        return None
    return OddRecord(
        name=names[found.odd],
        other=names[1 - found.odd] if len(names) == 2 else None,
        parameters=odd.parameters(odd.differing(levels)),
        matters=odd.matters(levels),
    )


def _unidentified(found: PoolingTest, names: Sequence[str]) -> tuple[UnidentifiedInRecord, ...]:
    """Return the parameters that single records do not identify, for each such record."""
    unidentified = list[UnidentifiedInRecord]()
    for name, each in zip(names, found.records, strict=True):
        if isinstance(each, Missing):
            unidentified.append(UnidentifiedInRecord(record=name, parameters=()))
        elif each.untold:
            unidentified.append(UnidentifiedInRecord(record=name, parameters=each.untold))
    return tuple(unidentified)


def _tested(
    base: Array, records: Sequence[RecordRegressor], extended: Solved, number: int
) -> RecordDifference | Missing:
    """Return the difference of a record from the others, or the reason why it is unknown.

    Parameters
    ----------
    base : (N, k) array
        Instruments of the common parameters.
    records : sequence of RecordRegressor
    extended : callable
        Solves the common estimate again, see `Solved`.
    number : int
        Index of the record.
    """
    # Columns of the record among the rows of all records.
    record = records[number]
    around = (record.span.start, len(base) - record.span.stop), (0, 0)
    X, Z = (np.pad(each, around) for each in (record.columns, record.instruments))
    # Parameters that the record identifies alone, and of these the ones that other records share.
    shown = _independent(Z, base[:, :0])
    own = [shown[j] for j in _independent(Z[:, shown], base)]
    if not own:
        return Missing("this record identifies no parameter that it shares with the other records")
    # An estimate from few rows follows their noise, so that their residuals are too small.
    needed = MIN_ROWS_PER_PARAMETER.value * len(own)
    others = sum(each.independent_rows for each in records if each is not record)
    counts = (("this record has", record.independent_rows), ("the other records have", others))
    for subject, rows in counts:
        if rows < needed:
            return Missing(
                f"{subject} {rows} independent rows for {len(own)} parameters, and a comparison of "
                f"the records needs {needed:g}. Record a longer motion"
            )
    # The difference of the record from the others, with its covariance.
    try:
        change, covariance, dof = extended(X[:, own], Z[:, own])
    except EstimationError as error:
        return Missing(str(error))
    q, freedom = len(own), float(np.min(dof[-len(own) :]))
    if freedom - q + 1 < _MIN_FREEDOM:
        return Missing("too few residuals are independent for a covariance. Record a longer motion")
    return difference_of(
        {record.names[j]: record.units[j] for j in own},
        record.values[own] + record.slopes[own] @ change[:-q],
        change[-q:],
        covariance[-q:, -q:],
        freedom,
        record.columns[:, own] * change[-q:] / (record.size or 1.0),
        [name for j, name in enumerate(record.names) if j not in shown],
    )


def _independent(columns: Array, others: Array) -> list[int]:
    """Return the indices of the columns, (n, p), that are linearly independent.

    A column is not included if it is a combination of the `others`, (n, k), and of the columns
    before it.
    """
    every = np.hstack([others, columns])
    sizes = np.linalg.norm(every, axis=0)
    # Norm of the part of each column that is orthogonal to those before it.
    own = np.diag(np.linalg.qr(every / np.where(sizes > 0, sizes, 1.0), mode="r"))
    return [*map(int, np.flatnonzero(np.abs(own[others.shape[1] :]) > _MIN_OWN_PART))]
