"""Algebra in bounded work: values at points, derivatives with kinks, row echelons, zero tests.

In: expressions. Out: expressions, or the reason why that would take too long.
Knows nothing of axes.
"""

from .coefficients import Coefficients as Coefficients
from .continuity import jumping_node as jumping_node
from .derivative import plain_slope as plain_slope, slope as slope
from .echelon import (
    NotRealError as NotRealError,
    Row as Row,
    reduced_functions as reduced_functions,
    reduced_rows as reduced_rows,
)
from .exponential import joined_exponential as joined_exponential
from .independence import (
    exact as exact,
    intercept as intercept,
    where_zero as where_zero,
    without as without,
)
from .multiplied_out import multiplied_out as multiplied_out
from .point_value import (
    CANNOT as CANNOT,
    float_at as float_at,
    value_at as value_at,
    vanishes as vanishes,
)
