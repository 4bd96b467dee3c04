"""Which axes and records are identified side by side, and which lanes show their parameters."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.problems import Reach, shown_up_to
from axisid.estimation.records import is_same_period
from axisid.estimation.regression import InverseForm
from axisid.estimation.signals import Signals
from axisid.estimation.thresholds import MIN_DISTANCE_FROM_NOISE
from axisid.support.arrays import Array

from .block import Block, LaneRows
from .lanes import RecordLanes
from .regression import LaneSolutions, lagged_products, row_counts

#: The method of which lanes go side by side.
METHOD = "idm-iv"
_CLEARLY = 0.5  # of what a record may hide: lanes nearer to that are looked at alone
_ROUNDING = float(np.finfo(float).eps)


def is_served(
    axis: GeneratedAxis, lanes: RecordLanes, method: str, settings: Mapping[str, object]
) -> bool:
    """Whether lanes of an axis go side by side: the rest is identified one by one.

    That is instruments of a linear model whose drive acts at once, of a law that is evaluated at
    the samples, and of positions that no encoder rounds.
    """
    declared = axis.axis
    law, drive = declared.control, declared.drive
    return (
        method == METHOD
        and not settings
        and not lanes.resolution
        and axis.is_linear
        and not (axis.unidentifiable or declared.signals or declared.drives_by_motion)
        and axis.declared.drive.estimated is None
        and declared.response is None
        and drive.path.is_plain
        and not drive.logs_what_acts
        and law is not None
        and not law.continuous
        and is_same_period(lanes.period, law.period)
    )


def clearly_shown(
    block: Block, measured: LaneRows, rows: NDArray[np.bool_] | None, first: LaneSolutions
) -> NDArray[np.bool_]:
    """Which lanes show every parameter by far, (L,), from least squares of their rows.

    What a record may hide follows from its force and motion, which are those of the first lane in
    all but noise.
    """
    s, control = block.measured, block.lanes.control
    q, dq, ddq = (np.ascontiguousarray(each[:, 0]) for each in s.motion)
    (force,) = block.axis.evaluate("drive_force", np.ascontiguousarray(control[:, 0]), q, dq)
    signals = Signals(
        position=q, velocity=dq, acceleration=ddq, force=force[:, 0], direction=np.sign(dq)
    )
    reach = Reach.of(signals, InverseForm(block.axis).equations(signals), block.template.kept)
    if reach is None:
        return np.zeros(len(block.lanes), dtype=bool)
    most: Array = shown_up_to(block.axis, reach)
    norms = np.sqrt(lagged_products(block.library, measured.regressor, 0)[0].T)
    freedom = row_counts(rows, measured.left.shape) - norms.shape[1]
    with np.errstate(all="ignore"):
        noise = np.maximum(np.sqrt(first.power / freedom), _ROUNDING * reach.force)
        needed = MIN_DISTANCE_FROM_NOISE.value * noise[:, None] / norms
    return np.asarray((needed < _CLEARLY * most).all(axis=1) & (freedom > 0))
