"""A control that is logged at another time than it acts, told from a law of another delay.

Both leave the same in the recorded control: it is the declared law's, some samples earlier or
later. They differ in the motion. A control that is recorded when it acts moves the axis as its
hold says; one that a logger writes as it is computed moves it whole samples later.
"""

from dataclasses import dataclass, replace

from axisid.estimation.diagnostics.law import LawCheck
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.thresholds import MAX_DELAY_DEVIATION, MAX_DELAY_DISTANCE, MAX_MISALIGNMENT
from axisid.modeling.declaration import ControlLaw
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy, Setting

from .alignment import Alignment


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceTiming:
    """How many samples after it is recorded a control or a force acts, beside its hold.

    Attributes
    ----------
    role : str
        ``control`` or ``force``.
    samples : int
        Whole ones; negative where it acts before it is recorded.
    found, deviation : float
        As the motion shows it, samples.
    """

    role: str
    samples: int
    found: float
    deviation: float

    @property
    def shift(self) -> Setting:
        """What moves the column to where it acts."""
        return Setting("shift", f"{self.role}={self.samples}")

    @property
    def text(self) -> str:
        """What the motion shows."""
        when = "after" if self.found > 0 else "before"
        return (
            f"acts {abs(self.found):.2f} +- {self.deviation:.2g} samples {when} it is recorded, "
            "its hold apart"
        )


def force_timing(data: FilteredRecord, profile: Alignment | Missing) -> ForceTiming | Missing:
    """Whole samples between where a force is recorded and where it acts, or why they are unknown.

    Parameters
    ----------
    data : FilteredRecord
    profile : Alignment or Missing
    """
    if isinstance(profile, Missing):
        return profile
    if profile.deviation > MAX_DELAY_DEVIATION.value or profile.at_the_end:
        return Missing("the motion does not show when the force acts")
    apart = profile.best - data.hold_delay
    samples = round(apart)
    margin = max(MAX_MISALIGNMENT.value, MAX_DELAY_DISTANCE.value * profile.deviation)
    if abs(apart - samples) > min(margin, 0.5):
        return Missing(f"the force acts {apart:.2f} samples after it is recorded, no whole number")
    role = "control" if data.record.force is None else "force"
    return ForceTiming(role=role, samples=samples, found=apart, deviation=profile.deviation)


def law_in_time(
    law: LawCheck | Missing, declared: ControlLaw | None, timing: ForceTiming | Missing
) -> LawCheck | Missing:
    """A law check that says which of shift and delay the motion supports, where it is one."""
    if isinstance(law, Missing) or not law.delay or declared is None or declared.continuous:
        return law
    if isinstance(timing, Missing):
        why = f". Which of them, this record does not tell: {timing}"
        return replace(law, remedy=Remedy.of(law.remedy, why))
    if timing.role != "control":
        return law
    if not timing.samples:
        late = declared.delay + law.delay
        if late < 0 and not declared.delay:
            said = Remedy.of(
                f"and the control {timing.text}: see whether position or reference is written "
                "late, and move it with ",
                Setting("shift", f"reference={law.delay}"),
                " or the like",
            )
            return replace(law, remedy=said)
        motion = f"The motion supports that: the control {timing.text}"
        return replace(law, remedy=Remedy.of(f"declare delay={max(late, 0)}. {motion}"))
    return replace(
        law,
        remedy=Remedy.of(
            f"the log is to blame, as the control {timing.text}: move it there with ",
            timing.shift,
            _and_delay(declared, law, timing.samples),
        ),
    )


def timing_remedy(
    timing: ForceTiming | Missing, declared: ControlLaw | None, law: LawCheck | Missing
) -> Remedy | None:
    """What to do about a force that acts whole samples after it is recorded."""
    if isinstance(timing, Missing) or not timing.samples:
        return None
    of_law = None if timing.role == "force" else _and_delay(declared, law, timing.samples)
    return Remedy.of(
        f"Where the log writes the {timing.role} "
        f"{'before the drive applies it' if timing.samples > 0 else 'after it acted'}, move it "
        "with ",
        timing.shift,
        of_law,
    )


def _and_delay(declared: ControlLaw | None, law: LawCheck | Missing, samples: int) -> str:
    """The delay of the law that goes with a control that is moved, where it is another one."""
    if declared is None or declared.continuous or isinstance(law, Missing):
        return ""
    more = law.delay + samples
    is_in_law = law.passed or law.delay  # but for its time
    known = is_in_law and more and declared.delay + more >= 0
    return f", and declare delay={declared.delay + more}" if known else ""
