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

    `name` is ``lag`` or ``delay``. The loop of the axis is compiled again: this takes less time
    than a search that simulates a loop that is not compiled.
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
        There are several records, or the recorded signals cannot show the lag or delay; see
        `check_drive_time`.
    EstimationError
        The record does not show the lag or delay, or the force acts before its command.
    """
    declared = axis.declared
    name, parameter = declared.drive.estimated or ("lag", Parameter("lag", "s"))
    if len(records) > 1:
        raise UsageError(
            f"axis {declared.name!r}: the drive's {name} can be estimated from one record only, "
            f"but {len(records)} records are given. Estimate the {name} from one record, and "
            "declare it as a number for all records.",
            code="drive-time",
        )
    # Estimates with the lag or delay that aligns force and motion.
    value, deviation = _aligning_time(axis, records[0], name, run)
    result = run(with_drive_time(axis, name, value), methods)
    # The same estimates, with the same parameters at their bounds, for a longer lag or delay.
    bounds = {each.name: each.bound for each in result.problem.held}
    longer = run(with_drive_time(axis, name, value + deviation), [*result.estimates], bounds)
    estimates = {
        method: _with_uncertain_time(result.estimates[method], each)
        for method, each in longer.estimates.items()
    }
    reported = result.preferred
    dof = float(len(reported.y) - len(reported.theta))
    low, high = student_interval(value, deviation, dof)
    return replace(
        result,
        estimates=estimates,
        failed={**result.failed, **longer.failed},
        drive_time=DriveTime(
            name=name,
            parameter=parameter,
            value=value,
            deviation=deviation,
            interval=(max(low, 0.0), high),
        ),
    )


def _aligning_time(
    axis: GeneratedAxis, record: Record, name: str, run: Identify
) -> tuple[float, float]:
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
            why = "the record does not show the delay between force and motion"
            if isinstance(alignment, Missing):
                why = alignment.reason
            raise EstimationError(
                f"axis {declared.name!r}: the drive's {name} cannot be estimated: "
                f"{why.rstrip('.')}. Declare the {name} as a number.",
                code="drive-time",
            )
        # The remaining delay is the one that aligns the signals, minus the delay of the hold.
        step = (alignment.best - result.data.hold_delay) * period
        deviation = alignment.deviation * period
        # A step is negligible below a twentieth of its standard error, or below rounding.
        tolerance = max(0.05 * deviation, 1e-9 * period)
        if abs(step) < tolerance or (value == 0 and step <= 0):
            break
        value = max(value + step, 0.0)
    else:
        raise EstimationError(
            f"axis {declared.name!r}: the estimate of the drive's {name} does not converge. The "
            f"last estimate is {value:.3g} s. Check the control law and the model.",
            code="no-convergence",
        )
    if step < -2 * deviation:
        raise EstimationError(
            f"axis {declared.name!r}: the force acts {-step:.3g} s before its command, so there is "
            f"no {name} to estimate. Check whether the control is logged late, and check the hold "
            "of the control.",
            code="drive-time",
        )
    return value, deviation


def _with_uncertain_time(estimate: Estimate, longer: Estimate) -> Estimate:
    """Return an estimate whose covariances include the uncertainty of the lag or delay.

    `longer` is the same estimate with a lag or delay that is longer by its standard error. The
    outer product ``d d'`` of the change d of the parameters is added to every covariance.
    """
    change = longer.physical - estimate.physical
    ddm_change = longer.theta_ddm - estimate.theta_ddm
    return estimate.with_inference(
        covariances={
            name: each + change[:, None] * change for name, each in estimate.covariances.items()
        },
        ddm_covariances={
            name: each + ddm_change[:, None] * ddm_change
            for name, each in estimate.ddm_covariances.items()
        },
    )


def check_drive_time(declared: Axis, record: Record, name: str, *, by_law: bool = True) -> None:
    """Refuse a lag or delay that a record cannot show.

    Parameters
    ----------
    declared : Axis
    record : Record
    name : {"lag", "delay"}
    by_law : bool
        True if the lag or delay is found by simulating the declared control law, which must then be
        a sampled law.

    Raises
    ------
    UsageError
        The control was recorded after the lag or delay, the force was measured instead of the
        control, or there is no sampled law to simulate.
    """
    law = declared.control
    lacks_law = by_law and (law is None or law.continuous)
    law_text = " of a sampled law" if by_law else ""
    refuse(
        UsageError,
        (
            lacks_law or record.force is not None or record.control is None,
            f"axis {declared.name!r}: the drive's {name} can be estimated only from a recorded "
            f"control{law_text}, not from a measured force. Declare the {name} as a number",
        ),
        (
            declared.drive.logged in HIDDEN_FROM[name],
            f"axis {declared.name!r}: the control was recorded after the drive's {name} "
            f"(logged={declared.drive.logged!r}), so the record does not show the {name}. Declare "
            f"the {name} as a number",
        ),
        code="drive-time",
    )
