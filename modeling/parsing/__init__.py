"""Read axes and formulas from text.

In: TOML, formulas, names of files. Out: `Axis`, expressions, tables. Only a Python file is run.
Knows nothing of derived models and of generated code.
"""

from .axis_files import load_axis as load_axis
from .grammar import nearest as nearest
from .parameter_function import (
    FunctionLike as FunctionLike,
    parameter_function as parameter_function,
)
from .toml_table import (
    TomlTable as TomlTable,
    read_columns as read_columns,
    read_toml as read_toml,
    toml_document as toml_document,
)
