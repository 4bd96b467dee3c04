"""What is printed of each parameter, against the motion, what was declared, and how sure it is.

Too few rows, a value within its own deviation, one beyond its bounds or of another order of size
than declared, a record that contradicts what was fixed, and a drive gain that is not the declared
one.

A parameter is vague for one of two reasons: its column nearly repeats others, or its part of the
force drowns in what the model leaves unexplained. What the motion lacks (a reversal, a second
speed, acceleration, travel) explains either.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.estimates import Estimate, Value, physical_parameters
from axisid.estimation.estimation_problem import (
    ParameterAtBound,
    Problem,
    SignalRanges,
    typical_magnitudes,
)
from axisid.estimation.regression import Equations, Form, InverseForm
from axisid.estimation.signals import (
    FilteredRecord,
    Signals,
    columns_by_signal,
    one_direction,
    one_speed,
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
from axisid.modeling.declaration import Drive, known_text
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array, MaybeInfinite
from axisid.support.errors import Missing, first_case

_MIN_REPETITION_WEIGHT = 0.3  # of the largest, from which another column in a repetition is named
_MIN_ACCELERATION_SHARE = 0.05  # of the force; an axis with less hardly accelerates
# of a column by the position; with less the axis hardly leaves its place
_MIN_POSITION_VARIATION = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Excitation:
    """What the motion shows of one parameter.

    Attributes
    ----------
    name : str
    share : float
        Norm of its part of the force over that of the force.
    inflation : float
        Variance inflation: 1 for a column unlike all others, large for one that nearly repeats
        them.
    alike : tuple of str
        The parameters whose columns it nearly repeats.
    lacking : tuple of str
        What the motion lacks of what this parameter acts by, in words: why, where it is vague.
        One that is not acts enough by the rest, as a mass does by its weight.
    rows : float
        How many rows as heavy as one another would tell of it what the rows do: few where the term
        acts in few.
    largest_share : float
        Its largest part of the force, anywhere along the record, over the largest force.
    natural : float
        What the force and the motion make of its unit, see `typical_magnitudes`.
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
    def reason(self) -> str:
        """Why the record does not show the parameter, for after "because"."""
        why = first_case(
            (self.alike, f"its column nearly repeats that of {', '.join(self.alike)}"),
            (
                self.rows < MIN_ROWS_PER_PARAMETER.value,
                f"it acts in few rows (as if in {self.rows:.2g})",
            ),
            (self.share >= 1, "others cancel its part of the force"),
            (True, "its part of the force drowns in what the model leaves unexplained"),
        )
        return f"{why}: {', and '.join(self.lacking)}" if self.lacking else why


def excitation(problem: Problem, physical: Array) -> tuple[Excitation, ...]:
    """Judge every parameter's column of the inverse model.

    What the motion of several records lacks, it lacks in all of them.

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
    # How much of a record's own columns is in those of all.
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
    """Variance inflation of a column, those it is made of where that is large, and its rows.

    The rows are those of the part that is its own: the inverse of the sum of their squared weights.
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
    """Norm of the force that accelerates, known terms too, over that of the modelled force."""

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


def rows_check(rows: int, parameters: int, remedy: str) -> Check | None:
    """Whether rows are enough to tell how sure so many parameters are."""
    if rows >= MIN_ROWS_PER_PARAMETER.value * parameters:
        return None
    return Check(
        name="rows",
        status="fail",
        figure=rows / parameters,
        threshold=MIN_ROWS_PER_PARAMETER.value,
        source=MIN_ROWS_PER_PARAMETER.source,
        meaning=f"{rows} rows for {parameters} parameters are few: standard deviations cannot be "
        f"believed; {remedy}",
    )


