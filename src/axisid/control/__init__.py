"""Control laws: those that ship, and what a law of one's own is written with.

In: gains, a period and the signals that a law reads. Out: `ControlLaw`.
Knows nothing of the axis that it moves.
"""

from axisid.modeling.declaration import ControlLaw as ControlLaw
from axisid.modeling.declaration import Memory as Memory
from axisid.modeling.declaration import gain as gain
from axisid.modeling.laws import Block as Block
from axisid.modeling.laws import cascade_p_pi as cascade_p_pi
from axisid.modeling.laws import cascade_pd as cascade_pd
from axisid.modeling.laws import cascade_pd_averaged as cascade_pd_averaged
from axisid.modeling.laws import cascade_pd_difference as cascade_pd_difference
from axisid.modeling.laws import difference as difference
from axisid.modeling.laws import dynamixel_position as dynamixel_position
from axisid.modeling.laws import impedance as impedance
from axisid.modeling.laws import integral as integral
from axisid.modeling.laws import low_pass as low_pass
from axisid.modeling.laws import notch as notch
from axisid.modeling.laws import pid as pid
from axisid.modeling.laws import pid_ideal as pid_ideal
from axisid.modeling.laws import pll_velocity as pll_velocity
from axisid.modeling.laws import rate_limit as rate_limit
from axisid.modeling.laws import reference_acceleration as reference_acceleration
from axisid.modeling.laws import reference_velocity as reference_velocity
from axisid.modeling.laws import state_feedback as state_feedback
from axisid.modeling.quantities import BALANCED as BALANCED
from axisid.modeling.quantities import LIMITED_OUTPUT as LIMITED_OUTPUT
from axisid.modeling.quantities import MEASURED_POSITION as MEASURED_POSITION
from axisid.modeling.quantities import MEASURED_VELOCITY as MEASURED_VELOCITY
from axisid.modeling.quantities import PERIOD as PERIOD
from axisid.modeling.quantities import REFERENCE as REFERENCE
