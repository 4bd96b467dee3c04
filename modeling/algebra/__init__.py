"""Exact algebra in bounded work: expansions, derivatives with kinks, null spaces, zero tests.

In: expressions. Out: expressions, or the reason why that would take too long.
Knows nothing of axes.
"""

from .coefficients import Coefficients as Coefficients
from .constant_value import NotRealError as NotRealError, value_of as value_of
from .continuity import jumping_node as jumping_node
from .derivative import slope as slope
from .expansion import EULER as EULER, Expansion as Expansion
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
from .products import (
    Algebra as Algebra,
    Number as Number,
    Product as Product,
    Sum as Sum,
    TooLargeError as TooLargeError,
    modulus_of as modulus_of,
)
