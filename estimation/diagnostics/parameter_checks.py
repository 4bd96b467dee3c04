"""Checks of each parameter: its excitation, its precision, its bounds and its declared value.

They find too few rows, a value with a large standard error, a value beyond its bounds or of another
order of magnitude than its nominal value, a record that contradicts fixed values, and an identified
drive gain that differs from the declared gain.

A parameter is imprecise for one of two reasons: its column is nearly a combination of others, or
its part of the force is below the residual. Either may be due to a motion without a reversal, a
second speed, acceleration or travel.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.estimates import Estimate, Value, physical_parameters
from axisid.estimation.estimation_problem import (
    ParameterAtBound,
    Problem,
    SignalRanges,
    typical_magnitudes,
)
from axisid.estimation.findings import Finding
from axisid.estimation.regression import Equations, Form, InverseForm
from axisid.estimation.signals import (
    FilteredRecord,
    Signals,
    columns_by_signal,
    one_direction,
    one_speed,
    resting_axis,
)
from axisid.estimation.thresholds import (
    CHECK_LEVEL,
    MAX_RELATIVE_DEVIATION,
    MAX_VARIANCE_INFLATION,
    MIN_DISTANCE_FROM_NOISE,
    MIN_ROWS_PER_PARAMETER,
    NEGLIGIBLE_FORCE,
    NEGLIGIBLE_PEAK_FORCE,
)
from axisid.estimation.unknowns import GAIN
from axisid.estimation.verdict_checks import Check, status_of
from axisid.modeling.declaration import Drive
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array, MaybeInfinite
from axisid.support.missing import Missing

from .parameter_findings import (
    BeyondBounds,
    BoundsAdvice,
    FarFromNominal,
    FarFromNominalValues,
    FewRows,
    FixedAtBounds,
    FixedValue,
    FixedValues,
    IdentifiedGain,
    Obscurity,
    OutsideBounds,
    Precision,
    Unidentified,
    WithinBounds,
    finite,
    relative_error,
)

# weight of a column in a combination, relative to the largest, from which its parameter is named
_MIN_REPETITION_WEIGHT = 0.3
_MIN_ACCELERATION_SHARE = 0.05  # of the force; with less, the axis hardly accelerates
# variation of a column that depends on the position, relative to its largest value; with less, the
# position hardly changes
_MIN_POSITION_VARIATION = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Excitation:
    """Excitation of one parameter by the motion.

    Attributes
    ----------
    name : str
        Name of the parameter.
    share : float
        Norm of the parameter's part of the force relative to the norm of the force.
    inflation : float
        Variance inflation factor: 1 for a column that is orthogonal to all others, large for a
        column that is nearly a combination of others.
    alike : tuple of str
        The parameters whose columns this combination contains; empty where the inflation is small.
    lacking : tuple of str
        Signals of the parameter that the motion does not excite, as clauses such as ``the axis
        hardly accelerates``. They are the reason where the parameter is imprecise. A precise
        parameter has enough excitation by other signals, as a mass by its weight.
    rows : float
        Equivalent number of rows of equal weight: small where the term acts in few rows.
    largest_share : float
        Largest part of the force by the parameter anywhere along the record, relative to the
        largest force.
    natural : float
        Typical magnitude of a parameter with this unit, from force and motion, see
        `typical_magnitudes`.
    """

    name: str
    share: float
    inflation: MaybeInfinite
    alike: tuple[str, ...]
    lacking: tuple[str, ...]
    rows: float
    largest_share: float
    natural: float

    @property
    def obscurity(self) -> Obscurity:
        """Reason why the record does not identify the parameter; meant for an imprecise one."""
        if self.alike:
            return "repeated column"
        if self.rows < MIN_ROWS_PER_PARAMETER.value:
            return "few rows"
        if self.share >= 1:
            return "cancelled"
        return "below residual"


def excitation(problem: Problem, physical: Array) -> tuple[Excitation, ...]:
    """Return the excitation of every parameter by the motion of all records.

    It follows from the column of the parameter in the inverse model. The motion of several records
    lacks a signal only if every record lacks it.

    Parameters
    ----------
    problem : Problem
        All records, with their motion.
    physical : (p,) array
        Estimated physical parameters.
    """
    # Unweighted rows of all records together, and of each record.
    form = problem.form(InverseForm).at(physical)
    of_each = [form.of_record(i).equations(data.signals) for i, data in enumerate(problem.data)]
    equations = replace(problem, weights=()).reduced(form, [data.signals for data in problem.data])
    # Largest motion, force and columns of all records, with the columns of the joint form.
    motions = []
    for i, (data, own) in enumerate(zip(problem.data, of_each, strict=True)):
        columns = form.placed(i, own.intercept, own.regressor)[1]
        motions.append((data.signals, replace(own, regressor=columns), data.sampling.kept))
    ranges = SignalRanges.of(motions)
    # Columns of the joint form that each column of a record is part of.
    in_joint = [form.record_jacobian(i) != 0 for i in range(len(problem.data))]
    # Largest part of the force of each parameter along the record, and typical magnitudes.
    theta, names = form.regressed(physical), [q.name for q in form.quantities]
    largest_shares, magnitudes = np.zeros(len(names)), np.full(len(names), np.inf)
    if ranges is not None:
        largest_shares = np.abs(theta) * ranges.columns / ranges.force
        magnitudes = typical_magnitudes(problem.axis, ranges, form.declared)
    # For each signal, the columns of the joint form that depend on it in any record.
    of_records = [columns_by_signal(data.axis) for data in problem.data]
    needs = {}
    for signal in of_records[0]:
        in_records = [own[signal] @ m for own, m in zip(of_records, in_joint, strict=True)]
        needs[signal] = np.any(in_records, axis=0)
    # Records in which the axis hardly accelerates.
    X, weights = equations.regressor, problem.stacked(lambda data: data.sampling.weights)
    is_slow = [
        _inertial_share(form, i, data, own, theta) < _MIN_ACCELERATION_SHARE
        for i, (data, own) in enumerate(zip(problem.data, of_each, strict=True))
    ]
    # Excitation of each column: its size, the columns that it is a combination of, and the signals
    # that it lacks.
    size = np.linalg.norm(X, axis=0)
    unit = X / np.where(size > 0, size, 1.0)
    shares = np.abs(theta) * size / np.linalg.norm(equations.left)
    found = []
    for j, name in enumerate(names):
        inflation, partners, rows = _repetition(unit, j)
        lacking = [
            _lacking(data.signals, X / weights[:, None], slow, needs, [j, *partners])
            for data, slow in zip(problem.data, is_slow, strict=True)
        ]
        found.append(
            Excitation(
                name=name,
                share=float(shares[j]),
                inflation=inflation,
                alike=tuple(names[i] for i in partners),
                lacking=tuple(fact for fact in lacking[0] if all(fact in own for own in lacking)),
                rows=rows,
                largest_share=float(largest_shares[j]),
                natural=float(magnitudes[j]),
            )
        )
    return tuple(found)


def _repetition(unit: Array, j: int) -> tuple[float, list[int], float]:
    """Return the variance inflation of a column, the columns that it repeats, and its rows.

    The column is regressed on all others.

    Parameters
    ----------
    unit : (n, k) array
        Columns of norm 1.
    j : int
        Index of the column.

    Returns
    -------
    float
        Variance inflation factor; infinite for a column that is a combination of the others.
    list of int
        Indices of the columns with a large weight in this combination; empty where the inflation is
        small.
    float
        Equivalent number of rows of the part of the column that is orthogonal to the others: the
        inverse of the sum of the squared row weights.
    """
    others = [i for i in range(unit.shape[1]) if i != j]
    weights = np.linalg.lstsq(unit[:, others], unit[:, j], rcond=None)[0]
    residual = unit[:, j] - unit[:, others] @ weights
    unexplained = float(residual @ residual)
    inflation = 1 / unexplained if unexplained > 0 else np.inf
    rows = unexplained**2 / float(np.sum(residual**4)) if unexplained > 0 else 0.0
    if inflation < MAX_VARIANCE_INFLATION.value:
        return inflation, [], rows
    least = _MIN_REPETITION_WEIGHT * np.abs(weights).max(initial=0.0)
    partners = [i for i, weight in zip(others, weights, strict=True) if abs(weight) > least]
    return inflation, partners, rows


def _inertial_share(
    form: Form, record: int, data: FilteredRecord, moving_rows: Equations, theta: Array
) -> float:
    """Return the norm of the accelerating force of a record relative to that of the whole force.

    Both are forces of the model in the rows, including known terms. The accelerating force is the
    difference between the force and the force with an acceleration of 0.

    Parameters
    ----------
    form : Form
        Form of all records.
    record : int
        Index of the record.
    data : FilteredRecord
        The record.
    moving_rows : Equations
        Its equations along the motion.
    theta : (k,) array
        Regression parameters of all records.
    """

    def force(rows: Equations) -> Array:
        """Return the force of the model in the samples of the rows, (n,)."""
        intercept, columns = form.placed(record, rows.intercept, rows.regressor)
        return (intercept + columns @ theta)[data.sampling.kept]

    coasting = replace(data.signals, acceleration=np.zeros_like(data.signals.acceleration))
    moving, steady = force(moving_rows), force(form.of_record(record).equations(coasting))
    return float(np.linalg.norm(moving - steady) / np.linalg.norm(moving))


def _lacking(
    signals: Signals,
    X: Array,
    slow: bool,
    needs: dict[str, NDArray[np.bool_]],
    columns: Sequence[int],
) -> tuple[str, ...]:
    """Return the signals that a motion does not excite, as clauses; empty if nothing is missing.

    Only signals that the given columns depend on are named.

    Parameters
    ----------
    signals : Signals
        The motion of a record.
    X : (n, k) array
        Regressor of all records, without the weights of the rows.
    slow : bool
        Whether the axis hardly accelerates.
    needs : dict of str to (k,) array of bool
        For each signal, True for the columns that depend on it.
    columns : sequence of int
        Indices of the columns.
    """
    needed = {signal for signal, of in needs.items() if of[[*columns]].any()}
    # Columns of the position alone hardly vary.
    by_position = [
        X[:, j] for j in columns if needs["position"][j] and not needs["acceleration"][j]
    ]
    still = any(np.ptp(x) < _MIN_POSITION_VARIATION * np.abs(x).max() for x in by_position)
    # Each clause, empty for a motion that excites the signal, with the condition that it is needed.
    clauses = (
        ({"velocity", "direction"} & needed, one_direction(signals)),
        ("velocity" in needed, one_speed(signals)),
        (slow and "acceleration" in needed, "the axis hardly accelerates"),
        (still, "the axis hardly changes its position"),
    )
    return tuple(clause for is_needed, clause in clauses if is_needed and clause)


# size of an imprecise parameter, relative to the typical magnitude of its unit, below which the
# parameter is negligible
_NEGLIGIBLE_SIZE = 0.1
# ratio of a value to its nominal value, or its inverse, above which the value is reported
_MAX_FROM_NOMINAL = 5.0
NOMINAL_VALUES = "nominal values"
# ratio of identified to declared drive gain, or its inverse, from which the check fails: a known
# value belongs to another record
_MAX_GAIN_RATIO = 2.0


def rows_check(rows: int, parameters: int, samples_per_row: int | None = None) -> Check | None:
    """Return a failed check if the rows are too few for standard errors; None if they are enough.

    Parameters
    ----------
    rows, parameters : int
        Number of rows and of parameters.
    samples_per_row : int, optional
        For a fit: the number of samples that count as one row.
    """
    if rows >= MIN_ROWS_PER_PARAMETER.value * parameters:
        return None
    return Check(
        name="rows",
        status="fail",
        figure=rows / parameters,
        threshold=MIN_ROWS_PER_PARAMETER.value,
        source="rows for each parameter. The check fails below "
        f"{MIN_ROWS_PER_PARAMETER.value:g} rows, a chosen number: standard errors from fewer rows "
        "are unreliable",
        finding=FewRows(rows=rows, parameters=parameters, samples_per_row=samples_per_row),
    )


def precision(estimate: Estimate, excitation: Sequence[Excitation]) -> Check:
    """Return the check of every parameter against its standard error, with reasons.

    The check fails if the relative standard error of a parameter is too large. Parameters that are
    known to be negligible do not count. The excitation of a parameter by the motion gives the
    reason why it is imprecise.
    """
    # Standard error of each parameter, in percent of its value.
    values, relative = estimate.parameters, dict[str, float]()
    for s in excitation:
        value = values[s.name]
        # In few rows the residuals are small, because the estimate follows the noise.
        few = s.rows < MIN_ROWS_PER_PARAMETER.value
        deviation = max(value.deviation, value.sd) if few else value.deviation
        relative[s.name] = 100 * deviation / abs(value.corrected) if value.corrected else np.inf
    # Imprecise parameters: negligible and unidentified ones.
    imprecise = [s for s in excitation if relative[s.name] > MAX_RELATIVE_DEVIATION.value]
    small = [s for s in imprecise if _is_negligible(s, values[s.name])]
    unidentified = [s for s in imprecise if s not in small]
    others = [relative[s.name] for s in excitation if s not in small]
    finding = Precision(
        largest_percent=finite(max(others)) if others else None,
        has_others=bool(others),
        negligible=tuple(relative_error(s.name, relative[s.name]) for s in small),
        unidentified=_by_reason(unidentified, relative),
    )
    return precision_check(
        max(relative.values()),
        finding,
        "largest standard error in percent of the value of its parameter. The HAC standard error "
        "is used. For a parameter that acts in few rows, the i.i.d. standard error is used if it "
        "is larger. The check fails if a parameter exceeds the threshold, unless two conditions "
        "are met. (1) The part of the force by this parameter, with two standard errors added, is "
        "below 1 % (rms). (2) The value, with two standard errors added, is below a tenth of the "
        "magnitude that is usual for the unit of the parameter. This magnitude follows from force, "
        "travel and times of the record",
        passed=not unidentified,
    )


def _by_reason(
    unidentified: Iterable[Excitation], relative: Mapping[str, float]
) -> tuple[Unidentified, ...]:
    """Return the imprecise parameters, grouped by reason.

    Parameters of a group have the same kind of reason (`Excitation.obscurity`), repeat the columns
    of the same parameters (`alike`), and lack the same signals of the motion (`lacking`).

    Parameters
    ----------
    unidentified : iterable of Excitation
        Excitation of the imprecise parameters.
    relative : mapping of str to float
        Relative standard errors by name, %.
    """
    groups: dict[tuple[object, ...], list[Excitation]] = {}
    for s in unidentified:
        groups.setdefault((s.obscurity, s.alike, s.lacking), []).append(s)
    return tuple(
        Unidentified(
            parameters=tuple(relative_error(s.name, relative[s.name]) for s in group),
            reason=group[0].obscurity,
            alike=group[0].alike,
            rows=max(s.rows for s in group),
            lacking=group[0].lacking,
        )
        for group in groups.values()
    )


def precision_check(worst: float, finding: Finding, source: str, *, passed: bool) -> Check:
    """Return the check *precision* with a given finding.

    Parameters
    ----------
    worst : float
        Largest relative standard error, %, which is the figure of the check.
    finding : Finding
    source : str
        Definition of the figure and of its threshold, as text.
    passed : bool
        Whether the check passes; it fails otherwise.
    """
    return Check(
        name="precision",
        status=status_of(passed),
        figure=finite(worst),
        threshold=MAX_RELATIVE_DEVIATION.value,
        source=source,
        finding=finding,
    )


def _is_negligible(excitation: Excitation, value: Value) -> bool:
    """Return True for a parameter that is known to be negligible.

    Its part of the force, with two standard errors, must be small in the rows and along the record,
    and its value small for its unit. A parameter whose column repeats others, or that the motion
    does not excite, does not count: its force is small in this motion whatever its value is.

    Parameters
    ----------
    excitation : Excitation
        Excitation of the parameter.
    value : Value
        Its estimate.
    """
    if excitation.alike or excitation.lacking or not value.value:
        return False
    largest = abs(value.value) + 2 * max(value.deviation, value.sd)
    times = largest / abs(value.value)
    return (
        excitation.share * times < NEGLIGIBLE_FORCE.value
        and excitation.largest_share * times < NEGLIGIBLE_PEAK_FORCE.value
        and largest < _NEGLIGIBLE_SIZE * excitation.natural
    )


def within_bounds(
    estimate: Estimate,
    rest: float = 0.0,
    held: Sequence[ParameterAtBound] = (),
    *,
    explained_by_others: bool = False,
) -> Check | Missing:
    """Return the check of every parameter against its declared bounds.

    It fails if a value is at or beyond a bound. Physical parameters that follow from base
    parameters and known values are compared too. If no value fails but parameters are fixed at a
    bound, the check is that of `at_bound_check`. Missing if no parameter has bounds.

    Parameters
    ----------
    estimate : Estimate
    rest : float
        Part of the rows in which the axis rests, from 0 to 1.
    held : sequence of ParameterAtBound
        Parameters that the estimate does not have, because they are fixed at a bound.
    explained_by_others : bool
        Whether another candidate model explains more, so that this model lacks terms.
    """
    # Values of the estimated parameters, and of the physical parameters that follow from them.
    axis, values = estimate.form.axis, dict(estimate.parameters)
    physical = physical_parameters(estimate.method, estimate.form, estimate.distribution)
    if physical is not None:
        known = {p.name for p in axis.base.known}
        values |= {n: v for n, v in physical.parameters.items() if n not in {*values, *known}}
    # Parameters with bounds, and those that are at or beyond a bound.
    bounded = {p.name: p for p in (*axis.base.declared.parameters, *estimate.form.declared)}
    declared = [p for name, p in bounded.items() if p.is_bounded and name in values]
    outside = [p for p in declared if not p.lower < values[p.name].corrected < p.upper]
    if held and not outside:
        return at_bound_check(held, rest)
    if not declared:
        return Missing("no parameter is declared with bounds")
    if not outside:
        finding: Finding = WithinBounds(parameters=tuple(p.name for p in declared))
    else:
        # The likely cause to check.
        resting = resting_axis(rest)
        advice: BoundsAdvice = "rests" if resting else "signs, units and gain"
        if explained_by_others:
            advice = "other candidates explain more"
        if all(_reaches_within(p, values[p.name]) for p in outside):
            advice = "interval reaches within"
        finding = BeyondBounds(
            parameters=tuple(_outside(p, values[p.name]) for p in outside),
            advice=advice,
            rest=resting if advice == "rests" else None,
        )
    return Check(
        name="bounds",
        status=status_of(not outside),
        figure=float(len(outside)),
        threshold=0.0,
        source="number of parameters outside their declared physical bounds, or at a bound. The "
        "check fails above 0. The estimates themselves are not changed to fit their bounds",
        finding=finding,
    )


def _reaches_within(parameter: Parameter, value: Value) -> bool:
    """Return True if the 95 % interval of a value reaches within its bounds."""
    low, high = value.interval
    return bool(low < parameter.upper and high > parameter.lower)


def _outside(parameter: Parameter, value: Value) -> OutsideBounds:
    """Return the finding of a parameter beyond its bounds; its value is corrected for the bias."""
    return OutsideBounds(
        name=parameter.name,
        unit=parameter.unit,
        value=float(value.corrected),
        lower=float(parameter.lower),
        upper=float(parameter.upper),
        is_at_bound=bool(parameter.allows(value.corrected)),
    )


def at_bound_check(held: Sequence[ParameterAtBound], rest: float = 0.0) -> Check:
    """Return the check of parameters that are fixed at their bounds.

    It fails if a free estimate is farther beyond its bound than `MIN_DISTANCE_FROM_NOISE` standard
    errors; otherwise it is a note.

    Parameters
    ----------
    held : sequence of ParameterAtBound
        The fixed parameters, at least one.
    rest : float
        Part of the rows in which the axis rests, from 0 to 1.
    """
    farthest = max(each.distance for each in held)
    is_significant = farthest > MIN_DISTANCE_FROM_NOISE.value
    resting = resting_axis(rest) if is_significant else None
    advice: BoundsAdvice | None = None
    if is_significant:
        advice = "rests" if resting else "signs, units and model"
    return Check(
        name="bounds",
        status="fail" if is_significant else "note",
        figure=farthest,
        threshold=MIN_DISTANCE_FROM_NOISE.value,
        source="largest distance of a free estimate beyond the bound that its parameter is fixed "
        "at, in standard errors",
        finding=FixedAtBounds(
            parameters=tuple(held),
            distance=float(farthest),
            advice=advice,
            rest=resting,
        ),
    )


def fixed_check(estimate: Estimate, level: float = CHECK_LEVEL.value) -> Check | Missing | None:
    """Return the check of fixed values against the record, by Hotelling's test.

    It fails where the record contradicts the fixed values, or the restrictions that physical
    parameters impose on base parameters, at the significance level `level`. None where there are
    neither. Missing where the record alone does not determine the fixed values.
    """
    physical = physical_parameters(estimate.method, estimate.form, estimate.distribution)
    if physical is None or not (physical.known or physical.dof):
        return None
    if physical.p_value is None:
        if physical.undetermined:
            return Missing(physical.undetermined[-1])
        return Missing(
            "the record alone does not determine the fixed values, so it cannot contradict them"
        )
    agree = bool(physical.p_value >= level)
    return Check(
        name="fixed values" if physical.known else "physical parameters",
        status=status_of(agree),
        figure=physical.statistic,
        threshold=None,
        p_value=physical.p_value,
        source=f"Hotelling's T squared of {physical.dof} restrictions, from the covariance of the "
        "estimate and the declared standard deviations, after correction for the bias by filter "
        f"and noise. The check fails where the p-value is below {100 * level:g} %",
        finding=FixedValues(
            values=tuple(_fixed_value(p, estimate) for p in physical.known),
            statistic=float(physical.statistic),
            restrictions=int(physical.dof),
            p_value=float(physical.p_value),
            agree=agree,
            is_bias_known=estimate.filter_bias is not None,
        ),
    )


def _fixed_value(parameter: Parameter, estimate: Estimate) -> FixedValue:
    """Return the finding of a fixed parameter, with its estimate from the record alone.

    The estimate is None where the record alone does not determine the parameter.
    """
    of_record = standard_error = None
    alone = estimate.parameters.get(parameter.name)
    if alone:
        of_record = float(alone.corrected)
        standard_error = float(np.hypot(alone.deviation, alone.sd_gain))
    return FixedValue(
        name=parameter.name,
        unit=parameter.unit,
        value=float(parameter.known or 0.0),
        standard_error=float(parameter.known_sd),
        of_record=of_record,
        standard_error_of_record=standard_error,
    )


def nominal_check(
    found: Iterable[tuple[Parameter, float, tuple[float, float]]],
) -> Check | None:
    """Return a note on values of another order of magnitude than nominal; None without any.

    A column in a wrong unit leads to such values, and no other check shows this where no law is
    simulated. The whole interval has to be more than `_MAX_FROM_NOMINAL` times the nominal value,
    or less than the inverse. Parameters with a nominal value of 0 are not compared. The absolute
    values are compared for a parameter that may have either sign.

    Parameters
    ----------
    found : iterable of (Parameter, float, (float, float))
        Each parameter with its value and its 95 % interval.
    """
    most, far = _MAX_FROM_NOMINAL, list[FarFromNominal]()
    for parameter, value, interval in found:
        if not parameter.nominal:
            continue
        ratios = np.array([value, *interval]) / parameter.nominal
        least, greatest = float(ratios.min()), float(ratios.max())
        if parameter.lower < 0 < parameter.upper:
            has_zero = least <= 0 <= greatest
            sizes = np.abs(ratios)
            least, greatest = 0.0 if has_zero else float(sizes.min()), float(sizes.max())
        if least > most or greatest < 1 / most:
            far.append(
                FarFromNominal(
                    name=parameter.name,
                    unit=parameter.unit,
                    value=float(value),
                    nominal=float(parameter.nominal),
                    ratio=float(ratios[0]),
                )
            )
    if not far:
        return None
    return Check(
        name=NOMINAL_VALUES,
        status="note",
        figure=far[0].ratio,
        threshold=most,
        source="ratio of a value to its nominal value. It is a note above the threshold and below "
        "its inverse, for the whole 95 % interval. The threshold is chosen: usual units differ by "
        "factors of 6.28, 9.81, 57.3 or powers of ten",
        finding=FarFromNominalValues(parameters=tuple(far)),
    )


def gain_check(estimate: Estimate, drive: Drive) -> Check | None:
    """Return the check of the identified drive gain against the declared one.

    A significant difference is a note, and fails the check if one gain is twice the other or more,
    or the signs differ. None where no gain is identified. The parameters rely on the identified
    gain whatever the result of the check is.
    """
    if GAIN not in estimate.parameters:
        return None
    value = estimate.parameters[GAIN]
    deviation = float(np.hypot(value.deviation, drive.relative_sd * drive.gain))
    distance = abs(value.corrected - drive.gain) / deviation if deviation > 0 else np.inf
    same = bool(distance <= MIN_DISTANCE_FROM_NOISE.value)
    near = bool(1 / _MAX_GAIN_RATIO < value.corrected / drive.gain < _MAX_GAIN_RATIO)
    agreement: Literal["same", "near", "far"] = "near" if near else "far"
    if same:
        agreement = "same"
    return Check(
        name="drive gain",
        status=status_of(same, matters=not near),
        figure=finite(distance),
        threshold=MIN_DISTANCE_FROM_NOISE.value,
        source="distance of the identified gain from the declared gain, in standard errors of "
        "their difference. Beyond the threshold it is a note. The check fails where one gain is "
        "twice the other or more, or where the signs differ",
        finding=IdentifiedGain(
            identified=float(value.corrected),
            standard_error=float(value.deviation),
            declared=float(drive.gain),
            unit=value.unit,
            distance=finite(distance),
            agreement=agreement,
        ),
    )
