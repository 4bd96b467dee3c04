"""The laws and blocks that ship, by the name of their function."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from .cascades import CASCADES, cascade_p_pi
from .control import ControlLaw
from .control_blocks import (
    Block,
    difference,
    low_pass,
    notch,
    pll_velocity,
    rate_limit,
    reference_acceleration,
    reference_velocity,
)
from .single_loops import dynamixel_position, impedance, pid, pid_ideal, state_feedback

#: The laws that ship, as TOML declarations know them.
LAWS: Mapping[str, Callable[..., ControlLaw]] = MappingProxyType(
    {
        **CASCADES,
        **{
            law.__name__: law
            for law in (
                cascade_p_pi,
                pid,
                pid_ideal,
                impedance,
                state_feedback,
                dynamixel_position,
            )
        },
    }
)

#: The blocks that ship.
BLOCKS: Mapping[str, Callable[..., Block]] = MappingProxyType(
    {
        block.__name__: block
        for block in (
            difference,
            low_pass,
            notch,
            pll_velocity,
            rate_limit,
            reference_velocity,
            reference_acceleration,
        )
    }
)
