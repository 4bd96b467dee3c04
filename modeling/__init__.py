"""Declare an axis and derive its models. SymPy only: no numerics.

The dynamics are SI and on the load side: ``tau = IDM(q, dq, ddq) theta + known`` and, for constant
inertia, ``ddq = DDM(tau, q, dq) theta_ddm + known``.
"""

from .axis import ROLES as ROLES
from .axis import Axis as Axis
from .control import MEASURED_POSITION as MEASURED_POSITION
from .control import MEASURED_VELOCITY as MEASURED_VELOCITY
from .control import PERIOD as PERIOD
from .control import REFERENCE as REFERENCE
from .control import ControlLaw as ControlLaw
from .control import Memory as Memory
from .control import cascade_pd as cascade_pd
from .control import cascade_pd_averaged as cascade_pd_averaged
from .control import gain as gain
from .direct import DirectRegressor as DirectRegressor
from .drive import Drive as Drive
from .elements import coulomb as coulomb
from .elements import offset as offset
from .elements import spring as spring
from .elements import viscous as viscous
from .equations import Formula as Formula
from .equations import Section as Section
from .equations import derived_sections as derived_sections
from .errors import AxisidError as AxisidError
from .errors import DeclarationError as DeclarationError
from .errors import ModelError as ModelError
from .errors import UsageError as UsageError
from .experiment import Experiment as Experiment
from .experiment import Move as Move
from .experiment import back_and_forth as back_and_forth
from .identifiability import describe_combinations as describe_combinations
from .identifiability import describe_direction as describe_direction
from .ladder import friction_ladder as friction_ladder
from .lagrange import lagrange as lagrange
from .library import LIBRARY as LIBRARY
from .loading import load_axis as load_axis
from .model import AxisModel as AxisModel
from .model import derive as derive
from .names import check_name as check_name
from .newton import newton as newton
from .parameter_function import FunctionLike as FunctionLike
from .parameter_function import parameter_function as parameter_function
from .parameter_map import ParameterMap as ParameterMap
from .symbols import DIRECTION as DIRECTION
from .symbols import FORCE as FORCE
from .symbols import Coordinate as Coordinate
from .symbols import Parameter as Parameter
from .symbols import Symbolic as Symbolic
from .units import Unit as Unit
from .units import parse_unit as parse_unit