def precision(estimate: Estimate, excitation: Sequence[Excitation]) -> Check:
    """Every parameter against its own deviation; a vague one with the reason."""
    values, relative = estimate.parameters, dict[str, float]()
    for s in excitation:
        value = values[s.name]
        # In few rows residuals are small since the estimate follows them.
        few = s.rows < MIN_ROWS_PER_PARAMETER.value
        deviation = max(value.deviation, value.sd) if few else value.deviation
        relative[s.name] = 100 * deviation / abs(value.corrected) if value.corrected else np.inf
    vague = [s for s in excitation if relative[s.name] > MAX_RELATIVE_DEVIATION.value]
    small = [s for s in vague if _is_nothing(s, values[s.name])]
    by_reason: dict[str, list[str]] = {}
    for s in vague:
        if s not in small:
            by_reason.setdefault(s.reason, []).append(s.name)
    return precision_check(
        max(relative.values()),
        [
            f"{'none of ' * (len(names) > 1)}{', '.join(names)} is {'not ' * (len(names) == 1)}"
            f"identified by this record, because {reason}"
            for reason, names in by_reason.items()
        ],
        [s.name for s in small],
        "force",
        "relative HAC deviation in percent, or the i.i.d. one where it is larger and few "
        "rows tell of the parameter; one whose part of the force is below 1 %, deviation "
        "included, may be as vague as it is, unless it could be as large as the unit allows",
    )


def precision_check(
    worst: float, unclear: Sequence[str], small: Sequence[str], of: str, source: str
) -> Check:
    """The check of parameters against their deviations.

    Parameters
    ----------
    worst : float
        Largest relative deviation, %.
    unclear : sequence of str
        What is said of each parameter that is not known.
    small : sequence of str
        Names of those that are as vague, and matter little.
    of : str
        What these are less than 1 % of.
    source : str
        What the figure is.
    """
    clear = first_case(
        (not small, "every"),
        (
            True,
            f"{', '.join(small)} cannot be told from zero and is less than 1 % of the {of}; every "
            "other",
        ),
    )
    return Check(
        name="precision",
        status=status_of(not unclear),
        figure=worst if np.isfinite(worst) else None,
        threshold=MAX_RELATIVE_DEVIATION.value,
        source=source,
        meaning="; ".join(unclear) or f"{clear} parameter stands well above its deviation",
    )


def _is_nothing(excitation: Excitation, value: Value) -> bool:
    """Known to be small, not unknown: no other column and no missing motion hides it.

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
    estimate: Estimate, cause: str | None, held: Sequence[ParameterAtBound] = ()
) -> Check | Missing:
    """Every parameter against the bounds that it was declared with, physical ones too.

    Parameters
    ----------
    estimate : Estimate
    cause : str
        What to blame before signs and units, if anything is.
    held : sequence of ParameterAtBound
        Parameters that are none of the estimate, since they are held at a bound.
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
        return at_bound_check(held, cause)
    if not declared:
        return Missing("no parameter is declared with bounds")
    reaching = zip(outside, (values[p.name].interval for p in outside), strict=True)
    if outside and all(low < p.upper and high > p.lower for p, (low, high) in reaching):
        cause = (
            f"the 95 % interval of {'each' if len(outside) > 1 else 'it'} reaches within; "
            "leave it at the bound with bounded"
        )
    listed = "; ".join(p.out_of_bounds(values[p.name].corrected) for p in outside)
    return Check(
        name="bounds",
        status=status_of(not outside),
        figure=float(len(outside)),
        threshold=0.0,
        source="declared physical bounds; parameters outside or at them, none is clipped",
        meaning=f"{listed}: {cause or 'check signs and units of the record and the drive gain'}"
        if outside
        else "every parameter is within its declared bounds",
    )


def at_bound_check(held: Sequence[ParameterAtBound], cause: str | None = None) -> Check:
    """Parameters at their bounds: what chance takes there, or what contradicts the bound.

    Parameters
    ----------
    held : sequence of ParameterAtBound
        One at least.
    cause : str, optional
        What to blame before signs and units.
    """
    farthest = max(each.distance for each in held)
    against = farthest > MIN_DISTANCE_FROM_NOISE.value
    blamed = cause or "check the signs and units of the record, and what the model lacks"
    return Check(
        name="bounds",
        status="fail" if against else "note",
        figure=farthest,
        threshold=MIN_DISTANCE_FROM_NOISE.value,
        source="deviations by which a parameter that is held would be beyond its bound",
        meaning="; ".join(each.text for each in held)
        + f", {farthest:.2g} deviations beyond: {blamed}" * against,
    )


