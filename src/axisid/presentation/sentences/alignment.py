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
    """Return the delay of the force, its effect on the parameters, and the remedies.

    The measured delay is compared with the delay that the hold implies.
    """
    delay = (
        f"the force acts {_delay_text(finding)} it is recorded; hold {finding.hold} implies "
        f"{abs(finding.supposed):g} samples {_before_or_after(finding.supposed)}"
    )
    if not finding.by_instruments:
        delay += " (estimated by least squares, which noise may bias)"
    if finding.is_aligned:
        return f"{delay} (a difference of {finding.apart:.2g} samples)"
    early_or_late = "early" if finding.apart > 0 else "late"
    parts = [
        f"the {finding.role} is {abs(finding.apart):.2g} samples {early_or_late} relative to the "
        f"position: {delay}"
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
    """Return the instruction to use another hold, or to declare the period of the law."""
    text = f"Try {setting('hold', finding.hold)}"
    if finding.or_law_period:
        text += ". If the loop is faster than the log, declare the control law with its period"
    return text


@sentence.register
def logged_at_other_time(finding: LoggedAtOtherTime) -> str:
    """Return the instruction to shift a column that is logged early or late."""
    when = "before the drive applies it" if finding.samples > 0 else "after it acted"
    return (
        f"If the log writes the {finding.role} {when}, {shift_text(finding.role, finding.samples)}"
    )


@sentence.register
def delay_beyond_range(finding: DelayBeyondRange) -> str:
    """Return the instructions for a delay at the end of the search range."""
    role = finding.role
    return (
        f"Compare the times of {role} and position in the log. If the {role} is written early, "
        f"{shift_text(role, finding.samples)}. If the drive is late, declare its delay of "
        f"{finding.seconds:.3g} s or more. Then identify again to see how much delay remains"
    )


@sentence.register
def declared_too_long(finding: DeclaredTooLong) -> str:
    """Return the excess of the declared delay, and the delay to declare instead."""
    at_least, or_less = "", ""
    if finding.is_at_least:
        at_least, or_less = "at least ", " or less"
    remaining = "no delay and no lag"
    if finding.remaining > 0:
        remaining = f"{finding.remaining:.3g} s{or_less}"
    return (
        f"The drive's delay and lag, declared as {finding.declared:.3g} s in all, are {at_least}"
        f"{finding.excess:.3g} s too long. Declare {remaining}"
    )


@sentence.register
def undeclared_delay(finding: UndeclaredDelay) -> str:
    """Return the instruction to declare a delay, or a longer one."""
    more = "more " if finding.is_further else ""
    return (
        f"Declare {finding.seconds:.3g} s {more}in all as the drive's delay or lag between command "
        "and force"
    )


def _delay_text(finding: ForceDelay) -> str:
    """Return the delay in samples: ``1.48 +- 0.02 samples after``.

    At the end of the search range there is no standard error.
    """
    size, before_or_after = abs(finding.delay), _before_or_after(finding.delay)
    if finding.is_at_end:
        return f"{size:g} samples or more (the end of the search range) {before_or_after}"
    return f"{size:.2f} +- {finding.standard_error:.2g} samples {before_or_after}"


def _before_or_after(delay: float) -> str:
    """Return ``before`` for a negative delay, else ``after``."""
    return "before" if delay < 0 else "after"
