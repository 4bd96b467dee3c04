"""Algebra in bounded work: values at points, derivatives with kinks, row echelons, zero tests.

In: expressions. Out: expressions, or the reason why that would take too long.
Knows nothing of axes.
"""

from .coefficients import (
    Coefficients as Coefficients,
    Exponents as Exponents,
    NotRealError as NotRealError,
    Row as Row,
    reduced_functions as reduced_functions,
    reduced_rows as reduced_rows,
)
from .derivative import jumping_node as jumping_node, plain_slope as plain_slope, slope as slope
from .forms import (
    intercept as intercept,
    joined_exponential as joined_exponential,
    multiplied_out as multiplied_out,
    where as where,
    without as without,
)
from .point_value import (
    CANNOT as CANNOT,
    float_at as float_at,
    value_at as value_at,
    vanishes as vanishes,
)
