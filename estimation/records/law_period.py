"""Whether a record is sampled as the declared control law runs: the only second word on its time.

A time column in another unit, or scaled, changes every inertia by its square and leaves no other
trace in a record without reference. Where the axis declares a law, its period is compared with the
log's own; a log that is slower or faster than the loop is to be confirmed by the user, or the law
declared to have a clock of its own. A continuous law has none.
"""

from dataclasses import dataclass

from axisid.estimation.raw_tables import PeriodSource
from axisid.modeling.declaration import ControlLaw

from .clocks import period_uncertainty
from .record import Record


@dataclass(frozen=True, slots=True, kw_only=True)
class LawClock:
    """How a record is sampled beside the control law of its axis.

    Attributes
    ----------
    ratio : float or None
        How often the law is evaluated in a sample: 1 where both have one clock, of a continuous
        law, and without one. None where the periods differ and nobody says that they should, or
        because the record was resampled.
    resampled : bool
        Whether the record has other samples than its log.
    doubt : str
        What is wrong with the period of the log, and what to do; empty for nothing.
    confirmed : str
        That it is not the law's, where the user or the law says so.
    """

    ratio: float | None
    resampled: bool
    doubt: str = ""
    confirmed: str = ""

    @property
    def hold_delay(self) -> float:
        """By how much a drive that holds its control delays it, samples: half of how long."""
        return 0.5 / max(self.ratio or 1.0, 1.0)


def is_same_period(one: float, other: float, uncertainty: float = 0.0) -> bool:
    """Whether two sampling periods are the same; `uncertainty` is relative, of either."""
    return abs(one / other - 1) <= 5e-4 + uncertainty  # ten times what crystals differ by


def law_clock(law: ControlLaw | None, record: Record) -> LawClock:
    """The period of a record beside that of a law; without one there is nothing to compare with."""
    period, clock = record.period, record.provenance.clock
    stated = record.sample_period is not None and (clock is None or clock.stated)
    if clock is None:  # a record of arrays has its own times
        jitter = period_uncertainty([record.time[start:stop] for start, stop in record.spans])
        clock = PeriodSource(uncertainty=0.0 if stated else jitter)
    logged, resampled = clock.step * period, clock.step != 1
    if law is None or law.continuous:
        return LawClock(ratio=1.0, resampled=resampled)
    jitter = 0.0 if resampled else clock.uncertainty
    ratio = 1.0 if is_same_period(period, law.period, jitter) else None
    if is_same_period(logged, law.period, clock.uncertainty):
        return LawClock(ratio=ratio, resampled=resampled)
    sentence = (
        f"the record is sampled every {logged:.6g} s, the control law runs every {law.period:.6g} s"
    )
    if law.reference_between or (stated and not clock.counted):
        whose = "is declared" if law.reference_between else "the period that was given confirms"
        return LawClock(
            ratio=ratio if resampled else period / law.period,
            resampled=resampled,
            confirmed=f"{sentence}, as {whose}",
        )
    count = round(logged / law.period)
    decimated = 2 <= count <= 1000 and is_same_period(logged / law.period, count)
    which = f"keeps one sample in {count}" if decimated else "has a clock of its own"
    advice = (
        "check the time column and its unit, or declare the drive's period; if the log "
        f"{which}, confirm that by sample_period = {logged:.6g} in run.toml"
    )
    if clock.counted:
        advice = (
            "check sample_period in run.toml, which nothing else confirms, against the "
            "drive's period; where the log is no record of every period, give its time "
            "column, or declare how the reference runs between its samples "
            "(reference_between), which says that the law has a clock of its own"
        )
    return LawClock(ratio=ratio, resampled=resampled, doubt=f"{sentence}: {advice}")
