"""Symbols, units, names, constants, their text forms, and calculations with expressions.

In: names, units, expressions. Out: checked names, units and expressions, and their text; values at
points, derivatives with kinks, row echelon forms and zero tests with bounded effort, or an error if
these would take too long. Knows nothing of axes.
"""

from .coefficients import (
    Coefficients as Coefficients,
    Exponents as Exponents,
)
from .constants import (
    Constant as Constant,
    ConstantSymbol as ConstantSymbol,
    G as G,
    Signal as Signal,
    SignalSymbol as SignalSymbol,
    extreme as extreme,
    positive as positive,
    replaced as replaced,
    signals_in as signals_in,
    with_numbers as with_numbers,
    with_unit as with_unit,
    within as within,
)
from .covering_points import CoveringPoints as CoveringPoints
from .dependences import (
    NotRealError as NotRealError,
    Reduced as Reduced,
    Row as Row,
    reduced_functions as reduced_functions,
    reduced_rows as reduced_rows,
    unmerged as unmerged,
    vanishes as vanishes,
)
from .derivative import jumping_node as jumping_node, plain_slope as plain_slope, slope as slope
from .expression_rewriting import (
    intercept as intercept,
    joined_exponential as joined_exponential,
    multiplied_out as multiplied_out,
    where as where,
    without as without,
)
from .expression_units import NUMBER as NUMBER, UnitReader as UnitReader, UnitsError as UnitsError
from .names import (
    check_distinct as check_distinct,
    check_name as check_name,
    check_symbol as check_symbol,
    fresh_name as fresh_name,
    number as number,
    rounded as rounded,
    settle as settle,
)
from .point_value import (
    CANNOT as CANNOT,
    DrawnPoint as DrawnPoint,
    Points as Points,
    float_at as float_at,
    value_at as value_at,
)
from .reading_order import (
    Formula as Formula,
    InReadingOrder as InReadingOrder,
    readable as readable,
    written as written,
)
from .state import (
    State as State,
    StatePart as StatePart,
    StateSymbol as StateSymbol,
    at_start as at_start,
    replaced_in as replaced_in,
    states_in as states_in,
    with_own_symbols as with_own_symbols,
)
from .symbols import (
    BALANCED as BALANCED,
    CONTROL as CONTROL,
    DIRECTION as DIRECTION,
    FORCE as FORCE,
    LIMITED_OUTPUT as LIMITED_OUTPUT,
    MEASURED_POSITION as MEASURED_POSITION,
    MEASURED_VELOCITY as MEASURED_VELOCITY,
    MOST_NODES as MOST_NODES,
    PERIOD as PERIOD,
    POSITION as POSITION,
    REFERENCE as REFERENCE,
    TIME as TIME,
    UNLIMITED_OUTPUT as UNLIMITED_OUTPUT,
    VELOCITY as VELOCITY,
    Amount as Amount,
    Coordinate as Coordinate,
    Parameter as Parameter,
    Symbolic as Symbolic,
    check_coordinate as check_coordinate,
    check_size as check_size,
    expression as expression,
    listed as listed,
)
from .units import (
    Unit as Unit,
    angle_power as angle_power,
    parse_unit as parse_unit,
    product_of_powers as product_of_powers,
)
