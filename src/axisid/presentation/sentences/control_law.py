"""Sentences of the comparison of a recorded control with the declared control law."""

from collections.abc import Mapping, Sequence

import numpy as np

from axisid.estimation.diagnostics import (
    ControlScaleMoves,
)
from axisid.estimation.diagnostics.control_law import (
    ConstantOrDrift,
    ControlDiffers,
    ControlScale,
    ExchangedColumns,
    FoundByReading,
    FoundGainsAgree,
    FoundGainsDiffer,
    LateControl,
    LawOfSecondRecord,
    LawReproduced,
    MovedColumn,
    MovedZero,
    NoiseGain,
    OtherGain,
    OtherGains,
    OtherInjectedSize,
    OtherScale,
    OtherTestSignal,
    OtherVelocity,
    ReferenceClock,
    RepairedLaw,
    ScaledColumn,
    UndeclaredLimit,
    UnexplainedControl,
)
from axisid.estimation.records import AdvisedShift, OtherPeriod
from axisid.support.settings import setting

from .dispatch import sentence
from .words import capitalised, listed

#: Samples that the law read, by the name of the reading.
_READINGS = {
    "sampled rows": "the rows as they were sampled",
    "even times": "samples interpolated at even times",
}
#: Beginning of the sentence on a second record, by the kind of result that is validated.
_NOT_HOLDING = {
    "estimates": "the estimates do not hold, because this record has another control law: ",
    "fit": "this record has another control law than the axis of the fit: ",
}
_CHECK_INJECTED_SIZE = (
    "Check the size of the test signal, such as a gain or a filter between the point where it is "
    "logged and the point where it is added"
)


@sentence.register
def law_reproduced(finding: LawReproduced) -> str:
    """Return the residual of a law that reproduces the control.

    It also has the part of the control that depends on values between the samples, if it is known.
    """
    text = (
        "the declared control law reproduces the recorded control: rms residual "
        f"{finding.residual_percent:.2g} % of the control"
    )
    if finding.open_percent is None:
        return text
    return (
        f"{text}; {finding.open_percent:.2g} % of the control depends on what the law reads "
        "between the samples of the log"
    )


@sentence.register
def found_by_reading(finding: FoundByReading) -> str:
    """Return the comparison of law and control, with the samples that the law read.

    It also has the residual with the samples of the record, if that is known.
    """
    samples = _READINGS[finding.reading]
    if finding.recorded_percent is None:
        return f"with {samples}, {sentence(finding.finding)}"
    text = (
        f"{sentence(finding.finding)}, with {samples}; with the samples of the record the residual "
        f"is {finding.recorded_percent:.2g} %"
    )
    if finding.reading == "sampled rows":
        text += ". If only the time stamps jitter, and not the sampling, remove resample"
    return text


@sentence.register
def other_period(finding: OtherPeriod) -> str:
    """Return the periods of log and law, and the instructions to correct or confirm them."""
    period = setting("sample_period", _plain(finding.period))
    text = (
        f"the record is sampled every {finding.period:.6g} s, and the control law runs every "
        f"{finding.law_period:.6g} s"
    )
    if finding.is_given:
        return (
            f"{text}. Nothing else confirms {period}. Compare it with the drive's period. If the "
            "log does not record every period, give its time column. If the law has its own clock, "
            "declare how the reference varies between its samples (reference_between)"
        )
    log = "has its own clock"
    if finding.kept is not None:
        log = f"keeps one sample in {finding.kept}"
    return (
        f"{text}. Check the time column and its unit, or declare the drive's period. If the log "
        f"{log}, confirm this with {period}"
    )


@sentence.register
def late_control(finding: LateControl) -> str:
    """Return the delay of the control relative to the law, and the correction.

    The correction depends on the cause that the motion shows: log, law, or another column.
    """
    at_least = "at least " if finding.is_at_least else ""
    later_or_earlier = "later" if finding.samples > 0 else "earlier"
    text = (
        "the recorded control is not in time with the declared control law "
        f"({_residual(finding.residual_percent)}): it is recorded {at_least}"
        f"{samples_text(abs(finding.samples))} {later_or_earlier} than the law gives it"
    )
    if finding.is_before_law:
        text += ", before the law can compute it"
    if finding.is_at_least:
        return f"{text}. Check the clocks and the columns"
    if finding.blame == "log":
        return (
            f"{text}. The motion shows that the log is wrong: the control does not act when it is "
            "recorded. "
            f"{capitalised(shift_text('control', finding.shift))}"
        )
    if finding.blame == "position or reference":
        return (
            f"{text}. The motion shows that the control acts when it is recorded. If the reference "
            f"is written late, {shift_text('reference', finding.shift)}. If the position is "
            f"written late, {shift_text('position', finding.shift)}"
        )
    if finding.blame == "law":
        return (
            f"{text}. Declare delay={finding.delay}. The motion supports this: the control acts "
            "when it is recorded"
        )
    when = "after the drive applied it"
    if finding.samples < 0:
        when = "before the drive applies it"
    by_log = f"if the log writes the control {when}, {shift_text('control', finding.shift)}"
    if finding.delay is None:
        text = f"{text}. {capitalised(by_log)}"
    else:
        text = f"{text}. Declare delay={finding.delay} or, {by_log}"
    if finding.unknown:
        text += (
            f". This record does not show whether the law or the log is wrong: {finding.unknown}"
        )
    return text


