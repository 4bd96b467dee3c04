"""Algebra in bounded work: polynomials of parameters, derivatives with kinks, zero tests.

In: expressions. Out: expressions, or the reason why that would take too long.
Knows nothing of axes.
"""

from .coefficients import Coefficients as Coefficients
from .continuity import jumping_node as jumping_node
from .derivative import slope as slope
from .exponential import joined_exponential as joined_exponential
from .independence import (
    MOST_ROOTS as MOST_ROOTS,
    exact as exact,
    intercept as intercept,
    where_zero as where_zero,
    without as without,
)
from .kernel import (
    Polynomial as Polynomial,
    TooManyProductsError as TooManyProductsError,
    kernel as kernel,
)
from .multiplied_out import multiplied_out as multiplied_out
from .point_value import (
    CANNOT as CANNOT,
    numbers as numbers,
    value_at as value_at,
    values_at as values_at,
    vanishes as vanishes,
)
