"""Findings of the delay of the force, and remedies that align the force with the motion."""

from dataclasses import dataclass

from axisid.estimation.findings import Finding


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherHold(Finding):
    """The hold that assumes the estimated delay of the force.

    Attributes
    ----------
    hold : {"zoh", "raw"}
    or_law_period : bool
        Whether a control law with its period may be declared instead.
    """

    hold: str
    or_law_period: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class LoggedAtOtherTime(Finding):
    """A control or force that the log may write at another time than it acts.

    Attributes
    ----------
    role : {"control", "force"}
    samples : int
        Shift of the column that corrects it; positive if it is logged before it acts.
    """

    role: str
    samples: int


@dataclass(frozen=True, slots=True, kw_only=True)
class DelayBeyondRange(Finding):
    """A delay of the force that is larger than any that was tried.

    Attributes
    ----------
    role : {"control", "force"}
    samples : int
        Delay that is not yet taken into account, at least.
    seconds : float
        This delay, s.
    """

    role: str
    samples: int
    seconds: float


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclaredTooLong(Finding):
    """A declared delay and lag of the drive that are longer than the delay of the force.

    Attributes
    ----------
    declared : float
        Sum of the declared delay and lag, s.
    excess : float
        Amount by which the sum is too long, s.
    is_at_least : bool
        Whether the excess is the largest that was tried.
    remaining : float
        Correct sum to declare, s; 0 for none.
    """

    declared: float
    excess: float
    is_at_least: bool
    remaining: float


@dataclass(frozen=True, slots=True, kw_only=True)
class UndeclaredDelay(Finding):
    """A delay between command and force that the drive does not declare.

    Attributes
    ----------
    seconds : float
        Delay and lag to declare, s.
    is_further : bool
        Whether this is in addition to a declared delay or lag.
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
        Change for a delay of one sample.
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
        Hold of the prefilter.
    supposed : float
        Delay of the force that the hold assumes, samples: 0 for raw, about 0.5 for zoh.
    apart : float
        Delay minus the assumed delay, samples.
    is_aligned : bool
        Whether both agree.
    role : {"control", "force"}
        Column that gives the force.
    remedies : tuple of Finding
        Changes that make both agree, in order.
    effects : tuple of EffectOfDelay
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
