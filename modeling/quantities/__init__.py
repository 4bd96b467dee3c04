"""Symbols, units, names and constants, and how they are written.

In: names, units, expressions. Out: the same, checked and readable.
Knows nothing of axes.
"""

from .constants import Constant as Constant
from .constants import ConstantSymbol as ConstantSymbol
from .constants import G as G
from .constants import named_constants as named_constants
from .constants import positive as positive
from .constants import with_numbers as with_numbers
from .constants import with_unit as with_unit
from .expression_units import NUMBER as NUMBER
from .expression_units import UnitReader as UnitReader
from .expression_units import UnitsError as UnitsError
from .formula import Formula as Formula
from .kinks import extreme as extreme
from .kinks import within as within
from .names import check_distinct as check_distinct
from .names import check_name as check_name
from .names import check_symbol as check_symbol
from .names import fresh_name as fresh_name
from .numbers import number as number
from .numbers import rounded as rounded
from .reading_order import InReadingOrder as InReadingOrder
from .reading_order import readable as readable
from .reading_order import written as written
from .signal import Signal as Signal
from .signal import SignalSymbol as SignalSymbol
from .signal import declared_signals as declared_signals
from .signal import signals_in as signals_in
from .size import MOST_NODES as MOST_NODES
from .size import check_size as check_size
from .state import State as State
from .state import StatePart as StatePart
from .state import StateSymbol as StateSymbol
from .state import at_start as at_start
from .state import replaced_in as replaced_in
from .state import states_in as states_in
from .state import with_own_symbols as with_own_symbols
from .symbols import BALANCED as BALANCED
from .symbols import CONTROL as CONTROL
from .symbols import DIRECTION as DIRECTION
from .symbols import FORCE as FORCE
from .symbols import LIMITED_OUTPUT as LIMITED_OUTPUT
from .symbols import MEASURED_POSITION as MEASURED_POSITION
from .symbols import MEASURED_VELOCITY as MEASURED_VELOCITY
from .symbols import PERIOD as PERIOD
from .symbols import POSITION as POSITION
from .symbols import REFERENCE as REFERENCE
from .symbols import TIME as TIME
from .symbols import VELOCITY as VELOCITY
from .symbols import Coordinate as Coordinate
from .symbols import Parameter as Parameter
from .symbols import Symbolic as Symbolic
from .symbols import check_coordinate as check_coordinate
from .symbols import declared_parameters as declared_parameters
from .symbols import expression as expression
from .symbols import several as several
from .units import Unit as Unit
from .units import angle_power as angle_power
from .units import parse_unit as parse_unit
