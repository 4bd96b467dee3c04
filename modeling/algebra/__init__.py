"""Exact algebra in bounded work: expansions, derivatives with kinks, null spaces, zero tests.

In: expressions. Out: expressions, or the reason why that would take too long.
Knows nothing of axes.
"""

from .coefficients import Coefficients as Coefficients
from .constant_value import NotRealError as NotRealError
from .constant_value import value_of as value_of
from .continuity import jumping_node as jumping_node
from .derivative import slope as slope
from .expansion import EULER as EULER
from .expansion import Expansion as Expansion
from .exponential import joined_exponential as joined_exponential
from .independence import exact as exact
from .independence import intercept as intercept
from .independence import where_zero as where_zero
from .independence import without as without
from .kernel import Polynomial as Polynomial
from .kernel import TooManyProductsError as TooManyProductsError
from .kernel import kernel as kernel
from .multiplied_out import multiplied_out as multiplied_out
from .point_value import CANNOT as CANNOT
from .point_value import value_at as value_at
from .point_value import vanishes as vanishes
from .products import Algebra as Algebra
from .products import Number as Number
from .products import Product as Product
from .products import Sum as Sum
from .products import TooLargeError as TooLargeError
from .products import modulus_of as modulus_of
