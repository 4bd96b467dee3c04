"""Checks of each parameter: its excitation, its precision, its bounds and its declared value.

They find too few rows, a value within its own standard error, a value beyond its bounds or of
another order of magnitude than its nominal value, a record that contradicts fixed values, and a
drive gain that is not the declared one.

A parameter is imprecise for one of two reasons: its column nearly repeats others, or its part of
the force is below the residual. A motion that lacks something (a reversal, a second speed,
acceleration, travel) explains either.
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

# weight of a column in a repetition, relative to the largest, from which its parameter is named
_MIN_REPETITION_WEIGHT = 0.3
_MIN_ACCELERATION_SHARE = 0.05  # of the force; with less, the axis hardly accelerates
# part of a column that depends on the position; with less, the axis hardly leaves its place
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
        column that nearly repeats them.
    alike : tuple of str
        The parameters whose columns it nearly repeats.
    lacking : tuple of str
        Signals of the parameter that the motion does not excite, as clauses: the reason where the
        parameter is imprecise. A precise parameter has enough excitation by the other signals, as
        a mass by its weight.
    rows : float
        Equivalent number of rows of equal weight: small where the term acts in few rows.
    largest_share : float
        Its largest part of the force, anywhere along the record, over the largest force.
    natural : float
        Typical magnitude of its unit, from force and motion, see `typical_magnitudes`.
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
        """Reason why the record does not identify the parameter, provided that it is imprecise."""
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
    physical : (p,) array
        Estimated physical parameters.
    """
    # Unweighted rows of all records together, and of each record.
    form = problem.form(InverseForm).at(physical)
    each = [form.of_record(i).equations(data.signals) for i, data in enumerate(problem.data)]
    equations = replace(problem, weights=()).reduced(form, [data.signals for data in problem.data])
    reach = SignalRanges.of(
        [
            (
                data.signals,
                replace(own, regressor=form.placed(i, own.intercept, own.regressor)[1]),
                data.sampling.kept,
            )
            for i, (data, own) in enumerate(zip(problem.data, each, strict=True))
        ]
    )
    # Columns of the joint form that each column of a record is part of.
    mixed = [form.record_jacobian(i) != 0 for i in range(len(problem.data))]
    # Largest part of the force of each parameter along the record, and typical magnitudes.
    theta, names = form.regressed(physical), [q.name for q in form.quantities]
    anywhere, natural = np.zeros(len(names)), np.full(len(names), np.inf)
    if reach is not None:
        anywhere = np.abs(theta) * reach.columns / reach.force
        natural = typical_magnitudes(problem.axis, reach, form.declared)
    # Signals that each column depends on, and records in which the axis hardly accelerates.
    of_records = [columns_by_signal(data.axis) for data in problem.data]
    needs = {
        signal: np.any([own[signal] @ m for own, m in zip(of_records, mixed, strict=True)], axis=0)
        for signal in of_records[0]
    }
    X, weights = equations.regressor, problem.stacked(lambda data: data.sampling.weights)
    hardly = [
        _inertial_share(form, i, data, own, theta) < _MIN_ACCELERATION_SHARE
        for i, (data, own) in enumerate(zip(problem.data, each, strict=True))
    ]
    # Excitation of each column: its size, the columns that it repeats, and lacking signals.
    size = np.linalg.norm(X, axis=0)
    unit = X / np.where(size > 0, size, 1.0)
    shares = np.abs(theta) * size / np.linalg.norm(equations.left)
    found = []
    for j, name in enumerate(names):
        inflation, partners, rows = _repetition(unit, j)
        lacking = [
            _lacking(data.signals, X / weights[:, None], slow, needs, [j, *partners])
            for data, slow in zip(problem.data, hardly, strict=True)
        ]
        found.append(
            Excitation(
                name=name,
                share=float(shares[j]),
                inflation=inflation,
                alike=tuple(names[i] for i in partners),
                lacking=tuple(fact for fact in lacking[0] if all(fact in own for own in lacking)),
                rows=rows,
                largest_share=float(anywhere[j]),
                natural=float(natural[j]),
            )
        )
    return tuple(found)


