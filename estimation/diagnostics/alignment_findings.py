"""Findings of the delay of the force, and of what puts the force in time with the motion."""

from dataclasses import dataclass

from axisid.estimation.findings import Finding


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherHold(Finding):
    """A hold that supposes the delay of the force that was estimated.

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
        To move it by; positive where it is written before it acts.
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
        Delay that is not taken into account yet, at least.
    seconds : float
        The same, s.
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
        Of both together, s.
    excess : float
        By which they are too long, s.
    is_at_least : bool
        Whether the excess is the largest that was tried.
    remaining : float
        To declare, s; 0 for none.
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
        To declare as delay and lag, s.
    is_further : bool
        Whether that is more than the drive declares already.
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
        For a delay of one sample.
    unit : str
    """

    parameter: str
    per_sample: float
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceDelay(Finding):
    """The delay of the force against the one that the hold supposes.

    Attributes
    ----------
    delay : float
        Samples by which the force acts after it is recorded.
    standard_error : float
        Of the delay, samples.
    is_at_end : bool
        Whether the delay is the end of the range that was tried.
    by_instruments : bool
        Whether it is estimated by the simulated loop; otherwise by least squares, which noise may
        bias.
    hold : {"raw", "zoh"} or None
        Of the prefilter.
    supposed : float
        Delay that the hold supposes, samples.
    apart : float
        Delay minus the supposed one, samples.
    is_aligned : bool
        Whether both agree.
    role : {"control", "force"}
        Column that gives the force.
    remedies : tuple of Finding
        Ways to agree, one after another.
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
