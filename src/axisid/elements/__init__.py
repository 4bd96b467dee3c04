"""Friction, loads and drives: what an axis is put together from.

In: a parameter and its coordinate. Out: an expression in `tau = inertia * ddq + resistances`; a
`Drive` makes `tau` of a control. Knows nothing of the axis that they become part of.
"""

from axisid.modeling.declaration import DRIVE_GAIN as DRIVE_GAIN
from axisid.modeling.declaration import Drive as Drive
from axisid.modeling.declaration import asymmetric_coulomb as asymmetric_coulomb
from axisid.modeling.declaration import asymmetric_viscous as asymmetric_viscous
from axisid.modeling.declaration import back_emf as back_emf
from axisid.modeling.declaration import cogging as cogging
from axisid.modeling.declaration import coulomb as coulomb
from axisid.modeling.declaration import cubic_spring as cubic_spring
from axisid.modeling.declaration import dahl as dahl
from axisid.modeling.declaration import end_stop as end_stop
from axisid.modeling.declaration import gravity as gravity
from axisid.modeling.declaration import gravity_moment as gravity_moment
from axisid.modeling.declaration import load_dependent as load_dependent
from axisid.modeling.declaration import lugre as lugre
from axisid.modeling.declaration import maxwell_slip as maxwell_slip
from axisid.modeling.declaration import motor_inertia as motor_inertia
from axisid.modeling.declaration import offset as offset
from axisid.modeling.declaration import periodic_coulomb as periodic_coulomb
from axisid.modeling.declaration import quadratic as quadratic
from axisid.modeling.declaration import spring as spring
from axisid.modeling.declaration import stribeck as stribeck
from axisid.modeling.declaration import viscous as viscous
from axisid.modeling.drives import current_drive as current_drive
from axisid.modeling.drives import formula_drive as formula_drive
from axisid.modeling.drives import voltage_drive as voltage_drive
from axisid.modeling.quantities import CONTROL as CONTROL
from axisid.modeling.quantities import DIRECTION as DIRECTION
from axisid.modeling.quantities import FORCE as FORCE
from axisid.modeling.quantities import POSITION as POSITION
from axisid.modeling.quantities import TIME as TIME
from axisid.modeling.quantities import VELOCITY as VELOCITY
from axisid.modeling.quantities import G as G
from axisid.modeling.quantities import State as State
