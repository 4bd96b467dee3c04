"""Formulas as MathML, which browsers typeset by themselves."""

import re
from xml.dom.minidom import Element

import sympy
from sympy.printing.mathml import MathMLPresentationPrinter

from axisid.formulas import name_parts, with_named_steps
from axisid.modeling import Coordinate, Formula

_DOTS = ("", "˙", "¨")
_TIMES, _SPACE = "<mo>&InvisibleTimes;</mo>", '<mspace width="0.2em"/>'
_GREEK = dict(
    zip(
        "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau "
        "upsilon phi chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi "
        "Omega".split(),
        "αβγδεζηθικλμνξπρστυφχψωΓΔΘΛΞΠΣΥΦΨΩ",
        strict=True,
    )
)


def formula_mathml(formula: Formula, coordinate: Coordinate) -> str:
    """``name = value`` as a ``math`` element; velocity and acceleration wear dots.

    Parameters
    ----------
    formula : Formula
        With a value.
    coordinate : Coordinate
    """
    printer = _Printer(coordinate)
    name = formula.name if isinstance(formula.name, sympy.Expr) else sympy.Symbol(formula.name)
    row = printer.dom.createElement("mrow")
    row.appendChild(printer._print(name))
    row.appendChild(printer.leaf("mo", "="))
    row.appendChild(printer._print(with_named_steps(formula.value)))
    # The printer names signs that every reader of HTML knows; a product gets a little space.
    text = re.sub(r"&amp;(?=[A-Za-z]+;)", "&", row.toxml())
    text = text.replace(_TIMES, _SPACE).replace("<mo>-</mo>", "<mo>\u2212</mo>")
    return f'<math display="block">{text}</math>'


class _Printer(MathMLPresentationPrinter):  # type: ignore[misc]
    """SymPy's printer with this house's names: ``Fv`` is one symbol, ``dq`` a dotted ``q``."""

    def __init__(self, coordinate: Coordinate) -> None:
        super().__init__()
        q = coordinate
        self._motion = {q.symbol: 0, q.velocity: 1, q.acceleration: 2}
        self._coordinate = q.name

    def leaf(self, kind: str, text: str) -> Element:
        """Make an element with a text."""
        made: Element = self.dom.createElement(kind)
        made.appendChild(self.dom.createTextNode(text))
        return made

    def _print_Symbol(self, symbol: sympy.Symbol, style: str = "plain") -> Element:  # noqa: ARG002, N802
        dots = self._motion.get(symbol)
        if dots is None:
            return self._named(str(symbol))
        base = self._named(self._coordinate)
        if not dots:
            return base
        over: Element = self.dom.createElement("mover")
        over.appendChild(base)
        over.appendChild(self.leaf("mo", _DOTS[dots]))
        return over

    def _named(self, name: str) -> Element:
        head, indices = name_parts(name)
        base = self.leaf("mi", _GREEK.get(head, head))
        if len(head) > 1 and head not in _GREEK:
            base.setAttribute("class", "long")
        if not indices:
            return base
        sub: Element = self.dom.createElement("msub")
        sub.appendChild(base)
        sub.appendChild(self.leaf("mtext", ",".join(indices)))
        return sub
