"""A drive's lag or delay from a record: what makes the force act where the motion shows it.

The loop is simulated with a lag, and the delay that the alignment finds beside it is added to the
lag, until there is none. A lag, a delay and the half sample of the hold move the force alike at the
frequencies of a motion: a record shows their sum, so that at most one of them can be estimated, and
the others are to be known.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, build
from axisid.estimation.checks import unless_faulty
from axisid.estimation.diagnostics import Alignment
from axisid.estimation.estimates import Estimate, student_interval
from axisid.estimation.records import Record
from axisid.modeling.declaration import HIDDEN_FROM, Axis
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError, Missing, UsageError, quoted

from .result import DriveTime, Identification

_MAX_TIMING_STEP = 0.05  # deviations, below which a step of a drive's lag or delay has settled

_STEPS = 10
_ROUNDING = 1e-9  # of a sample
_BY = "idm-iv"  # the method that a time is found by

#: Identifies an axis by methods; None for all that axis and record allow.
Identify = Callable[[GeneratedAxis, Sequence[str] | None], Identification]


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveTiming:
    """A lag or a delay as a record shows it.

    Attributes
    ----------
    name : str
        ``lag`` or ``delay``.
    value, deviation : float
        s; the deviation is that of the delay between force and motion.
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


def searched_time(axis: GeneratedAxis, record: Record, name: str, run: Identify) -> DriveTiming:
    """The lag or the delay with which force and motion are aligned.

    Parameters
    ----------
    axis : GeneratedAxis
        With a sampled control law; its own time is where the search starts.
    record : Record
    name : str
        ``lag`` or ``delay``.
    run : callable

    Raises
    ------
    UsageError
        There is no such time, or the control was recorded where nothing shows it.
    EstimationError
        The record does not show it, or the force acts before its command.
    """
    declared = axis.declared
    check_time(declared, record, name)
    value = float(getattr(declared.drive, name))
    for _ in range(_STEPS):
        tried = at_time(axis, name, value)
        result = run(tried, [_BY])
        found = _alignment(declared, result, name)
        step = (found.best - result.data.hold_delay) * record.period
        deviation = found.deviation * record.period
        near = max(_MAX_TIMING_STEP * deviation, _ROUNDING * record.period)
        if abs(step) < near or (value == 0 and step <= 0):
            break
        value = max(value + step, 0.0)
    else:
        raise EstimationError(
            f"axis {declared.name!r}: the estimate of the drive's {name} does not settle; it is "
            f"about {value:.3g} s. See whether the law and the model are right.",
            code="no-convergence",
        )
    if step < -2 * deviation:
        raise EstimationError(
            f"axis {declared.name!r}: the force acts {-step:.3g} s before its command, so there is "
            f"no {name} to estimate; see whether the control is logged late, and its hold.",
            code="drive-time",
        )
    own = result.preferred.parameters
    return DriveTiming(
        name=name,
        value=value,
        deviation=deviation,
        axis=tried.declared,
        identification=result,
        deviations={
            n: float(np.hypot(own[n].deviation, by * found.deviation))
            for n, by in zip(found.names, found.sensitivity, strict=True)
        },
    )


def at_time(axis: GeneratedAxis, name: str, value: float) -> GeneratedAxis:
    """The axis with another lag or delay of its drive, s, which is then known.

    To compile its loop takes less than a search without does.
    """
    declared = axis.declared
    drive = declared.drive.with_time(name, value)
    return build(replace(declared, drive=drive), native=axis.native.enabled)


def identified_with_time(
    axis: GeneratedAxis, records: Sequence[Record], run: Identify, methods: Sequence[str] | None
) -> Identification:
    """Identify an axis whose drive has a lag or a delay that is estimated too.

    Every deviation of the parameters has in it what that of the time adds: the estimates are made
    once more with the time a deviation longer.

    Raises
    ------
    UsageError
        There are several records, or as `searched_time`.
    EstimationError
        As `searched_time`.
    """
    declared = axis.declared
    name, parameter = declared.drive.estimated or ("lag", Parameter("lag", "s"))
    if len(records) > 1:
        raise UsageError(
            f"axis {declared.name!r}: the drive's {name} is to be estimated, which one record "
            f"tells, and {len(records)} are given; identify it from one of them, and declare it as "
            "a number for all.",
            code="drive-time",
        )
    found = searched_time(axis, records[0], name, run)
    result = run(at_time(axis, name, found.value), methods)
    later = at_time(axis, name, found.value + found.deviation)
    moved = run(later, [*result.estimates])
    freedom = float(len(result.preferred.y) - len(result.preferred.theta))
    low, high = student_interval(found.value, found.deviation, freedom)
    return replace(
        result,
        estimates={n: _widened(e, moved.estimates[n]) for n, e in result.estimates.items()},
        drive_time=DriveTime(
            name=name,
            parameter=parameter,
            value=found.value,
            deviation=found.deviation,
            interval=(max(low, 0.0), high),
        ),
    )


def _widened(estimate: Estimate, moved: Estimate) -> Estimate:
    """An estimate whose covariances have in them that a time may be a deviation longer."""
    changed: dict[str, dict[str, Array]] = {
        "covariances": _beside(estimate.covariances, moved.physical - estimate.physical)
    }
    if estimate.is_direct:
        by = moved.theta_ddm - estimate.theta_ddm
        changed["ddm_covariances"] = _beside(estimate.ddm_covariances, by)
    return estimate.with_inference(**changed)


def _beside(covariances: Mapping[str, Array], moved: Array) -> dict[str, Array]:
    return {name: matrix + np.outer(moved, moved) for name, matrix in covariances.items()}


def check_time(declared: Axis, record: Record, name: str, *, by_law: bool = True) -> None:
    """Refuse a time that a record cannot show, of a loop under a law or of one without.

    Raises
    ------
    UsageError
        There is no such time, or the control was recorded where nothing shows it.
    """
    if name not in HIDDEN_FROM:
        raise UsageError(
            f"{quoted(name)} is no time of a drive; give 'lag' or 'delay', one of them: a record "
            "shows their sum.",
            code="drive-time",
        )
    law = declared.control
    unsampled = by_law and (law is None or law.continuous)
    if unsampled or record.force is not None or record.control is None:
        raise UsageError(
            f"axis {declared.name!r}: the drive's {name} is told by a recorded control"
            f"{' of a sampled law' * by_law}, and by no force that was measured.",
            code="drive-time",
        )
    if declared.drive.logged in HIDDEN_FROM[name]:
        raise UsageError(
            f"axis {declared.name!r}: the control was recorded behind the drive's {name} "
            f"(logged={declared.drive.logged!r}), so that the motion does not show it.",
            code="drive-time",
        )


def _alignment(declared: Axis, result: Identification, name: str) -> Alignment:
    """The alignment of an identification, where it tells the time."""
    found = unless_faulty(lambda: result.case.parts[0].alignment)
    if isinstance(found, Missing) or found.at_the_end:
        why = "the record tells no delay between force and motion"
        raise EstimationError(
            f"axis {declared.name!r}: the drive's {name} cannot be estimated: "
            f"{found if isinstance(found, Missing) else why}.",
            code="drive-time",
        )
    return found
