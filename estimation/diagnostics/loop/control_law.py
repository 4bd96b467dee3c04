"""The declared control law against what the drive did.

The recorded control is regressed on the law's own terms, computed from the recorded reference and
position, and on a test signal that was added to it. Every factor must be 1. What they are instead
tells the fault: millimetres for metres, a flipped sign, another gain, another clock, a delay. A law
that takes an ideal sensor's velocity is compared after a zero-phase low-pass of both sides, since
that velocity is not recorded; the identification's own filter plays no part.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from axisid.codegen.artefacts import GeneratedAxis, build
from axisid.codegen.runtime import by_sample
from axisid.estimation.checks import Check, passed
from axisid.estimation.records import Record, clock_of, is_sampled_by, other_period
from axisid.estimation.regression import Hac, factor, least_squares
from axisid.estimation.signals import Neighbours, Prefilter, SampledFilter
from axisid.estimation.thresholds.diagnostics import (
    COMPARISON_CUTOFF,
    MAX_CONTROL_LEAN,
    MAX_EXPLAINED_RESIDUAL,
    MAX_FACTOR_ERROR,
    MAX_LAW_RESIDUAL,
    MAX_LIMIT_EXCESS,
    MAX_ONE_GAIN_ERROR,
    MAX_REPAIRED_RESIDUAL,
    MAX_SCALE_ERROR,
    MIN_SAMPLES_PER_FACTOR,
)
from axisid.estimation.thresholds.estimates import MIN_DISTANCE_FROM_NOISE
from axisid.estimation.thresholds.records import LIMIT_TOLERANCE
from axisid.modeling.declaration import ControlLaw, gain, velocity_variants
from axisid.modeling.quantities import MEASURED_VELOCITY
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing
from axisid.support.remedy import Note, Remedy, Setting

_LAGS = 50  # samples over which what the law leaves may be alike
_MOST_SHIFT = 5  # samples
_COLUMN_FAULTS = {
    -1.0: "its sign",
    1e-3: "its unit, such as millimetres for metres",
    1e3: "its unit, such as metres for millimetres",
    math.pi / 180: "its unit, such as degrees for radians",
}
_UNITS = {
    1e3: "metres for millimetres",
    1e-3: "millimetres for metres",
    math.pi / 180: "degrees for radians",
    180 / math.pi: "radians for degrees",
}
_CONSTANT, _DRIFT, _INJECTED = "constant", "drift", "injected"
_SETTLE = 10  # samples in which the law's memory fills


@dataclass(frozen=True, slots=True, kw_only=True)
class LawCheck:
    """The recorded control against the declared law.

    Attributes
    ----------
    factors : dict of str to float
        By product of gains, and ``injected`` for a test signal that was added to the control; each
        is 1 if the law is the drive's. Empty where the record cannot tell them apart.
    residual_percent : float or None
        ``100 ||control - law|| / ||control||``, with the law as declared; None for a record of
        another period than the law's.
    fitted_residual_percent : float
        The same with the factors: what no gain explains. None without factors.
    delay : int
        Samples by which the recorded control follows the declared law best.
    constant : float or None
        What the recorded control is more than the law in the mean, in the drive's unit; None for a
        record of another period than the law's.
    passed : bool
        Whether instruments simulated with this law can be believed.
    meaning : str
        One sentence for the user, up to the remedy where there is one.
    remedy : Remedy or None
        How it goes on, where something can be set about it.
    """

    factors: dict[str, float]
    residual_percent: float | None
    fitted_residual_percent: float | None
    delay: int
    constant: float | None
    passed: bool
    meaning: str
    remedy: Remedy | None = None

    @property
    def note(self) -> Note:
        """The whole sentence, to be worded later."""
        return Note(self.meaning, self.remedy)


def check_law(axis: GeneratedAxis, record: Record) -> LawCheck | Missing:
    """Check an axis's control law against a record; or say why it cannot be checked."""
    law = axis.axis.control
    if law is None:
        return Missing("the axis declares no control law")
    # The period is the only thing of a law that can be checked without a reference.
    apart = other_period(law, record.period, clock_of(record))
    if apart is not None:
        return Missing.of(apart.note) if apart.confirmed else _other_clock(apart.note)
    if record.reference is None or record.control is None:
        return Missing("the record has no reference or no control")
    if not is_sampled_by(record, law):
        return Missing(
            f"the record was resampled at {1 / record.period:.6g} Hz, the control law runs at "
            f"{1 / law.period:.6g} Hz"
        )
    record = record.longest()  # a law's memory does not outlast a gap
    settle = round(1 / COMPARISON_CUTOFF.value) if _takes_velocity(law) else _SETTLE
    if len(record.position) < 2 * settle + MIN_SAMPLES_PER_FACTOR.value * len(law.terms):
        return Missing(f"the record is too short for it, {len(record.position)} samples")
    control, terms, used = _compared(axis, law, record, settle)
    if not np.all(np.isfinite(terms)):
        return Missing("the declared law is not finite on this record")
    if used.sum() < MIN_SAMPLES_PER_FACTOR.value * terms.shape[1]:
        return Missing("the control is at the drive's limit, or masked, nearly all the time")
    shift = _best_shift(terms.sum(axis=1), control, used)
    declared = relative_error_percent((control - terms.sum(axis=1))[used], control[used])
    names = [str(product) for product, _ in law.terms]
    names += [] if record.added_control is None else [_INJECTED]
    factors, fitted = _factors(control[used], terms[used], names)
    following = Neighbours.of(np.flatnonzero(used), 1)
    scaled = _scaled(control[used], terms[used], names, following)
    if _takes_velocity(law) and abs(scaled.get(_INJECTED, np.inf) - 1) < MAX_FACTOR_ERROR.value:
        del scaled[_INJECTED]  # the velocity that is compared is not the sensor's to a hundredth
    left = (control - terms.sum(axis=1))[used]
    lean = _lean(left, control[used], following)
    passed = declared < MAX_LAW_RESIDUAL.value and shift == 0 and not scaled and not lean
    constant = None if passed else _constant(control[used], terms[used], names, fitted)
    repair = "" if passed or shift else _repair(axis, law, record, settle, declared)
    fault = _slightly(law, scaled, lean, factors, axis.axis.drive.unit)
    remedy = None
    if declared >= MAX_LAW_RESIDUAL.value or shift:
        delay = None if law.continuous else law.delay
        fault = _fault(law, factors, declared, fitted, shift, delay, constant)
        remedy = _unnamed(record, fitted, shift, constant)
    return LawCheck(
        factors=factors,
        residual_percent=declared,
        fitted_residual_percent=fitted,
        delay=shift,
        constant=float(np.mean(left)),
        passed=passed,
        meaning=f"the declared law reproduces the recorded control to {declared:.2g} % of its norm"
        if passed
        else f"the recorded control is not the declared law's ({declared:.3g} % off), but {repair}"
        if repair
        else fault,
        remedy=None if passed or repair else remedy,
    )


