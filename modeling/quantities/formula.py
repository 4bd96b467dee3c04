"""One formula: what is spoken of, what it equals, its unit and what multiplies it."""

from dataclasses import dataclass

import sympy

from .reading_order import written
from .symbols import Coordinate


@dataclass(frozen=True, slots=True, kw_only=True)
class Formula:
    """``name = value [unit]: column``; what is empty is left out.

    Attributes
    ----------
    name : sympy.Expr or str
        What is spoken of.
    value : sympy.Expr or None
        What it equals.
    unit : str
    column : sympy.Expr or None
        What multiplies it in a regressor.
    """

    name: sympy.Expr | str
    value: sympy.Expr | None = None
    unit: str = ""
    column: sympy.Expr | None = None

    def head(self, coordinate: Coordinate) -> str:
        """``name = value`` as text."""
        value = "" if self.value is None else f" = {written(self.value, coordinate)}"
        name = self.name if isinstance(self.name, str) else written(self.name, coordinate)
        return f"{name}{value}"

    def text(self, coordinate: Coordinate) -> str:
        """``name = value [unit]: column``."""
        unit = f" [{self.unit}]" if self.unit else ""
        column = "" if self.column is None else f": {written(self.column, coordinate)}"
        return f"{self.head(coordinate)}{unit}{column}"