@sentence.register
def constant_or_drift(finding: ConstantOrDrift) -> str:
    """Return the constant and the drift of the control, and the instruction to check them."""
    sizes = []
    if finding.constant is not None:
        sizes.append(f"a constant of {finding.constant:.3g} {finding.unit}")
    if finding.drift is not None:
        sizes.append(f"a drift of {finding.drift:.3g} {finding.unit} over the record")
    return (
        f"the recorded control follows the declared control law except for {listed(sizes)} "
        f"({_residual(finding.residual_percent)}). This changes the estimated friction and "
        "offsets. Check the offset of the control, the zero of the position relative to the "
        "reference, and the drive for an integral action that is not declared"
    )


@sentence.register
def other_gains(finding: OtherGains) -> str:
    """Return the gains that explain the control, and the instruction to declare them.

    Alternatives are other sets of gains, and a factor of the recorded control.
    """
    if finding.scale is not None:
        return _gains_or_scale(finding, finding.scale)
    alternatives = [_gains_text(gains) for gains in finding.alternatives]
    is_single = len(finding.alternatives) == 1
    if is_single:
        text = f"{_differs(finding)}: {alternatives[0]}"
        if finding.has_right_gains:
            text += ", and every other gain is right"
        text += f". {capitalised(_declare_gains(finding))}"
    else:
        text = (
            f"{_differs(finding)}. There are {len(alternatives)} possible causes: "
            f"{'; or '.join(alternatives)}. The record does not show which is right. "
            f"{capitalised(_declare_gains(finding))}"
        )
    if finding.injected_differs:
        text += f". {_CHECK_INJECTED_SIZE}"
    return text


def _gains_or_scale(finding: OtherGains, scale: ControlScale) -> str:
    """Return other gains, or a factor of the recorded control, as the two possible causes."""
    gains = "; or ".join(_gains_text(each) for each in finding.alternatives)
    if len(finding.alternatives) == 1 and finding.has_right_gains:
        gains += ", and every other gain is right"
    text = (
        f"{_differs(finding)}. There are two possible causes. Either {gains}. Or "
        f"{_scale_text(scale)}. The law alone does not show which is right. In the first case, "
        f"{_declare_gains(finding)}. In the second case, {_check_scale(scale)}"
    )
    if finding.injected_differs:
        text += f". {_CHECK_INJECTED_SIZE}"
    return text


def _declare_gains(finding: OtherGains) -> str:
    """Return the instruction to declare the gains that explain the control.

    It begins with a small letter.
    """
    if len(finding.alternatives) > 1:
        return "declare the gains of the drive"
    return "declare that gain" if len(finding.alternatives[0]) == 1 else "declare these gains"


@sentence.register
def other_scale(finding: OtherScale) -> str:
    """Return the factor or the sign of the recorded control, and the instruction to check it."""
    return (
        f"{_differs(finding)}: {_scale_text(finding.scale)}. With this correction, the rms "
        f"residual is {_relative_to_control(finding.scaled_percent)}. "
        f"{capitalised(_check_scale(finding.scale))}"
    )


@sentence.register
def other_injected_size(finding: OtherInjectedSize) -> str:
    """Return the statement that the test signal has another size, and the instruction."""
    return (
        f"{_differs(finding)}: the test signal has another size in the control. "
        f"{_CHECK_INJECTED_SIZE}"
    )


@sentence.register
def unexplained_control(finding: UnexplainedControl) -> str:
    """Return the statement that no gains explain the control, and the instructions."""
    text = (
        f"{_differs(finding)}: no change of its gains explains the difference. Check how the drive "
        "computes the velocity, its feed-forward, filters, limits and anti-windup, the period and "
        "the noise. Run axisid law (in Python: estimation.find_law) to find out whether the "
        "control follows another built-in law"
    )
    if not finding.may_be_injected:
        return text
    return (
        f"{text}. If a test signal was added to the control or to the reference, name its column "
        f"with {setting('columns', {'injected': 'NAME'})}, and the place where it was added with "
        f"{setting('injected_at', 'control')} or {setting('injected_at', 'reference')}"
    )