def law_check(law: LawCheck | Missing) -> Check | Missing:
    """The declared law against the recorded control."""
    if isinstance(law, Missing):
        return law
    return Check(
        name="control law",
        status=passed(law.passed),
        figure=law.residual_percent,
        threshold=MAX_LAW_RESIDUAL.value,
        source="residual in percent of the recorded control, 0.24 on the EMPS record; fails too "
        "where a factor is off 1, or a constant or a drift beside the law there, by more than 1 % "
        "and three deviations, for a delay, and for a "
        "sampling period that is more than 0.05 % from the law's",
        meaning=law.meaning,
        remedy=law.remedy,
    )


def _unnamed(
    record: Record, fitted: float | None, shift: int, constant: float | None
) -> Remedy | None:
    """How to name a test signal, where nothing else explains what the law leaves."""
    explained = fitted is not None and fitted <= MAX_LAW_RESIDUAL.value
    if record.injected is not None or shift or constant is not None or explained:
        return None
    return Remedy.of(
        "; or name a test signal that was added to the control or to the reference, with ",
        Setting("columns", "injected=NAME"),
        " and ",
        Setting("injected-at"),
    )


def _other_clock(note: Note) -> LawCheck:
    """A law of differences has other gains at another period, and its record another time."""
    return LawCheck(
        factors={},
        residual_percent=None,
        fitted_residual_percent=None,
        delay=0,
        constant=None,
        passed=False,
        meaning=note.text,
        remedy=note.remedy,
    )


def _repair(
    axis: GeneratedAxis, law: ControlLaw, record: Record, settle: int, declared: float
) -> str:
    """What would make the law fit: columns changed, or its velocity formed otherwise; or empty."""
    good = min(MAX_LAW_RESIDUAL.value, MAX_REPAIRED_RESIDUAL.value * declared)
    for said, changed in _changed_columns(record):
        if _off(axis, law, changed, settle) < good:
            return f"it is with {said}"
    offs = {
        name: _off(
            build(replace(axis.axis, control=variant), native=False), variant, record, settle
        )
        for name, variant in velocity_variants(law).items()
    }
    best = min(offs, key=lambda name: offs[name], default="")
    if not best or offs[best] >= good:
        return ""
    return (
        f"it is that of the law {best} with the same gains ({offs[best]:.2g} % off), which forms "
        "the velocity in another way: declare that"
    )