def fixed_check(estimate: Estimate, level: float = CHECK_LEVEL.value) -> Check | Missing | None:
    """Whether the record contradicts what was fixed; nothing if nothing could be asked."""
    physical = physical_parameters(estimate.method, estimate.form, estimate.distribution)
    if physical is None or not (physical.known or physical.dof):
        return None
    if physical.p_value is None:
        why = "the record alone does not determine what was fixed, so that it cannot contradict it"
        return Missing([why, *physical.undetermined][-1])
    sides = []
    for p in physical.known:
        sides.append(f"{p.name} is fixed at {known_text(p.known, p.known_sd)} {p.unit}")
        if alone := estimate.parameters.get(p.name):
            deviation = np.hypot(alone.deviation, alone.sd_gain)
            sides[-1] += f", the record alone gives {alone.corrected:.4g} +- {deviation:.2g}"
    fault = (
        f"no values of the parameters agree with the record{' and what was fixed' * bool(sides)} "
        f"(squared distance {physical.statistic:.3g}, restrictions {physical.dof})"
        f"{': ' * bool(sides)}{'; '.join(sides)}. "
        "Check what was fixed, the drive gain and the terms of the model"
        + "; its bias, which could do it too, is not known without a control law"
        * (estimate.filter_bias is None)
    )
    good = physical.p_value >= level
    return Check(
        name="fixed values" if physical.known else "physical parameters",
        status=status_of(good),
        figure=physical.statistic,
        threshold=None,
        p_value=physical.p_value,
        source=f"Hotelling's T squared with {physical.dof} restrictions, covariance of the "
        "estimate and declared deviations, less the bias of filter and noise; fails below "
        f"{100 * level:g} %",
        meaning="the record agrees with them" if good else fault,
    )


def nominal_check(
    found: Iterable[tuple[Parameter, float, tuple[float, float]]],
) -> Check | None:
    """Remark values that are another order of size than declared; None where none is.

    A column in another unit makes such values, which nothing else shows where no law is simulated.
    A nominal value of 0 says nothing of the size. Of a parameter that may have either sign, the
    sizes are compared.

    Parameters
    ----------
    found : iterable of (Parameter, float, (float, float))
        Each with its value and its interval, all of which is as far.
    """
    most, far = _MAX_FROM_NOMINAL, dict[Parameter, float]()
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
            far[parameter] = float(ratios[0])
    if not far:
        return None
    listed = ", ".join(
        f"{p.name} = {ratio * p.nominal:.4g} {p.unit} is {ratio:.2g} times its nominal "
        f"{p.nominal:.4g}"
        for p, ratio in far.items()
    )
    return Check(
        name=NOMINAL_VALUES,
        status="note",
        figure=next(iter(far.values())),
        threshold=most,
        source="chosen: units are apart by 6.28, 9.81, 57.3 or powers of ten",
        meaning=f"{listed}: check the units of the record's columns and the drive's gain, or "
        "declare another nominal value",
    )


def gain_check(estimate: Estimate, drive: Drive) -> Check | None:
    """Whether the identified gain is the declared one; None where none is identified.

    The parameters are of the identified gain whatever comes of it.
    """
    if GAIN not in estimate.parameters:
        return None
    value = estimate.parameters[GAIN]
    deviation = float(np.hypot(value.deviation, drive.relative_sd * drive.gain))
    distance = abs(value.corrected - drive.gain) / deviation if deviation > 0 else np.inf
    same = distance <= MIN_DISTANCE_FROM_NOISE.value
    ratio = value.corrected / drive.gain
    near = 1 / _MAX_GAIN_RATIO < ratio < _MAX_GAIN_RATIO
    found = f"the drive gain is {value.corrected:.5g} +- {value.deviation:.2g} {value.unit}"
    said = first_case(
        (same, "the identified gain is the declared one"),
        (
            near,
            f"{found}, {100 * (ratio - 1):+.2g} % from the declared {drive.gain:g}: the parameters "
            "are of the identified one; declare it for what is identified without a known force",
        ),
        (
            True,
            f"{found}, and {drive.gain:g} is declared: check that the known values are in the "
            "order of the records, and their units",
        ),
    )
    return Check(
        name="drive gain",
        status=status_of(same, matters=not near),
        figure=distance if np.isfinite(distance) else None,
        threshold=MIN_DISTANCE_FROM_NOISE.value,
        source="distance of the identified gain from the declared one, in deviations of both; a "
        "note, and a failure where one is twice the other or more, or of the other sign",
        meaning=said,
    )