def _repetition(unit: Array, j: int) -> tuple[float, list[int], float]:
    """Return the variance inflation of a column, the columns that it repeats, and its rows.

    Parameters
    ----------
    unit : (n, k) array
        Columns of norm 1.
    j : int
        Index of the column.

    Returns
    -------
    float
        Variance inflation factor; infinite for a column that the others span.
    list of int
        Indices of the columns that it nearly repeats; empty where the inflation is small.
    float
        Equivalent number of rows of the part of the column that is orthogonal to the others: the
        inverse of the sum of the squared row weights.
    """
    others = [i for i in range(unit.shape[1]) if i != j]
    weights = np.linalg.lstsq(unit[:, others], unit[:, j], rcond=None)[0]
    left = unit[:, j] - unit[:, others] @ weights
    unexplained = float(left @ left)
    inflation = 1 / unexplained if unexplained > 0 else np.inf
    rows = unexplained**2 / float(np.sum(left**4)) if unexplained > 0 else 0.0
    if inflation < MAX_VARIANCE_INFLATION.value:
        return inflation, [], rows
    most = _MIN_REPETITION_WEIGHT * np.abs(weights).max(initial=0.0)
    return inflation, [i for i, w in zip(others, weights, strict=True) if abs(w) > most], rows


def _inertial_share(
    form: Form, record: int, data: FilteredRecord, moving_rows: Equations, theta: Array
) -> float:
    """Return the norm of the accelerating force of a record relative to that of the whole force.

    Both are forces of the model in the rows, with its known terms. The accelerating force is the
    change of the force if the acceleration were 0.

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
        """Return the force of the model in the samples of the rows."""
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
        The motion.
    X : (n, k) array
        Regressor without the weights of the rows.
    slow : bool
        Whether the axis hardly accelerates.
    needs : dict of str to (k,) array of bool
        For each signal, True for the columns that depend on it.
    columns : sequence of int
        Indices of the columns.
    """
    needed = {signal for signal, of in needs.items() if of[[*columns]].any()}
    placed = [X[:, j] for j in columns if needs["position"][j] and not needs["acceleration"][j]]
    still = any(np.ptp(x) < _MIN_POSITION_VARIATION * np.abs(x).max() for x in placed)
    facts = (
        ({"velocity", "direction"} & needed, one_direction(signals)),
        ("velocity" in needed, one_speed(signals)),
        (slow and "acceleration" in needed, "the axis hardly accelerates"),
        (still, "the axis hardly leaves its place"),
    )
    return tuple(fact for holds, fact in facts if holds and fact)


_NEGLIGIBLE_SIZE = 0.1  # of an imprecise parameter, relative to the typical size of its unit
_MAX_FROM_NOMINAL = 5.0  # times the nominal value, for the whole interval
NOMINAL_VALUES = "nominal values"
# between identified and declared drive gain; beyond, a known value belongs to another record
_MAX_GAIN_RATIO = 2.0


def rows_check(rows: int, parameters: int, samples_per_row: int | None = None) -> Check | None:
    """Return a failed check where the rows are too few for standard errors of the parameters.

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

    The reason why a parameter is imprecise is from its `excitation`. Parameters that are known to
    be negligible do not count.
    """
    values, relative = estimate.parameters, dict[str, float]()
    for s in excitation:
        value = values[s.name]
        # In few rows the residuals are small, because the estimate follows the noise.
        few = s.rows < MIN_ROWS_PER_PARAMETER.value
        deviation = max(value.deviation, value.sd) if few else value.deviation
        relative[s.name] = 100 * deviation / abs(value.corrected) if value.corrected else np.inf
    vague = [s for s in excitation if relative[s.name] > MAX_RELATIVE_DEVIATION.value]
    small = [s for s in vague if _is_nothing(s, values[s.name])]
    unidentified = [s for s in vague if s not in small]
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
        "largest standard error in percent of the value of its parameter: HAC, or i.i.d. where "
        "that is larger and the parameter acts in few rows. The check fails where a parameter "
        "exceeds the threshold. The threshold does not apply to a parameter whose part of the "
        "force, including its standard error, is below 1 %, unless that parameter could be as "
        "large as is typical of its unit",
        passed=not unidentified,
    )


