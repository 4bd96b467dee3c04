"""Axes and formulas as text.

In: TOML, formulas, names of files. Out: `Axis`, expressions; nothing of it is run.
Knows nothing of models and of code.
"""

from .loading import load_axis as load_axis
from .parameter_function import (
    FunctionLike as FunctionLike,
    parameter_function as parameter_function,
)