def _changed_columns(record: Record) -> Iterator[tuple[str, Record]]:
    """The record as it would be without a common mistake in its columns, and which."""
    reference, position = record.reference, record.position
    assert reference is not None  # noqa: S101  # there is none to check without it
    if record.injected is not None:
        there = "reference" if record.injected_at == "control" else "control"
        yield f"the test signal added to the {there}", replace(record, injected_at=there)
        for scale, what in _COLUMN_FAULTS.items():
            scaled = replace(record, injected=scale * record.injected)
            yield f"the test signal times {scale:g}: check {what}", scaled
        yield "no test signal: check which column it is", replace(record, injected=None)
    for role, values in (("position", position), ("reference", reference)):
        for scale, what in _COLUMN_FAULTS.items():
            changed = replace(record, **{role: scale * values})  # type: ignore[arg-type]
            yield f"the {role} times {scale:g}: check {what}", changed
    swapped = replace(record, position=reference, reference=position)
    yield "position and reference exchanged: check which column is which", swapped


def _off(axis: GeneratedAxis, law: ControlLaw, record: Record, settle: int) -> float:
    """What a law leaves of the recorded control, percent."""
    control, terms, used = _compared(axis, law, record, settle)
    return relative_error_percent((control - terms.sum(axis=1))[used], control[used])


def _takes_velocity(law: ControlLaw) -> bool:
    following = [memory.following for memory in law.memory]
    return any(e.has(MEASURED_VELOCITY) for e in (law.output, *following))


