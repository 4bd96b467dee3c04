"""Sentences of sudden steps, outliers and recorded signals, and of the shift of a column."""

from axisid.estimation.diagnostics import Outliers, RecordedSignals, SuddenSteps
from axisid.estimation.misspecification import LateSignal, OutlyingSample, ScaledSignal
from axisid.estimation.records import AdvisedShift
from axisid.support.settings import setting

from .dispatch import sentence
from .missing_terms import share_text
from .words import capitalised, one_after_another

_LEAST_DELAY_ERROR = 0.01  # samples, as it is printed


@sentence.register
def sudden_steps(finding: SuddenSteps) -> str:
    """Return the largest sudden step with its time, its cause and the remedy.

    The size is None if the position has no sudden step.
    """
    if finding.size is None:
        return "the position has no sudden step"
    number = ""
    if finding.number > 1:
        number = f" (the largest of {finding.number} such steps)"
    return (
        f"the position moves by {finding.size:.3g} {finding.unit} in one sample period, "
        f"{finding.seconds:.6g} s into the log{number}, unlike the periods before and after it. "
        f"{_cause_and_remedy(finding)}"
    )


def _cause_and_remedy(finding: SuddenSteps) -> str:
    """Return the likely cause of the sudden steps of the position, and the remedy."""
    if finding.cause == "new turn":
        return (
            "The position jumps back by its whole range, as with a position that restarts after "
            f"each turn. Declare this range, such as {setting('wrap', '360:deg')}, or unwrap the "
            "position first"
        )
    repair = "Exclude these places with windows of the log, or repair the recorder"
    there = "at this place"
    if finding.is_in_reference:
        there = "at this place, because the reference makes the same step"
    if finding.cause == "repeated sample":
        return f"A sample is recorded twice {there}, or the encoder stood still. {repair}"
    if finding.cause == "stuck encoder":
        return (
            f"The position stood still for {finding.held} periods before the step: the encoder was "
            f"stuck. {repair}"
        )
    if finding.cause == "lost samples":
        return f"Samples are missing {there}. {repair}"
    return f"Samples are missing at this place, or the encoder lost counts. {repair}"


@sentence.register
def outliers(finding: Outliers) -> str:
    """Return the samples that are outliers, and the instruction to exclude them.

    The instruction is omitted if the loss function limits the weight of outliers already.
    """
    if not finding.found:
        return "no single sample is an outlier"
    text = one_after_another([sentence(each) for each in finding.found])
    if finding.is_bounded:
        return text
    return (
        f"{text}. Empty these cells of the log and read it with {setting('resample', 'auto')}, or "
        f"reduce the weight of outliers with {setting('loss', 'huber')}"
    )


@sentence.register
def outlying_sample(finding: OutlyingSample) -> str:
    """Return the sample with its deviation from the expected value, and its share of the force."""
    size = f"{finding.size:+.3g} +- {finding.standard_error:.1g} {finding.unit}".rstrip()
    return (
        f"the {finding.role} is off by {size} at sample {finding.sample}, {finding.seconds:.6g} s "
        f"after the first sample. The effect on the force is {share_text(finding.share)}"
    )


@sentence.register
def recorded_signals(finding: RecordedSignals) -> str:
    """Return the signals that are late or wrongly scaled, and the remedy for the first."""
    if not finding.found:
        return (
            "the recorded signals agree with the forces that they cause, both in time and in size"
        )
    text = one_after_another([_signal_statement(each) for each in finding.found])
    return f"{text}. {_signal_remedy(finding.found[0])}"


@sentence.register
def late_signal(finding: LateSignal) -> str:
    """Return the delay of a signal, and the instruction to correct it."""
    return f"{_signal_statement(finding)}. {_signal_remedy(finding)}"


@sentence.register
def scaled_signal(finding: ScaledSignal) -> str:
    """Return the wrong factor of a signal, and the instruction to correct it."""
    return f"{_signal_statement(finding)}. {_signal_remedy(finding)}"


def _signal_statement(finding: LateSignal | ScaledSignal) -> str:
    """Return the delay of a signal in samples, or the factor by which the model scales it."""
    part = f"The effect on the force is {share_text(finding.share)}"
    if isinstance(finding, ScaledSignal):
        return (
            f"the model needs {finding.factor:.4g} +- {finding.standard_error:.1g} times the "
            f"recorded {finding.signal}. {part}"
        )
    samples = abs(finding.samples)
    if finding.at_the_end:
        earlier_or_later = "earlier" if finding.samples > 0 else "later"
        return (
            f"the {finding.signal} does not fit the force that it causes: it fits best "
            f"{samples:.4g} samples {earlier_or_later}, at the end of the search range. {part}"
        )
    late_or_early = "late" if finding.samples > 0 else "early"
    error = max(finding.standard_error, _LEAST_DELAY_ERROR)
    return (
        f"the {finding.signal} is logged {samples:.4g} +- {error:.1g} samples "
        f"({1e3 * abs(finding.seconds):.4g} ms) {late_or_early} relative to the force that it "
        f"causes. {part}"
    )


def _signal_remedy(finding: LateSignal | ScaledSignal) -> str:
    """Return the instruction that corrects a signal, with a capital letter."""
    name = finding.signal
    if isinstance(finding, LateSignal):
        if finding.shift is not None:
            return capitalised(sentence(finding.shift))
        return f"Correct other failed checks first. Then check the column of {name} and its clock"
    column = finding.column or "NAME"
    if finding.likely_unit is not None:
        return f"Declare its unit: {setting('columns', {name: f'{column}:{finding.likely_unit}'})}"
    scaled = setting("columns", {name: f"{column}:UNIT*{finding.factor:.4g}"})
    return f"Check its unit and scale ({scaled}), and the known values of its force"


@sentence.register
def advised_shift(finding: AdvisedShift) -> str:
    """Return the instruction to shift a column by whole or fractional samples.

    A fractional shift needs resampling.
    """
    later_or_earlier = "later" if finding.samples > 0 else "earlier"
    shift = f"{finding.samples:.2f}"
    if finding.is_whole:
        shift = f"{finding.samples:.0f}"
    size = shift.lstrip("-")
    noun = "sample" if size == "1" else "samples"
    text = (
        f"move the {finding.role} {size} {noun} {later_or_earlier}: add {shift} to its shift "
        f"({setting('shift', {finding.role: shift})} if it has none"
    )
    if finding.is_whole:
        return f"{text})"
    return f"{text}; this needs {setting('resample', 'auto')})"