@sentence.register
def repaired_law(finding: RepairedLaw) -> str:
    """Return the change with which the control follows the law, and the instruction to make it.

    The sentence of the repair is the end of this sentence.
    """
    return (
        "the recorded control does not follow the declared control law "
        f"({_residual(finding.residual_percent)}), but it does (rms residual "
        f"{finding.repaired_percent:.2g} %) {sentence(finding.repair)}"
    )


@sentence.register
def exchanged_columns(_: ExchangedColumns) -> str:
    """Return the end of the sentence of a repaired law: columns that are exchanged."""
    return (
        "with position and reference exchanged. Check which column is the position and which the "
        "reference"
    )


@sentence.register
def other_test_signal(finding: OtherTestSignal) -> str:
    """Return the end of the sentence of a repaired law: another test signal."""
    if finding.change == "opposite sign":
        return "with the test signal times -1. Check its sign"
    if finding.change == "none":
        return "without the test signal. Check which column contains the test signal"
    place = finding.change.removeprefix("added to the ")
    return f"with the test signal {finding.change}. Set {setting('injected_at', place)}"


@sentence.register
def scaled_column(finding: ScaledColumn) -> str:
    """Return the end of the sentence of a repaired law: a column of another scale."""
    unit = finding.unit or f"UNIT*{finding.times:.4g}"
    column = setting("columns", {finding.role: f"{finding.column}:{unit}"})
    return (
        f"with the {finding.role} times {finding.times:.4g}. Correct the unit, the scaling or the "
        f"sign of this column. If it has no unit yet, use {column}"
    )


@sentence.register
def moved_column(finding: MovedColumn) -> str:
    """Return the end of the sentence of a repaired law: a column at another time."""
    way = "later" if finding.samples > 0 else "earlier"
    return (
        f"with the {finding.role} {samples_text(abs(finding.samples))} {way}. If the log wrote it "
        f"at another time, {shift_text(finding.role, finding.samples)}"
    )


@sentence.register
def reference_clock(finding: ReferenceClock) -> str:
    """Return the end of the sentence of a repaired law: a reference of another clock."""
    length, clock = ("shorter", "fast") if finding.rate > 0 else ("longer", "slow")
    return (
        f"with the times of the reference {1e6 * abs(finding.rate):.4g} ppm {length}: the clock of "
        f"the reference is {clock} by this amount relative to the clock of the position. Record "
        "both signals with one clock"
    )


@sentence.register
def moved_zero(finding: MovedZero) -> str:
    """Return the end of the sentence of a repaired law: a position with another zero.

    The law turns an offset of the position into a constant control, so the control may be wrong
    instead, unless this constant exceeds the limit of the drive.
    """
    text = (
        f"if the position is recorded {finding.position:+.3g} {finding.unit} away from its zero "
        "relative to the reference (a constant tracking error of the same size)"
    )
    value = f"{finding.column}:UNIT{-finding.position:+.3g}{finding.unit}"
    corrected = setting("columns", {"position": value})
    if finding.control is None:
        return f"{text}. Subtract this offset from the position with {corrected}"
    control = f"{finding.control:.3g} {finding.control_unit}"
    if finding.exceeds_limit:
        return (
            f"{text}. The law turns this offset into a control of {control}, more than the drive "
            "gives, so the cause is not a constant of the control. Subtract the offset from the "
            f"position with {corrected}"
        )
    return (
        f"{text}, or if the control is recorded {control} too large, into which the law turns this "
        "offset. The control is the cause if the model leaves a constant force unexplained, or if "
        "an estimated offset should be zero. Subtract the offset from the position with "
        f"{corrected}, or check the offset of the control, and the drive for an integral action "
        "that is not declared"
    )


@sentence.register
def other_velocity(finding: OtherVelocity) -> str:
    """Return the end of the sentence of a repaired law: a velocity that is computed otherwise."""
    return f"with the velocity of the law {finding.law}, which has the same gains. Declare that law"


@sentence.register
def undeclared_limit(finding: UndeclaredLimit) -> str:
    """Return the end of the sentence of a repaired law: a lower limit of the drive."""
    return (
        f"with a drive that is at its limit of {finding.limit:.6g} {finding.unit} in "
        f"{samples_text(finding.samples)}. Declare that limit"
    )


@sentence.register
def found_gains_agree(finding: FoundGainsAgree) -> str:
    """Return the gains of the control, their distance from the fitted gains, and the residual."""
    return (
        f"the recorded control has {_values_text(finding.gains)}, {finding.standard_errors:.2g} "
        f"joint standard errors from the gains of the fit; with them, {sentence(finding.finding)}"
    )


