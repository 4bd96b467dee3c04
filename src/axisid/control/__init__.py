"""Control laws: those that ship, and what a law of one's own is written with.

In: gains, a period and the signals that a law reads. Out: `ControlLaw`.
Knows nothing of the axis that it moves.
"""

from axisid.modeling.declaration import ControlLaw as ControlLaw
from axisid.modeling.declaration import Memory as Memory
from axisid.modeling.declaration import cascade_pd as cascade_pd
from axisid.modeling.declaration import cascade_pd_averaged as cascade_pd_averaged
from axisid.modeling.declaration import cascade_pd_difference as cascade_pd_difference
from axisid.modeling.declaration import gain as gain
from axisid.modeling.quantities import BALANCED as BALANCED
from axisid.modeling.quantities import MEASURED_POSITION as MEASURED_POSITION
from axisid.modeling.quantities import MEASURED_VELOCITY as MEASURED_VELOCITY
from axisid.modeling.quantities import PERIOD as PERIOD
from axisid.modeling.quantities import REFERENCE as REFERENCE
