"""Gains of the control law that each lane of a batch has for itself."""

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.native import Native
from axisid.support.arrays import Array
from axisid.support.errors import UsageError
from axisid.support.real_numbers import real_array


class LoopCode(Protocol):
    """What a time loop is run by."""

    @property
    def functions(self) -> Mapping[str, Any]:
        """CasADi's, by name."""

    @property
    def native(self) -> Native:
        """The same, compiled."""


def run_code(axis: GeneratedAxis, *, by_lane: bool) -> LoopCode:
    """The code of an axis, or that which takes gains behind the parameters."""
    return axis.loop if by_lane and axis.loop is not None else axis


def gains_by_lane(
    axis: GeneratedAxis, gains: Mapping[str, ArrayLike] | None, lanes: int
) -> Array | None:
    """All gains of the law for each lane, (B, g); None where no lane has another.

    Raises
    ------
    ModelError
        The axis has no law whose gains could change, or not that gain.
    UsageError
        There are not as many values as lanes, or they are not finite.
    """
    if not gains:
        return None
    _, law = axis.loop_with(gains)
    found, names = np.tile([*law.gains.values()], (lanes, 1)), [*law.gains]
    for name, given in gains.items():
        values = real_array(given, f"the gain {name}")
        if values.shape not in ((), (lanes,)) or not np.all(np.isfinite(values)):
            raise UsageError(
                f"the gain {name} has the shape {values.shape}; give a number, or one for each of "
                f"{lanes} lanes, all finite.",
                code="batch-gains",
            )
        found[:, names.index(name)] = values
    return found


def axes_by_gains(axis: GeneratedAxis, gains: Array | None, lanes: int) -> list[GeneratedAxis]:
    """The axis of each lane, with its gains, (B, g); lanes with the same gains share one."""
    if gains is None or axis.axis.control is None:
        return [axis] * lanes
    names, made = [*axis.axis.control.gains], dict[tuple[float, ...], GeneratedAxis]()
    for own in map(tuple, gains.tolist()):
        if own not in made:
            made[own] = axis.with_gains(dict(zip(names, own, strict=True)))
    return [made[own] for own in map(tuple, gains.tolist())]
