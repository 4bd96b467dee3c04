"""A drive's lag or delay from a record: what makes the force act where the motion shows it.

The loop is simulated with a lag, and the delay that the alignment finds beside it is added to the
lag, until there is none. A lag, a delay and the half sample of the hold move the force alike at the
frequencies of a motion: a record shows their sum, so that at most one of them can be estimated, and
the others are to be known.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from axisid.codegen.artefacts import GeneratedAxis, build
from axisid.estimation.diagnostics.loop import Alignment
from axisid.estimation.identification import Identification, identify
from axisid.estimation.records import Record
from axisid.estimation.signals import Prefilter
from axisid.estimation.thresholds.studies import MAX_TIMING_STEP
from axisid.modeling.declaration import Axis
from axisid.support.errors import EstimationError, UsageError
from axisid.support.missing import Missing
from axisid.support.user_values import quoted

_STEPS = 10
#: Of the drive, and where the recorded control shows none of it.
_TIMES = {"lag": ("current",), "delay": ("applied", "current")}
_FEW = 100_000  # samples, of which a virtual machine is done before a compiler


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveTiming:
    """A lag or a delay as a record shows it.

    Attributes
    ----------
    name : str
        ``lag`` or ``delay``.
    value, deviation : float
        s; the deviation is HAC, that of the delay between force and motion.
    axis : Axis
        As it was declared, with the estimate.
    identification : Identification
        Of that axis, whose deviations hold for a lag or a delay that is known.
    deviations : mapping of str to float
        Of the parameters, with what the estimate's own deviation adds.
    """

    name: str
    value: float
    deviation: float
    axis: Axis
    identification: Identification
    deviations: Mapping[str, float]

    def __str__(self) -> str:
        return f"{self.name} = {1e3 * self.value:.4g} +- {1e3 * self.deviation:.2g} ms"


def estimate_drive_timing(
    axis: Axis | GeneratedAxis,
    record: Record,
    name: str = "lag",
    prefilter: Prefilter | None = None,
) -> DriveTiming:
    """Estimate the lag or the delay of an axis's drive, and its parameters with it.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        With a sampled control law. What is declared of the other time is taken as known.
    record : Record
        With a control and a reference.
    name : str
        ``lag`` or ``delay``: at most one, since a record shows their sum.
    prefilter : Prefilter, optional
        What suits the record by default.

    Raises
    ------
    UsageError
        There is no such time, or the control was recorded where nothing shows it.
    EstimationError
        The record does not show it, or the force acts before its command.
    """
    declared = axis.declared if isinstance(axis, GeneratedAxis) else axis
    _check(declared, record, name)
    value = float(getattr(declared.drive, name))
    for _ in range(_STEPS):
        tried = _with(declared, name, value)
        result = identify(
            build(tried, native=len(record) > _FEW), record, prefilter, methods=["idm-iv"]
        )
        found = _alignment(declared, result, name)
        step = (found.best - result.data.hold_delay) * record.period
        deviation = found.deviation * record.period
        if abs(step) < MAX_TIMING_STEP.value * deviation or (value == 0 and step <= 0):
            break
        value = max(value + step, 0.0)
    else:
        raise EstimationError(
            f"axis {declared.name!r}: the estimate of the drive's {name} does not settle; it is "
            f"about {value:.3g} s. See whether the law and the model are right.",
            code="drive-timing-unsettled",
        )
    if step < -2 * deviation:
        raise EstimationError(
            f"axis {declared.name!r}: the force acts {-step:.3g} s before its command, so there is "
            f"no {name} to estimate; see whether the control is logged late, and its hold.",
            code="drive-timing-early",
        )
    moved = dict(zip(found.names, found.sensitivity * found.deviation, strict=True))
    own = result.preferred.parameters
    return DriveTiming(
        name=name,
        value=value,
        deviation=deviation,
        axis=tried,
        identification=result,
        deviations={n: float((own[n].deviation ** 2 + moved[n] ** 2) ** 0.5) for n in moved},
    )


def _check(declared: Axis, record: Record, name: str) -> None:
    """Refuse what a record cannot show."""
    if name not in _TIMES:
        raise UsageError(
            f"{quoted(name)} is no time of a drive; give 'lag' or 'delay', one of them: a record "
            "shows their sum.",
            code="drive-timing-name",
        )
    law = declared.control
    if law is None or law.continuous or record.force is not None or record.control is None:
        raise UsageError(
            f"axis {declared.name!r}: the drive's {name} is told by a recorded control of a "
            "sampled law, and by no force that was measured.",
            code="drive-timing-record",
        )
    if declared.drive.logged in _TIMES[name]:
        raise UsageError(
            f"axis {declared.name!r}: the control was recorded behind the drive's {name} "
            f"(logged={declared.drive.logged!r}), so that the motion does not show it.",
            code="drive-timing-logged",
        )


def _with(declared: Axis, name: str, value: float) -> Axis:
    changed = {name: value}
    return replace(declared, drive=replace(declared.drive, **changed))  # type: ignore[arg-type]


def _alignment(declared: Axis, result: Identification, name: str) -> Alignment:
    """The alignment of an identification, where it tells the time."""
    found = result.diagnosis.alignment
    if isinstance(found, Missing) or found.at_the_end:
        why = "the record tells no delay between force and motion"
        raise EstimationError(
            f"axis {declared.name!r}: the drive's {name} cannot be estimated: "
            f"{found if isinstance(found, Missing) else why}.",
            code="drive-timing-unknown",
        )
    return found