def _compared(
    axis: GeneratedAxis, law: ControlLaw, record: Record, settle: int
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """The control, (N,), the law's terms, (N, terms), and which samples to compare, (N,)."""
    control, reference = np.asarray(record.control), np.asarray(record.commanded)
    # A control beyond the limit by more is in a wrong unit, not one of a saturated drive.
    limited = np.isclose(
        np.abs(control), axis.axis.drive.limit, rtol=LIMIT_TOLERANCE.value, atol=0.0
    )
    for start, stop in record.masked:
        limited[start : stop + _SETTLE] = True  # a position that was cut off stays in the memory
    limited[:settle] = True
    if not _takes_velocity(law):
        terms = _run_law(axis, reference, record.position, np.zeros_like(record.position))
        terms = np.hstack([terms, _added(record, law)])
        return control, terms, ~(limited | _cut(control, terms, axis.axis.drive.limit))
    low_pass = Prefilter(cutoff=COMPARISON_CUTOFF.value / record.period)
    smooth = SampledFilter(low_pass, record.period)
    _, velocity, _ = smooth.motion(record.position)
    terms = _run_law(axis, reference, record.position, velocity)
    terms = np.hstack([terms, _added(record, law)])
    if np.all(np.isfinite(terms)):
        control, *columns = (smooth.motion(signal)[0] for signal in (control, *terms.T))
        terms = np.column_stack(columns)
    limited[-settle:] = True
    limited |= _cut(control, terms, axis.axis.drive.limit)
    # The low-pass spreads a limited sample over its neighbours.
    return control, terms, ~maximum_filter1d(limited, settle)


def _cut(control: Array, terms: Array, limit: float) -> NDArray[np.bool_]:
    """Where the law asks for more than the limit, and gets it but for a converter's noise, (N,)."""
    wanted = terms.sum(axis=1)
    there = np.abs(control) >= (1 - MAX_LIMIT_EXCESS.value) * limit
    return np.asarray(there & (wanted * np.sign(control) > limit))


def _added(record: Record, law: ControlLaw) -> Array:
    """What was added to the control besides, as late as the law, (N, 1); (N, 0) for nothing."""
    added = record.added_control
    if added is None:
        return np.empty((len(record), 0))
    late = np.concatenate([np.zeros(law.delay), added[: len(added) - law.delay]])
    return np.asarray(late[:, None])


def _factors(
    control: Array, terms: Array, names: list[str]
) -> tuple[dict[str, float], float | None]:
    """Factors and what they leave, percent; none where the terms cannot be told apart."""
    moving = np.any(terms != 0, axis=0)
    kept = [name for name, moves in zip(names, moving, strict=True) if moves]
    if not kept:
        return {}, None
    try:
        fit = least_squares(control, factor(terms[:, moving], kept))
    except EstimationError:
        return {}, None
    factors = dict(zip(kept, map(float, fit.theta), strict=True))
    return factors, relative_error_percent(fit.residuals, control)


def _scaled(
    control: Array, terms: Array, names: list[str], neighbours: Neighbours
) -> dict[str, float]:
    """Factors that are not 1, by more than 1 % and three of their deviations."""
    moving = np.any(terms != 0, axis=0)
    kept = [name for name, moves in zip(names, moving, strict=True) if moves]
    if not kept:
        return {}
    try:
        columns = factor(terms[:, moving], kept, neighbours=neighbours)
    except EstimationError:
        return {}
    fit = least_squares(control, columns)
    lags = min(_LAGS, len(control) // 4)
    deviations = np.sqrt(np.diag(Hac(lags).matrix(fit)))
    far = np.maximum(MAX_SCALE_ERROR.value, MIN_DISTANCE_FROM_NOISE.value * deviations)
    return {
        name: float(value)
        for name, value, limit in zip(kept, fit.theta, far, strict=True)
        if abs(value - 1) > limit
    }


def _lean(left: Array, control: Array, neighbours: Neighbours) -> dict[str, float]:
    """A constant and a drift over the record that stand out of what the law leaves, by name."""
    half = neighbours.places - neighbours.places.mean()
    terms = np.column_stack([np.ones(len(left)), half / np.ptp(half)])
    names = (_CONSTANT, _DRIFT)
    fit = least_squares(left, factor(terms, names, neighbours=neighbours))
    lags = min(_LAGS, len(left) // 4)
    deviations = np.sqrt(np.diag(Hac(lags).matrix(fit)))
    least = MAX_CONTROL_LEAN.value * float(np.sqrt(np.mean(control**2))) * np.array([1.0, 2.0])
    far = np.maximum(least, MIN_DISTANCE_FROM_NOISE.value * deviations)
    return {
        name: float(value)
        for name, value, limit in zip(names, fit.theta, far, strict=True)
        if abs(value) > limit
    }


def _slightly(
    law: ControlLaw,
    scaled: dict[str, float],
    lean: dict[str, float],
    factors: dict[str, float],
    unit: str,
) -> str:
    """What factors near 1, or a control that leans, look like."""
    if not scaled:
        said = " and ".join(f"a {name} of {value:.3g} {unit}" for name, value in lean.items())
        return (
            f"the recorded control is the declared law's but for {said}"
            f"{' over the record' * (_DRIFT in lean)}: check the offset of the control, or the "
            "value that an integral has at the record's start; it moves friction and offsets"
        )
    listed = ", ".join(f"{name} x {value:.4g}" for name, value in scaled.items())
    if one := _one_gain(law, factors):
        return f"the recorded control is the declared law's but for one gain ({listed}): {one}"
    values = np.array(list(scaled.values()))
    what = (
        "the unit of the test signal"
        if set(scaled) == {_INJECTED}
        else "the control's scaling, such as the gain of a converter"
        if np.ptp(values) < MAX_SCALE_ERROR.value
        else "the gains, the velocity filter and the period"
    )
    every = "" if set(scaled) == {_INJECTED} else "; what scales the control scales every estimate"
    return (
        f"the recorded control is the declared law's but for its factors ({listed}): check "
        f"{what}{every}"
    )


def _constant(
    control: Array, terms: Array, names: list[str], without: float | None
) -> float | None:
    """A constant that explains what the law's terms with factors of their own do not, or None.

    Parameters
    ----------
    without : float or None
        What factors alone leave, percent.
    """
    factors, fitted = _factors(
        control, np.column_stack([terms, np.ones(len(terms))]), [*names, _CONSTANT]
    )
    if fitted is None or fitted > MAX_LAW_RESIDUAL.value:
        return None
    if without is not None and fitted > MAX_EXPLAINED_RESIDUAL.value * without:
        return None
    constant = factors.pop(_CONSTANT)
    near = all(abs(value - 1) < MAX_FACTOR_ERROR.value for value in factors.values())
    return constant if near else None


def _best_shift(predicted: Array, control: Array, used: NDArray[np.bool_]) -> int:
    """Shift that explains the control clearly better than none, else 0."""
    rows = np.flatnonzero(used)
    rows = rows[(rows >= _MOST_SHIFT) & (rows < len(control) - _MOST_SHIFT)]
    errors = {
        shift: float(np.linalg.norm(control[rows] - predicted[rows - shift]))
        for shift in range(-_MOST_SHIFT, _MOST_SHIFT + 1)
    }
    best = min(errors, key=lambda shift: errors[shift])
    return best if errors[best] < MAX_EXPLAINED_RESIDUAL.value * errors[0] else 0


def _one_gain(law: ControlLaw, factors: dict[str, float]) -> str:
    """The one gain that is off, if one explains the factors of the products; or empty.

    A gain that all products have alike is no such one: nothing tells it from the control's scale.
    """
    products = {str(product): product.as_powers_dict() for product, _ in law.terms}
    values = np.array(list(factors.values()))
    if not factors.keys() <= products.keys() or not len(values) or np.any(values <= 0):
        return ""  # a test signal has a factor too, which no gain explains
    found = []
    for name, value in law.gains.items():
        powers = np.array([float(products[each].get(gain(name), 0)) for each in factors])
        if np.ptp(powers) == 0:
            continue
        times = float(np.exp(powers @ np.log(values) / (powers @ powers)))
        left = float(np.abs(values / times**powers - 1).max())
        if left < min(MAX_FACTOR_ERROR.value, MAX_ONE_GAIN_ERROR.value * abs(times - 1)):
            found.append(f"{name} is {times:.4g} times the declared one, {times * value:.5g} for ")
            found[-1] += f"{value:.5g}, and every other gain is right; declare that"
    return found[0] if len(found) == 1 else ""


def _fault(
    law: ControlLaw,
    factors: dict[str, float],
    residual: float,
    fitted: float | None,
    shift: int,
    delay: int | None,
    constant: float | None,
) -> str:
    """Which fault the figures look like, and what to do."""
    listed = "".join(f", {name} x {value:.4g}" for name, value in factors.items())
    start = f"the recorded control is not the declared law's ({residual:.3g} % off{listed}): "
    if shift:
        return f"the recorded control is not in time with the declared law: {_clock(shift, delay)}"
    if constant is not None:
        return (
            f"{start}a constant of {constant:.3g} explains it; check the control's offset, or the "
            "value that an integral has at the record's start"
        )
    values = np.array(list(factors.values()))
    common = float(np.median(values)) if factors else 1.0
    off = [name for name, value in factors.items() if abs(value - 1) >= MAX_FACTOR_ERROR.value]
    if fitted is None or fitted > MAX_LAW_RESIDUAL.value or not off:
        return (
            f"{start}no factor explains it; check the gains, the velocity filter, the period, the "
            "drive's limit and the noise"
        )
    if one := _one_gain(law, factors):
        return f"{start}{one}"
    if off == [_INJECTED]:
        return (
            f"{start}with this factor it would be; check the sign and the unit of the test signal"
        )
    if not np.all(np.abs(values / common - 1) < MAX_FACTOR_ERROR.value):
        return (
            f"{start}with these factors it would be; check {' and '.join(off)}, the velocity "
            "filter and the period"
        )
    if abs(common + 1) < MAX_FACTOR_ERROR.value:
        return f"{start}its sign is flipped; check the sign of the control or of the positions"
    for scale, what in _UNITS.items():
        if abs(common / scale - 1) < MAX_FACTOR_ERROR.value:
            return f"{start}one unit stands for another, such as {what}"
    return (
        f"{start}every gain is off by one factor; check the control's unit and scaling, and "
        "the velocity filter"
    )


def _clock(shift: int, delay: int | None) -> str:
    samples = f"{abs(shift)} sample{'s' * (abs(shift) > 1)}"
    if abs(shift) == _MOST_SHIFT:
        return f"it is shifted by {samples} or more; check the clocks and the columns"
    if delay is None:
        return f"it comes {samples} {'later' if shift > 0 else 'earlier'}; check the clocks"
    if delay + shift < 0:
        return f"it comes {samples} before the law could give it; check the clocks and the columns"
    return (
        f"it comes {samples} {'later' if shift > 0 else 'earlier'}; declare delay={delay + shift}, "
        "or check the clock"
    )


def _run_law(axis: GeneratedAxis, reference: Array, position: Array, velocity: Array) -> Array:
    """The control law's terms along recorded signals, (N, terms), when they are applied.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    reference, position, velocity : (N,) array
        What the law measured.
    """
    declared = axis.axis.control
    delay = 0 if declared is None else declared.delay
    law, terms = axis.functions["control_law"], axis.functions["control_terms"]
    start = axis.functions["control_start"](reference[0], position[0]).full()
    signals = [values[None, :] for values in (reference, position, velocity)]
    states = np.zeros((len(start), len(reference)))
    if len(start):
        # The state comes first in and first out, so that the function can be run along the samples.
        along = law.slice("law", [3, 0, 1, 2], [1]).mapaccum(len(reference))
        states = np.hstack([start, along(start, *signals).full()[:, :-1]])
    rows = by_sample(terms.call([*signals, states])[0].full(), len(reference))
    return np.concatenate([np.repeat(rows[:1], delay, axis=0), rows[: len(rows) - delay]])
