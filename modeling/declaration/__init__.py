"""What a user says of an axis, checked once.

In: elements, laws, drives, energies. Out: `Axis`.
Knows nothing of the models that are derived from it.
"""

from .axis import INJECTION_POINTS as INJECTION_POINTS
from .axis import ROLES as ROLES
from .axis import Axis as Axis
from .axis import check_axis as check_axis
from .axis import equation_of_motion as equation_of_motion
from .column import Column as Column
from .column import column_texts as column_texts
from .command_path import HIDDEN_FROM as HIDDEN_FROM
from .command_path import CommandPath as CommandPath
from .control import ControlLaw as ControlLaw
from .control import Memory as Memory
from .control import gain as gain
from .drive import DRIVE_GAIN as DRIVE_GAIN
from .drive import FORCE_TARGET as FORCE_TARGET
from .drive import Drive as Drive
from .drive import Response as Response
from .elements import ELEMENTS as ELEMENTS
from .elements import asymmetric_coulomb as asymmetric_coulomb
from .elements import asymmetric_viscous as asymmetric_viscous
from .elements import back_emf as back_emf
from .elements import cogging as cogging
from .elements import coulomb as coulomb
from .elements import cubic_spring as cubic_spring
from .elements import dahl as dahl
from .elements import end_stop as end_stop
from .elements import gravity as gravity
from .elements import gravity_moment as gravity_moment
from .elements import load_dependent as load_dependent
from .elements import lugre as lugre
from .elements import maxwell_slip as maxwell_slip
from .elements import motor_inertia as motor_inertia
from .elements import offset as offset
from .elements import periodic_coulomb as periodic_coulomb
from .elements import quadratic as quadratic
from .elements import spring as spring
from .elements import stribeck as stribeck
from .elements import viscous as viscous
from .experiment import Experiment as Experiment
from .experiment import Move as Move
from .experiment import back_and_forth as back_and_forth
from .lagrange import lagrange as lagrange
from .newton import newton as newton
from .unit_check import unit_table as unit_table
from .variants import fix as fix
from .variants import known_text as known_text
from .variants import leave_out as leave_out
from .variants import left_out_text as left_out_text
from .variants import read_fixed as read_fixed
