"""A force column beside a control: the two must belong together."""

import numpy as np

from axisid.codegen import GeneratedAxis

from .arrays import relative_error_percent
from .check import Check, passed
from .record import Record

_NAME = "force against control"
_MOST = 20.0  # percent


def force_checks(axis: GeneratedAxis, record: Record) -> tuple[Check, ...]:
    """The recorded force against the drive's gain times the control; nothing without both."""
    if record.force is None or record.control is None:
        return ()
    commanded = axis.axis.drive.gain * record.control
    apart = relative_error_percent(record.force - commanded, commanded)
    scale = float(commanded @ record.force / (commanded @ commanded))
    good = bool(apart <= _MOST)
    check = Check(
        name=_NAME,
        status=passed(good),
        figure=apart if np.isfinite(apart) else None,
        threshold=_MOST,
        source="difference in percent of gain times control; a measured force differs by what the "
        "drive's own loop leaves",
        meaning="the force column is what the drive's gain makes of the control"
        if good
        else f"the force column is {scale:.3g} times what the drive's gain makes of the control, "
        f"and {apart:.3g} % off it: check the column, its unit and timing, and the gain",
    )
    return (check,)
