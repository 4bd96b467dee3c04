"""Whether a record is sampled as the declared control law runs: the only second word on its time.

A time column in another unit, or scaled, changes every inertia by its square and leaves no other
trace in a record without reference. Where the axis declares a law, its period is compared with the
log's own; a log that is slower or faster than the loop is to be confirmed by the user, or the law
declared to have a clock of its own. A continuous law has none.
"""

from dataclasses import dataclass, replace

from axisid.estimation.raw_tables import PeriodSource
from axisid.modeling.declaration import ControlLaw

from .clocks import period_uncertainty
from .record import Record


@dataclass(frozen=True, slots=True, kw_only=True)
class PeriodConflict:
    """A log that is not sampled as the control law runs.

    Attributes
    ----------
    confirmed : bool
        The user said so beside the log's own times.
    note : str
        What is said of it, and what to do.
    """

    confirmed: bool
    note: str


def is_same_period(one: float, other: float, uncertainty: float = 0.0) -> bool:
    """Whether two sampling periods are the same; `uncertainty` is relative, of either."""
    return abs(one / other - 1) <= 5e-4 + uncertainty  # ten times what crystals differ by


def clock_of(record: Record) -> PeriodSource:
    """Whose word the period of a record is; one of arrays has its own times."""
    stated, clock = record.sample_period is not None, record.provenance.clock
    if clock is not None:
        return replace(clock, stated=clock.stated and stated)
    jitter = period_uncertainty([record.time[start:stop] for start, stop in record.spans])
    return PeriodSource(uncertainty=0.0 if stated else jitter, stated=stated)


def evaluations_per_sample(
    law: ControlLaw | None, period: float, clock: PeriodSource
) -> float | None:
    """How often a law is evaluated in a sample of a record: 1 where both have one clock.

    It is 1 for a continuous law, and without one.

    Parameters
    ----------
    law : ControlLaw or None
    period : float
        Of the record, s.
    clock : PeriodSource

    Returns
    -------
    float or None
        None where the periods differ and nobody says that they should, or because the record was
        resampled.
    """
    jitter = clock.uncertainty if clock.step == 1 else 0.0
    if law is None or law.continuous or is_same_period(period, law.period, jitter):
        return 1.0
    other = period_conflict(law, period, clock)
    vouched = clock.step == 1 and other is not None and other.confirmed
    return period / law.period if vouched else None


def hold_delay(law: ControlLaw | None, period: float, clock: PeriodSource) -> float:
    """By how much a drive that holds its control delays it, samples: half of how long it does."""
    return 0.5 / max(evaluations_per_sample(law, period, clock) or 1.0, 1.0)


def period_conflict(
    law: ControlLaw | None, period: float, clock: PeriodSource
) -> PeriodConflict | None:
    """What is wrong with the sampling period of a log; None where nothing speaks against it.

    Parameters
    ----------
    law : ControlLaw or None
        Of the axis; without one there is nothing to compare with.
    period : float
        Of the record, s.
    clock : PeriodSource
    """
    logged = clock.step * period
    if law is None or law.continuous or is_same_period(logged, law.period, clock.uncertainty):
        return None
    sentence = (
        f"the record is sampled every {logged:.6g} s, the control law runs every {law.period:.6g} s"
    )
    if law.reference_between or (clock.stated and not clock.counted):
        whose = "is declared" if law.reference_between else "the period that was given confirms"
        return PeriodConflict(confirmed=True, note=f"{sentence}, as {whose}")
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
    return PeriodConflict(confirmed=False, note=f"{sentence}: {advice}")
