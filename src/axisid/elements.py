"""Friction, loads and drives: the elements of an axis.

In: a parameter and a coordinate. Out: an expression in `tau = inertia * ddq + resistances`, or a
`Drive`, which gives `tau` for a control. Knows nothing of the axis that the elements belong to.
"""

from axisid.modeling.declaration import (
    DRIVE_GAIN as DRIVE_GAIN,
    Drive as Drive,
    asymmetric_coulomb as asymmetric_coulomb,
    asymmetric_viscous as asymmetric_viscous,
    back_emf as back_emf,
    cogging as cogging,
    coulomb as coulomb,
    cubic_spring as cubic_spring,
    current_drive as current_drive,
    dahl as dahl,
    end_stop as end_stop,
    formula_drive as formula_drive,
    gravity as gravity,
    gravity_moment as gravity_moment,
    load_dependent as load_dependent,
    lugre as lugre,
    maxwell_slip as maxwell_slip,
    motor_inertia as motor_inertia,
    offset as offset,
    periodic_coulomb as periodic_coulomb,
    quadratic as quadratic,
    spring as spring,
    stribeck as stribeck,
    viscous as viscous,
    voltage_drive as voltage_drive,
)
from axisid.modeling.quantities import (
    CONTROL as CONTROL,
    DIRECTION as DIRECTION,
    FORCE as FORCE,
    POSITION as POSITION,
    TIME as TIME,
    VELOCITY as VELOCITY,
    G as G,
    State as State,
)