@sentence.register
def found_gains_differ(finding: FoundGainsDiffer) -> str:
    """Return the gains of the control and of the fit, their distance, and the instruction."""
    residual = ""
    if finding.residual_percent is not None:
        residual = f" ({_residual(finding.residual_percent)})"
    gains = "this gain and keep it" if len(finding.gains) == 1 else "these gains and keep them"
    return (
        f"the recorded control follows the law with {_values_text(finding.gains)}{residual}, but "
        f"the fit finds {_values_text(finding.found)}, {finding.standard_errors:.2g} joint "
        "standard errors away. An unmodelled force, or an undeclared delay of the law, changes the "
        f"gains of the fit. Check the model and the delay, or declare {gains} fixed"
    )


@sentence.register
def law_of_second_record(finding: LawOfSecondRecord) -> str:
    """Return the result that does not hold, then the comparison of the second record and law."""
    return f"{_NOT_HOLDING[finding.result]}{sentence(finding.finding)}"


@sentence.register
def control_scale_moves(finding: ControlScaleMoves) -> str:
    """Return the change of a parameter by a wrong scale of the control, then the residual."""
    return (
        f"the control may be recorded {finding.scale:.5g} times as large as it is, which changes "
        f"{finding.parameter} by {finding.change:+.2g} {finding.unit} "
        f"({finding.standard_errors:.2g} standard errors), although "
        f"{sentence(finding.finding)}. Check the scale of the control and the gains of the law"
    )


@sentence.register
def noise_gain(finding: NoiseGain) -> str:
    """Return the noise of the control relative to the law; a wrong ratio has an instruction."""
    text = (
        f"the noise of the position appears in the control {finding.ratio:.3g} times as large as "
        "with the declared control law"
    )
    if finding.agrees:
        return text
    return (
        f"{text}. Check the units of the position and of the control, and the gains and the period "
        "of the law"
    )


def samples_text(count: int) -> str:
    """Return a number of samples: ``1 sample``, ``2 samples``."""
    return f"{count} sample{'s' * (count != 1)}"


def shift_text(role: str, samples: int) -> str:
    """Return the instruction to move the column of `role` by a whole number of samples."""
    return sentence(AdvisedShift(role=role, samples=float(samples), is_whole=True))


def _plain(value: float) -> str:
    """Return a number with six digits and without a power of ten, as in settings."""
    return np.format_float_positional(float(f"{value:.6g}"), trim="-")


def _residual(percent: float) -> str:
    """Return an rms residual relative to the control: ``rms residual 3 % of the control``."""
    return f"rms residual {_relative_to_control(percent)}"


def _relative_to_control(percent: float) -> str:
    """Return a size relative to the control; from 100 % on ``larger than the control``."""
    if percent < 100:
        return f"{percent:.3g} % of the control"
    return "larger than the control"


def _differs(finding: ControlDiffers) -> str:
    """Return the statement that the control does not follow the law, with the residual."""
    residual = _residual(finding.residual_percent)
    if finding.is_large:
        return f"the recorded control does not follow the declared control law ({residual})"
    return f"the recorded control follows the declared control law except for a factor ({residual})"


def _gains_text(gains: Sequence[OtherGain]) -> str:
    """Return the gains that differ from the declared ones, each with its factor."""
    return listed(
        [
            f"{gain.name} is {gain.value:.5g} instead of {gain.declared:.5g} ({gain.times:.4g} "
            "times the declared gain)"
            for gain in gains
        ]
    )


def _values_text(gains: Mapping[str, float]) -> str:
    """Return gains with their values as a list: ``kp = 160 and kv = 243``."""
    return listed([f"{name} = {value:.5g}" for name, value in gains.items()])


def _scale_text(scale: ControlScale) -> str:
    """Return the factor, or the wrong sign, with which the control is recorded."""
    if scale.times < 0:
        return "the sign of the recorded control is opposite to that of the law"
    units = ""
    if scale.units is not None:
        units = f" (as with one unit in place of another: {scale.units[0]} for {scale.units[1]})"
    return (
        f"the recorded control is {scale.times:.4g} times the true control{units}, and every "
        "estimate is scaled by this factor"
    )


def _check_scale(scale: ControlScale) -> str:
    """Return the instruction for a control that is recorded with another scale or sign.

    It begins with a small letter.
    """
    if scale.times < 0:
        return (
            "check the sign of the control, of the positions or of the gains, and which column is "
            "the position and which the reference"
        )
    return (
        "check the unit and the scaling of the control. A wrong factor of both "
        "position and reference has the same effect. Check the units of these two columns too"
    )
