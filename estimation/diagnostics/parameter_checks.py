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
from axisid.support.errors import Missing

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

_MIN_REPETITION_WEIGHT = 0.3  # of the largest, from which another column in a repetition is named
_MIN_ACCELERATION_SHARE = 0.05  # of the force; an axis with less hardly accelerates
# of a column by the position; with less the axis hardly leaves its place
_MIN_POSITION_VARIATION = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Excitation:
    """Excitation of one parameter by the motion.

    Attributes
    ----------
    name : str
    share : float
        Norm of its part of the force over that of the force.
    inflation : float
        Variance inflation factor: 1 for a column that is orthogonal to all others, large for a
        column that nearly repeats them.
    alike : tuple of str
        The parameters whose columns it nearly repeats.
    lacking : tuple of str
        What the motion lacks of the signals that the parameter acts by: the reason, where it is
        imprecise. A precise parameter acts enough by the other signals, as a mass by its weight.
    rows : float
        Equivalent number of rows of equal weight: small where the term acts in few rows.
    largest_share : float
        Its largest part of the force, anywhere along the record, over the largest force.
    natural : float
        Typical magnitude of its unit by force and motion, see `typical_magnitudes`.
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
        """Return the reason why the record does not show the parameter, where it is imprecise."""
        if self.alike:
            return "repeated column"
        if self.rows < MIN_ROWS_PER_PARAMETER.value:
            return "few rows"
        if self.share >= 1:
            return "cancelled"
        return "below residual"


def excitation(problem: Problem, physical: Array) -> tuple[Excitation, ...]:
    """Return the excitation of every parameter by its column of the inverse model.

    The motion of several records lacks something only if it lacks it in all of them.

    Parameters
    ----------
    problem : Problem
    physical : (p,) array
        An estimate.
    """
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
    # Which columns of all records each column of a record is part of.
    mixed = [form.record_jacobian(i) != 0 for i in range(len(problem.data))]
    theta, names = form.regressed(physical), [q.name for q in form.quantities]
    anywhere, natural = np.zeros(len(names)), np.full(len(names), np.inf)
    if reach is not None:
        anywhere = np.abs(theta) * reach.columns / reach.force
        natural = typical_magnitudes(problem.axis, reach, form.declared)
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
    """Return the variance inflation of a column, the columns it repeats where large, and its rows.

    The rows are those of its part that is orthogonal to the others: the inverse of the sum of their
    squared weights.
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
    """Return the norm of the accelerating force, with known terms, over the modelled force's."""

    def force(rows: Equations) -> Array:
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


_NEGLIGIBLE_SIZE = 0.1  # of a vague parameter, in what force and motion make of its unit
_MAX_FROM_NOMINAL = 5.0  # times the nominal value, of the whole interval
NOMINAL_VALUES = "nominal values"
# between identified and declared drive gain; beyond, a known value is of another record
_MAX_GAIN_RATIO = 2.0


def rows_check(rows: int, parameters: int, samples_per_row: int | None = None) -> Check | None:
    """Return a failed check where rows are too few for standard errors of so many parameters.

    Parameters
    ----------
    rows, parameters : int
    samples_per_row : int, optional
        Of a fit: the number of samples that count as one row.
    """
    if rows >= MIN_ROWS_PER_PARAMETER.value * parameters:
        return None
    return Check(
        name="rows",
        status="fail",
        figure=rows / parameters,
        threshold=MIN_ROWS_PER_PARAMETER.value,
        source=MIN_ROWS_PER_PARAMETER.source,
        finding=FewRows(rows=rows, parameters=parameters, samples_per_row=samples_per_row),
    )


def precision(estimate: Estimate, excitation: Sequence[Excitation]) -> Check:
    """Compare every parameter with its standard error; an imprecise one has the reason."""
    values, relative = estimate.parameters, dict[str, float]()
    for s in excitation:
        value = values[s.name]
        # In few rows residuals are small since the estimate follows them.
        few = s.rows < MIN_ROWS_PER_PARAMETER.value
        deviation = max(value.deviation, value.sd) if few else value.deviation
        relative[s.name] = 100 * deviation / abs(value.corrected) if value.corrected else np.inf
    vague = [s for s in excitation if relative[s.name] > MAX_RELATIVE_DEVIATION.value]
    small = [s for s in vague if _is_nothing(s, values[s.name])]
    unidentified = [s for s in vague if s not in small]
    others = [relative[s.name] for s in excitation if s not in small]
    finding = Precision(
        largest_percent=finite(max(others, default=0.0)),
        negligible=tuple(relative_error(s.name, relative[s.name]) for s in small),
        unidentified=_by_reason(unidentified, relative),
    )
    return precision_check(
        max(relative.values()),
        finding,
        "relative HAC standard error in percent, or the i.i.d. one where it is larger and the "
        "parameter acts in few rows; not limited for a parameter whose part of the force is below "
        "1 %, standard error included, unless the parameter could be as large as its unit allows",
        passed=not unidentified,
    )


