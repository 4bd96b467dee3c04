"""Control laws: the built-in laws, and the parts of a user's own law.

In: gains, a period and the signals that a law reads. Out: `ControlLaw`.
Knows nothing of the axis that is controlled.
"""

from axisid.modeling.declaration import (
    Block as Block,
    ControlLaw as ControlLaw,
    Memory as Memory,
    cascade_p_pi as cascade_p_pi,
    cascade_pd as cascade_pd,
    cascade_pd_averaged as cascade_pd_averaged,
    cascade_pd_difference as cascade_pd_difference,
    difference as difference,
    dynamixel_position as dynamixel_position,
    gain as gain,
    impedance as impedance,
    integral as integral,
    low_pass as low_pass,
    notch as notch,
    pid as pid,
    pid_ideal as pid_ideal,
    pll_velocity as pll_velocity,
    rate_limit as rate_limit,
    reference_acceleration as reference_acceleration,
    reference_velocity as reference_velocity,
    state_feedback as state_feedback,
)
from axisid.modeling.quantities import (
    BALANCED as BALANCED,
    LIMITED_OUTPUT as LIMITED_OUTPUT,
    MEASURED_POSITION as MEASURED_POSITION,
    MEASURED_VELOCITY as MEASURED_VELOCITY,
    PERIOD as PERIOD,
    REFERENCE as REFERENCE,
    UNLIMITED_OUTPUT as UNLIMITED_OUTPUT,
)
