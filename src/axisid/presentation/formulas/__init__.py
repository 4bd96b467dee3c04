"""Expressions and numbers as they are printed.

In: expressions, values. Out: LaTeX, MathML, typeset text. Knows nothing of estimators.
"""

from .axis_page import axis_document as axis_document
from .axis_page import axis_page as axis_page
from .latex import symbol_latex as symbol_latex
from .latex import unit_latex as unit_latex
from .mathml import formula_mathml as formula_mathml
from .numbers import decimals as decimals
from .numbers import figure_text as figure_text
from .numbers import power_of_ten as power_of_ten
from .numbers import readable_text as readable_text
from .numbers import readable_unit as readable_unit
from .numbers import significant as significant
from .numbers import true_minus as true_minus