def _by_reason(
    unidentified: Iterable[Excitation], relative: Mapping[str, float]
) -> tuple[Unidentified, ...]:
    """Return the imprecise parameters, grouped by reason.

    Parameters of a group have the same obscurity (the kind of reason), the same parameters with
    nearly equal columns (`alike`), and the same signals that the motion does not excite
    (`lacking`).

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


def _is_nothing(excitation: Excitation, value: Value) -> bool:
    """Return True for a parameter that is known to be negligible.

    Its part of the force, with two standard errors, must be small in the rows and along the record,
    and its value small for its unit. A parameter whose column repeats others or is not excited is
    not known: it has a small force in this motion whatever its value is.
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

    Physical parameters that follow from base parameters and known values are compared too. If only
    parameters fixed at a bound are to be reported, the check is that of `at_bound_check`. Missing
    if no parameter has bounds.

    Parameters
    ----------
    estimate : Estimate
    rest : float
        Part of the rows in which the axis rests.
    held : sequence of ParameterAtBound
        Parameters that the estimate does not have, because they are fixed at a bound.
    explained_by_others : bool
        Whether another candidate model explains more, so that this model lacks terms.
    """
    axis, values = estimate.form.axis, dict(estimate.parameters)
    physical = physical_parameters(estimate.method, estimate.form, estimate.distribution)
    if physical is not None:
        known = {p.name for p in axis.base.known}
        values |= {n: v for n, v in physical.parameters.items() if n not in {*values, *known}}
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
        source="number of parameters outside or at their declared physical bounds. No estimate is "
        "clipped to its bounds",
        finding=finding,
    )


def _reaches_within(parameter: Parameter, value: Value) -> bool:
    """Return True if the 95 % interval of a value reaches within its bounds."""
    low, high = value.interval
    return bool(low < parameter.upper and high > parameter.lower)


def _outside(parameter: Parameter, value: Value) -> OutsideBounds:
    """Return the finding of a parameter beyond its bounds, with its value minus the bias."""
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
        Part of the rows in which the axis rests.
    """
    farthest = max(each.distance for each in held)
    against = farthest > MIN_DISTANCE_FROM_NOISE.value
    resting = resting_axis(rest) if against else None
    advice: BoundsAdvice | None = None
    if against:
        advice = "rests" if resting else "signs, units and model"
    return Check(
        name="bounds",
        status="fail" if against else "note",
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

    It fails where the record contradicts the values at the given significance level. None where no
    value is fixed and no physical parameter is restricted. Missing where the record alone does not
    determine the fixed values.
    """
    physical = physical_parameters(estimate.method, estimate.form, estimate.distribution)
    if physical is None or not (physical.known or physical.dof):
        return None
    if physical.p_value is None:
        why = "the record alone does not determine the fixed values, so it cannot contradict them"
        return Missing([why, *physical.undetermined][-1])
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

    That estimate is None where the record alone does not determine the parameter.
    """
    of_record = standard_error = None
    if alone := estimate.parameters.get(parameter.name):
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

    A column in a wrong unit leads to such values, and no other check shows it where no law is
    simulated. A nominal value of 0 says nothing about the size. The absolute values are compared
    for a parameter that may have either sign.

    Parameters
    ----------
    found : iterable of (Parameter, float, (float, float))
        Each parameter with its value and its interval. The whole interval has to be far from the
        nominal value.
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

    None where no gain is identified. The parameters are relative to the identified gain whatever
    the result of the check is.
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
