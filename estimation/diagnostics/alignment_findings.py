"""Findings about the delay of the force, and remedies that align the force with the motion."""

from dataclasses import dataclass

from axisid.estimation.findings import Finding


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherHold(Finding):
    """Remedy: the other hold of the prefilter, which assumes the estimated delay of the force.

    Attributes
    ----------
    hold : {"zoh", "raw"}
        Hold to set.
    or_law_period : bool
        Whether a control law with its period may be declared instead.
    """

    hold: str
    or_law_period: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class LoggedAtOtherTime(Finding):
    """Remedy: a shift of a control or force that was logged at another time than it acts.

    Attributes
    ----------
    role : {"control", "force"}
        Column to shift.
    samples : int
        Shift to later times; positive if the column is logged before it acts.
    """

    role: str
    samples: int


@dataclass(frozen=True, slots=True, kw_only=True)
class DelayBeyondRange(Finding):
    """A delay of the force at the upper end of its search range.

    Attributes
    ----------
    role : {"control", "force"}
        Column that gives the force.
    samples : int
        Least delay in addition to that of the hold, samples.
    seconds : float
        The same delay, s.
    """

    role: str
    samples: int
    seconds: float


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclaredTooLong(Finding):
    """Remedy: a shorter delay and lag of the drive, because the declared sum is too long.

    Attributes
    ----------
    declared : float
        Sum of the declared delay and lag, s.
    excess : float
        Amount by which the sum is too long, s.
    is_at_least : bool
        Whether the excess is the end of the search range, and may be larger.
    remaining : float
        Correct sum to declare, s; 0 for no delay and lag.
    """

    declared: float
    excess: float
    is_at_least: bool
    remaining: float


@dataclass(frozen=True, slots=True, kw_only=True)
class UndeclaredDelay(Finding):
    """Remedy: a declaration of a delay between command and force.

    Attributes
    ----------
    seconds : float
        Sum of delay and lag to declare, s.
    is_further : bool
        Whether the sum is in addition to a declared delay or lag.
    """

    seconds: float
    is_further: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectOfDelay:
    """Change of a parameter by a delay of the force.

    Attributes
    ----------
    parameter : str
    per_sample : float
        Change for a delay of one sample, in `unit`.
    unit : str
    """

    parameter: str
    per_sample: float
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceDelay(Finding):
    """Comparison of the delay of the force with the delay that the hold assumes.

    Attributes
    ----------
    delay : float
        Samples by which the force acts after it is recorded.
    standard_error : float
        Standard error of the delay, samples.
    is_at_end : bool
        Whether the delay is the end of the range that was tried.
    by_instruments : bool
        Whether the delay is estimated with the simulated loop; otherwise by least squares, which
        noise may bias.
    hold : {"raw", "zoh"} or None
        Hold of the prefilter; None where the prefilter sets none.
    supposed : float
        Delay of the force that the hold assumes, samples: 0 for raw, about 0.5 for zoh.
    apart : float
        Delay minus the assumed delay, samples.
    is_aligned : bool
        Whether the two delays agree.
    role : {"control", "force"}
        Column that gives the force.
    remedies : tuple of Finding
        Changes that make the two delays agree, in the order in which to try them; empty if they
        agree.
    effects : tuple of EffectOfDelay
        Change of each parameter by a delay of the force.
    """

    delay: float
    standard_error: float
    is_at_end: bool
    by_instruments: bool
    hold: str | None
    supposed: float
    apart: float
    is_aligned: bool
    role: str
    remedies: tuple[Finding, ...]
    effects: tuple[EffectOfDelay, ...]
