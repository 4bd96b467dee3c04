"""Declare an axis, checked once, from ready-made or own parts.

In: elements, laws, drives, energies. Out: `Axis`; ready drives and control laws, and the filters
and limits that laws are made of. Knows nothing of derived models and of text files.
"""

from .axis import (
    INJECTION_POINTS as INJECTION_POINTS,
    ROLES as ROLES,
    Axis as Axis,
    check_axis as check_axis,
    equation_of_motion as equation_of_motion,
)
from .column import Column as Column, column_texts as column_texts
from .command_path import HIDDEN_FROM as HIDDEN_FROM, CommandPath as CommandPath
from .control import ControlLaw as ControlLaw, Memory as Memory, gain as gain, no_law as no_law
from .control_blocks import (
    BLOCKS as BLOCKS,
    Block as Block,
    difference as difference,
    low_pass as low_pass,
    notch as notch,
    pll_velocity as pll_velocity,
    rate_limit as rate_limit,
    reference_acceleration as reference_acceleration,
    reference_velocity as reference_velocity,
)
from .drive import (
    DRIVE_GAIN as DRIVE_GAIN,
    FORCE_TARGET as FORCE_TARGET,
    Drive as Drive,
    Response as Response,
)
from .elements import (
    ELEMENTS as ELEMENTS,
    asymmetric_coulomb as asymmetric_coulomb,
    asymmetric_viscous as asymmetric_viscous,
    back_emf as back_emf,
    cogging as cogging,
    coulomb as coulomb,
    cubic_spring as cubic_spring,
    dahl as dahl,
    end_stop as end_stop,
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
)
from .equations import lagrange as lagrange, newton as newton
from .experiment import Experiment as Experiment, Move as Move, back_and_forth as back_and_forth
from .ready_drives import (
    DRIVES as DRIVES,
    current_drive as current_drive,
    formula_drive as formula_drive,
    voltage_drive as voltage_drive,
)
from .ready_laws import (
    LAWS as LAWS,
    cascade_p_pi as cascade_p_pi,
    cascade_pd as cascade_pd,
    cascade_pd_averaged as cascade_pd_averaged,
    cascade_pd_difference as cascade_pd_difference,
    velocity_variants as velocity_variants,
)
from .single_loops import (
    dynamixel_position as dynamixel_position,
    impedance as impedance,
    pid as pid,
    pid_ideal as pid_ideal,
    state_feedback as state_feedback,
)
from .unit_check import check_unit as check_unit, unit_table as unit_table
from .variants import (
    fix as fix,
    known_text as known_text,
    leave_out as leave_out,
    left_out_text as left_out_text,
    read_fixed as read_fixed,
)
from .velocity_and_anti_windup import ANTI_WINDUP as ANTI_WINDUP, integral as integral
