"""Ready control laws, and the filters and limits that laws are made of.

In: gains in SI, a period. Out: `ControlLaw`, `Block`.
Knows nothing of axes and of text.
"""

from .blocks import Block as Block
from .blocks import difference as difference
from .blocks import low_pass as low_pass
from .blocks import notch as notch
from .blocks import pll_velocity as pll_velocity
from .blocks import rate_limit as rate_limit
from .blocks import reference_acceleration as reference_acceleration
from .blocks import reference_velocity as reference_velocity
from .cascade_p_pi import cascade_p_pi as cascade_p_pi
from .cascade_pd import cascade_pd as cascade_pd
from .cascade_pd import cascade_pd_averaged as cascade_pd_averaged
from .cascade_pd import cascade_pd_difference as cascade_pd_difference
from .cascade_pd import velocity_variants as velocity_variants
from .dynamixel import dynamixel_position as dynamixel_position
from .impedance import impedance as impedance
from .pid import pid as pid
from .pid import pid_ideal as pid_ideal
from .ready import BLOCKS as BLOCKS
from .ready import LAWS as LAWS
from .state_feedback import state_feedback as state_feedback
from .windup import ANTI_WINDUP as ANTI_WINDUP
from .windup import integral as integral
