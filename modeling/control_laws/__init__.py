"""Ready control laws, and the filters and limits that laws are made of.

In: gains in SI, a period. Out: `ControlLaw`, `Block`.
Knows nothing of axes and of text.
"""

from .blocks import (
    Block as Block,
    difference as difference,
    low_pass as low_pass,
    notch as notch,
    pll_velocity as pll_velocity,
    rate_limit as rate_limit,
    reference_acceleration as reference_acceleration,
    reference_velocity as reference_velocity,
)
from .cascades import (
    cascade_p_pi as cascade_p_pi,
    cascade_pd as cascade_pd,
    cascade_pd_averaged as cascade_pd_averaged,
    cascade_pd_difference as cascade_pd_difference,
    velocity_variants as velocity_variants,
)
from .parts import ANTI_WINDUP as ANTI_WINDUP, integral as integral
from .ready import BLOCKS as BLOCKS, LAWS as LAWS
from .single_loops import (
    dynamixel_position as dynamixel_position,
    impedance as impedance,
    pid as pid,
    pid_ideal as pid_ideal,
    state_feedback as state_feedback,
)
