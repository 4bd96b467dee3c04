"""Formulas as MathML, which browsers typeset by themselves."""

import re
from collections.abc import Mapping
from typing import Any
from xml.dom.minidom import Element

import sympy
from sympy.printing.mathml import MathMLPresentationPrinter

from axisid.formulas import SIGNALS, name_parts, with_named_steps
from axisid.modeling import Coordinate, Formula, InReadingOrder, readable

_DOTS = ("", "˙", "¨")
_TIMES, _SPACE = "<mo>&InvisibleTimes;</mo>", '<mspace width="0.2em"/>'
_ROUND = re.compile(r"<mo>\(</mo>(<m(?:over|i)>(?:(?!<mo>\().)*?</m(?:over|i)>)<mo>\)</mo>")
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
    prepared = readable(with_named_steps(formula.value), coordinate)
    printer = _Printer(prepared, {}, coordinate)
    row = printer.dom.createElement("mrow")
    row.appendChild(_left(formula, printer, coordinate))
    row.appendChild(printer.leaf("mo", "="))
    row.appendChild(printer._print(prepared.value))
    # The printer names signs that every reader of HTML knows; a product gets a little space.
    text = re.sub(r"&amp;(?=[A-Za-z]+;)", "&", row.toxml())
    text = text.replace(_TIMES, _SPACE).replace("<mo>-</mo>", "<mo>\u2212</mo>")
    # Round brackets about one letter need not grow for its dot.
    text = _ROUND.sub(r'<mo stretchy="false">(</mo>\1<mo stretchy="false">)</mo>', text)
    return f'<math display="block">{text}</math>'


def _left(formula: Formula, printer: "_Printer", coordinate: Coordinate) -> Element:
    if isinstance(formula.name, str):
        return printer.leaf("mi", formula.name)
    prepared = readable(formula.name, coordinate)
    left: Element = _Printer(prepared, {}, coordinate)._print(prepared.value)
    return left


class _House(MathMLPresentationPrinter):  # type: ignore[misc]
    """SymPy's printer with this house's names: ``Fv`` is one symbol, ``dq`` a dotted ``q``."""

    def __init__(self, settings: Mapping[str, Any], coordinate: Coordinate) -> None:
        super().__init__(settings)
        q = coordinate
        self._motion = {q.symbol: 0, q.velocity: 1, q.acceleration: 2}
        self._coordinate = q.name

    def leaf(self, kind: str, text: str) -> Element:
        """Make an element with a text."""
        made: Element = self.dom.createElement(kind)
        made.appendChild(self.dom.createTextNode(text))
        return made

    def _print_Symbol(self, symbol: sympy.Symbol, style: str = "plain") -> Element:  # noqa: ARG002, N802
        if symbol in SIGNALS:
            return self.leaf("mi", SIGNALS[symbol])  # of a text, signs would keep no distance
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
        if not name.isidentifier():
            constant: Element = self._print_Float(sympy.Float(name))  # it has no name
            return constant
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


class _Printer(InReadingOrder, _House):
    pass