def _by_reason(
    unidentified: Iterable[Excitation], relative: Mapping[str, float]
) -> tuple[Unidentified, ...]:
    """Return imprecise parameters, those with one reason together.

    Parameters
    ----------
    unidentified : iterable of Excitation
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
    """Return the check of parameters against their standard errors.

    Parameters
    ----------
    worst : float
        Largest relative standard error, %.
    finding : Finding
    source : str
        Definition of the figure.
    passed : bool
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
    """Tell whether a parameter is known to be small: neither columns nor the motion hide it.

    A term that acts beyond the rows, or beyond the motion, is small in them whatever it is.
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
    """Compare every parameter, physical ones too, with its declared bounds.

    Parameters
    ----------
    estimate : Estimate
    rest : float
        Part of the rows in which the axis rests.
    held : sequence of ParameterAtBound
        Parameters that are not among the estimate's, since they are fixed at a bound.
    explained_by_others : bool
        Whether another candidate model explains more, so that this one lacks terms.
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
        source="declared physical bounds; number of parameters outside or at them, none is clipped",
        finding=finding,
    )


def _reaches_within(parameter: Parameter, value: Value) -> bool:
    """Tell whether the 95 % interval of a value reaches within its bounds."""
    low, high = value.interval
    return bool(low < parameter.upper and high > parameter.lower)


def _outside(parameter: Parameter, value: Value) -> OutsideBounds:
    return OutsideBounds(
        name=parameter.name,
        unit=parameter.unit,
        value=float(value.corrected),
        lower=float(parameter.lower),
        upper=float(parameter.upper),
        is_at_bound=bool(parameter.allows(value.corrected)),
    )


def at_bound_check(held: Sequence[ParameterAtBound], rest: float = 0.0) -> Check:
    """Return the check of parameters at their bounds, by chance or against the record.

    Parameters
    ----------
    held : sequence of ParameterAtBound
        At least one.
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
        source="standard errors by which a parameter that is fixed at its bound would be beyond it",
        finding=FixedAtBounds(
            parameters=tuple(held),
            distance=float(farthest),
            advice=advice,
            rest=resting,
        ),
    )


def fixed_check(estimate: Estimate, level: float = CHECK_LEVEL.value) -> Check | Missing | None:
    """Test whether the record contradicts the fixed values; None where nothing can be tested."""
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
        source=f"Hotelling's T squared with {physical.dof} restrictions, covariance of the "
        "estimate and declared standard deviations, corrected for the bias of filter and noise; "
        f"fails below {100 * level:g} %",
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
    """Return a known parameter with its estimate from the record alone."""
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
    """Return a note on values of another order of magnitude than declared; None without any.

    A column in another unit makes such values, which no other check shows where no law is
    simulated. A nominal value of 0 says nothing of the size. Of a parameter that may have either
    sign, the absolute values are compared.

    Parameters
    ----------
    found : iterable of (Parameter, float, (float, float))
        Each with its value and its interval, all of which is as far.
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
        source="chosen: units differ by 6.28, 9.81, 57.3 or powers of ten",
        finding=FarFromNominalValues(parameters=tuple(far)),
    )


def gain_check(estimate: Estimate, drive: Drive) -> Check | None:
    """Compare the identified drive gain with the declared one; None where none is identified.

    The parameters are relative to the identified gain in either case.
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
        source="distance of the identified gain from the declared one, in standard errors of both; "
        "a note, and a failure where one is twice the other or more, or of the other sign",
        finding=IdentifiedGain(
            identified=float(value.corrected),
            standard_error=float(value.deviation),
            declared=float(drive.gain),
            unit=value.unit,
            distance=finite(distance),
            agreement=agreement,
        ),
    )
