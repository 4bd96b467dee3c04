"""Estimation of the lag or the delay of a drive together with the parameters.

A lag or delay of the drive shifts the time at which the force acts, which the motion shows. The
loop is simulated with the lag or delay, and the remaining delay that the alignment finds is added
to it until there is none. A lag, a delay and the half sample of the hold have the same effect at
the frequencies of a motion. A record shows their sum, so at most one of them can be estimated, and
the others must be known.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.estimates import Estimate, student_interval
from axisid.estimation.records import Record
from axisid.estimation.verdict_checks import unless_faulty
from axisid.modeling.declaration import HIDDEN_FROM, Axis
from axisid.modeling.quantities import Parameter
from axisid.support.checks import refuse
from axisid.support.errors import EstimationError, UsageError
from axisid.support.missing import Missing

from .result import DriveTime, Identification

#: Function that identifies an axis. Its second argument has the methods, or None for all that axis
#: and record allow. The optional third argument has parameters that are fixed at given bounds; no
#: other parameters are then fixed at a bound.
Identify = Callable[..., Identification]


def with_drive_time(axis: GeneratedAxis, name: str, value: float) -> GeneratedAxis:
    """Return the axis with the lag or delay of its drive fixed at a value, s.

    `name` is ``lag`` or ``delay``. The loop of the axis is compiled again, which takes less time
    than a search without a compiled loop.
    """
    drive = axis.declared.drive.with_time(name, value)
    return build(replace(axis.declared, drive=drive), native=axis.native.enabled)


def identify_with_drive_time(
    axis: GeneratedAxis,
    records: Sequence[Record],
    run: Identify,
    methods: Sequence[str] | None,
) -> Identification:
    """Identify an axis and the lag or delay of its drive.

    The standard errors of the parameters include the uncertainty of the lag or delay. For this, the
    estimates are repeated with a lag or delay that is longer by its standard error.

    Parameters
    ----------
    axis : GeneratedAxis
        Axis whose drive has a lag or delay to be estimated.
    records : sequence of Record
        A single record; several records are refused.
    run : callable
        Identifies an axis with a known lag or delay, see `Identify`.
    methods : sequence of str or None
        Methods to run; None for all that axis and record allow.

    Raises
    ------
    UsageError
        There are several records, or the control was recorded where nothing shows the lag or delay.
    EstimationError
        The record does not show it, or the force acts before its command.
    """
    declared = axis.declared
    name, parameter = declared.drive.estimated or ("lag", Parameter("lag", "s"))
    if len(records) > 1:
        raise UsageError(
            f"axis {declared.name!r}: the drive's {name} can be estimated from one record only, "
            f"and {len(records)} records are given. Estimate it from one of them, and declare the "
            "number for all.",
            code="drive-time",
        )
    value, deviation = _searched(axis, records[0], name, run)
    result = run(with_drive_time(axis, name, value), methods)
    held = {each.name: each.bound for each in result.problem.held}
    longer = run(with_drive_time(axis, name, value + deviation), [*result.estimates], held)
    judged = result.preferred
    low, high = student_interval(value, deviation, float(len(judged.y) - len(judged.theta)))
    return replace(
        result,
        estimates={n: _widened(result.estimates[n], each) for n, each in longer.estimates.items()},
        failed={**result.failed, **longer.failed},
        drive_time=DriveTime(
            name=name,
            parameter=parameter,
            value=value,
            deviation=deviation,
            interval=(max(low, 0.0), high),
        ),
    )


def _searched(axis: GeneratedAxis, record: Record, name: str, run: Identify) -> tuple[float, float]:
    """Return the lag or delay that aligns force and motion, and its standard error, s.

    In each iteration, the axis is identified by IDM-IV with the present lag or delay. The remaining
    delay between force and motion is then added to it, until it is negligible.

    Raises
    ------
    EstimationError
        The record does not show the delay, the iteration does not converge, or the force acts
        before its command.
    """
    declared, period = axis.declared, record.period
    check_drive_time(declared, record, name)
    value = float(getattr(declared.drive, name))
    for _ in range(10):
        result = run(with_drive_time(axis, name, value), ["idm-iv"])
        alignment = unless_faulty(partial(getattr, result.case.parts[0], "alignment"))
        if isinstance(alignment, Missing) or alignment.at_the_end:
            unseen = "the record does not show the delay between force and motion"
            why = alignment if isinstance(alignment, Missing) else unseen
            raise EstimationError(
                f"axis {declared.name!r}: the drive's {name} cannot be estimated: {why}.",
                code="drive-time",
            )
        step, deviation = (
            (alignment.best - result.data.hold_delay) * period,
            alignment.deviation * period,
        )
        # It has converged to a twentieth of its standard error, or to rounding.
        near = max(0.05 * deviation, 1e-9 * period)
        if abs(step) < near or (value == 0 and step <= 0):
            break
        value = max(value + step, 0.0)
    else:
        raise EstimationError(
            f"axis {declared.name!r}: the estimate of the drive's {name} does not converge; it is "
            f"about {value:.3g} s. Check the control law and the model.",
            code="no-convergence",
        )
    if step < -2 * deviation:
        raise EstimationError(
            f"axis {declared.name!r}: the force acts {-step:.3g} s before its command, so there is "
            f"no {name} to estimate. Check whether the control is logged late, and check its hold.",
            code="drive-time",
        )
    return value, deviation


def _widened(estimate: Estimate, longer: Estimate) -> Estimate:
    """Return an estimate whose covariances include the uncertainty of the lag or delay.

    `longer` is the same estimate with a lag or delay that is longer by its standard error. The
    change of the parameters, times itself, is added to every covariance.
    """
    changes = {
        "covariances": longer.physical - estimate.physical,
        "ddm_covariances": longer.theta_ddm - estimate.theta_ddm,
    }
    return estimate.with_inference(
        **{
            which: {n: each + by[:, None] * by for n, each in getattr(estimate, which).items()}
            for which, by in changes.items()
        }
    )


def check_drive_time(declared: Axis, record: Record, name: str, *, by_law: bool = True) -> None:
    """Refuse a lag or delay that a record cannot show.

    Parameters
    ----------
    declared : Axis
    record : Record
    name : {"lag", "delay"}
    by_law : bool
        Whether the lag or delay is found by simulating the declared control law, which must then be
        a sampled one.

    Raises
    ------
    UsageError
        The control was recorded where nothing shows it.
    """
    law = declared.control
    unsampled = by_law and (law is None or law.continuous)
    refuse(
        UsageError,
        (
            unsampled or record.force is not None or record.control is None,
            f"axis {declared.name!r}: the drive's {name} can be estimated from a recorded control"
            f"{' of a sampled law' * by_law}, not from a measured force",
        ),
        (
            declared.drive.logged in HIDDEN_FROM[name],
            f"axis {declared.name!r}: the control was recorded behind the drive's {name} "
            f"(logged={declared.drive.logged!r}), so the record does not show it",
        ),
        code="drive-time",
    )
