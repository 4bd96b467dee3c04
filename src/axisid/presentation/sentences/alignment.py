"""Sentences of the delay of the force."""

from axisid.estimation.diagnostics import (
    DeclaredTooLong,
    DelayBeyondRange,
    ForceDelay,
    LoggedAtOtherTime,
    OtherHold,
    UndeclaredDelay,
)
from axisid.support.settings import setting

from .control_law import shift_text
from .dispatch import sentence


@sentence.register
def force_delay(finding: ForceDelay) -> str:
    """Return the delay of the force, and what puts the force in time with the motion."""
    delay = (
        f"the force acts {_delay_text(finding)} it is recorded, and hold {finding.hold} supposes "
        f"{abs(finding.supposed):g} samples {_side(finding.supposed)}"
    )
    if not finding.by_instruments:
        delay += " (estimated by least squares, which noise may bias)"
    if finding.is_aligned:
        return f"{delay}: a difference of {finding.apart:.2g} samples"
    way = "early" if finding.apart > 0 else "late"
    parts = [
        f"the {finding.role} is {abs(finding.apart):.2g} samples {way} relative to the position: "
        f"{delay}"
    ]
    parts += [sentence(each) for each in finding.remedies]
    effects = [
        f"{each.parameter} by {each.per_sample:+.2g} {each.unit}".rstrip()
        for each in finding.effects
    ]
    parts.append(f"A delay of one sample changes {', '.join(effects)}")
    return ". ".join(parts)


@sentence.register
def other_hold(finding: OtherHold) -> str:
    """Return the instruction to use another hold."""
    text = f"Try {setting('hold', finding.hold)}"
    if finding.or_law_period:
        text += ", or, if the loop is faster than the log, declare the control law with its period"
    return text


@sentence.register
def logged_at_other_time(finding: LoggedAtOtherTime) -> str:
    """Return the instruction to move a column."""
    when = "before the drive applies it" if finding.samples > 0 else "after it acted"
    return (
        f"If the log writes the {finding.role} {when}, {shift_text(finding.role, finding.samples)}"
    )


@sentence.register
def delay_beyond_range(finding: DelayBeyondRange) -> str:
    """Return the instructions for a delay that is larger than any that was tried."""
    role = finding.role
    return (
        f"Compare the times of {role} and position in the log. If the {role} is written early, "
        f"{shift_text(role, finding.samples)}. If the drive is late, declare its delay, "
        f"{finding.seconds:.3g} s or more. Then identify again to see how much delay remains"
    )


@sentence.register
def declared_too_long(finding: DeclaredTooLong) -> str:
    """Return by how much the declared delay is too long, and the delay to declare."""
    remaining = "none"
    if finding.remaining > 0:
        remaining = f"{finding.remaining:.3g} s{' or less' * finding.is_at_least}"
    return (
        f"The drive's delay and lag, declared as {finding.declared:.3g} s in all, are "
        f"{'at least ' * finding.is_at_least}{finding.excess:.3g} s too long. Declare {remaining}"
    )


@sentence.register
def undeclared_delay(finding: UndeclaredDelay) -> str:
    """Return the delay to declare."""
    return (
        f"Declare {finding.seconds:.3g} s {'more ' * finding.is_further}in all as the drive's "
        "delay or lag between command and force"
    )


def _delay_text(finding: ForceDelay) -> str:
    """Return the delay with its standard error, and the side."""
    size = abs(finding.delay)
    if finding.is_at_end:
        return (
            f"{size:g} samples or more (the end of the range that was tried) {_side(finding.delay)}"
        )
    return f"{size:.2f} +- {finding.standard_error:.2g} samples {_side(finding.delay)}"


def _side(delay: float) -> str:
    return "before" if delay < 0 else "after"
