"""Expressions and numbers as they are printed.

In: expressions, values. Out: LaTeX, MathML, typeset text. Knows nothing of estimators.
"""

from .axis_page import (
    axis_document as axis_document,
    axis_page as axis_page,
    motion_sections as motion_sections,
)
from .latex import (
    formula_mathml as formula_mathml,
    symbol_latex as symbol_latex,
    unit_latex as unit_latex,
)
from .numbers import (
    decimals as decimals,
    figure_text as figure_text,
    readable_text as readable_text,
    readable_unit as readable_unit,
)
