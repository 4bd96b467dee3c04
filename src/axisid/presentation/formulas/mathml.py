"""Formulas as MathML, which browsers typeset by themselves."""

import re
from collections.abc import Mapping
from typing import Any, TypeAlias
from xml.dom.minidom import Element

import sympy
from sympy.printing.mathml import MathMLPresentationPrinter

from axisid.modeling.quantities import Coordinate, Formula, InReadingOrder, readable

from .latex import SIGNALS, name_parts, with_named_steps

Piece: TypeAlias = list[Element]

_DOTS = ("", "˙", "¨")
_TIMES, _SPACE = "<mo>&InvisibleTimes;</mo>", '<mspace width="0.2em"/>'
_ROUND = re.compile(r"<mo>\(</mo>(<m(?:over|i)>(?:(?!<mo>\().)*?</m(?:over|i)>)<mo>\)</mo>")
_LONG = 40  # signs from which a term may break between its factors
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
    """``name = value``, a ``math`` element for each term, between which a line may break.

    Parameters
    ----------
    formula : Formula
        With a value.
    coordinate : Coordinate
        Its velocity and acceleration wear dots.
    """
    prepared = readable(with_named_steps(formula.value), coordinate)
    printer = _Printer(prepared, {}, coordinate)
    head = [_left(formula, printer, coordinate), printer.leaf("mo", "=")]
    pieces = [head, *_sum(prepared.value, printer)]
    return f'<div class="formula">{" ".join(_math(piece, printer) for piece in pieces)}</div>'


def _sum(value: sympy.Expr, printer: "_Printer") -> list[Piece]:
    """The terms of a sum, each with its sign."""
    pieces: list[Piece] = []
    for term in printer.prepared.terms(value) if value.is_Add else [value]:
        negative = term.could_extract_minus_sign()
        parts = _term(-term if negative else term, printer)
        if negative or pieces:
            sign = printer.leaf("mo", "-" if negative else "+")
            # At the start of an element it would be taken for the sign of a number.
            sign.setAttribute("form", "infix" if pieces else "prefix")
            parts[0].insert(0, sign)
        pieces += parts
    return pieces


def _term(term: sympy.Expr, printer: "_Printer") -> list[Piece]:
    """A term as a whole, or a long one as its factors, the sums among them in brackets."""
    whole = printer._print(term)
    factors = sympy.Mul.make_args(term)
    sums = [factor for factor in factors if factor.is_Add]
    if not sums or _signs(whole) <= _LONG:
        return [[whole]]
    plain = sympy.Mul(*(factor for factor in factors if not factor.is_Add))
    pieces = [] if plain == 1 else [[printer._print(plain)]]
    for inside in sums:
        parts = _sum(inside, printer)
        size = _height(parts)
        parts[0].insert(0, _bracket("(", printer, size))
        parts[-1].append(_bracket(")", printer, size))
        pieces += parts
    return pieces


def _height(parts: list[Piece]) -> str:
    """How high brackets about pieces are; they stand in different elements and must agree."""
    elements = [element for piece in parts for element in piece]
    raised = [e for element in elements for e in (element, *element.getElementsByTagName("msup"))]
    if any(e.tagName == "msup" and e.getElementsByTagName("mfrac") for e in raised):
        return "3.4em"
    if any(e.tagName == "mfrac" or e.getElementsByTagName("mfrac") for e in elements):
        return "2.4em"
    return ""


def _bracket(sign: str, printer: "_Printer", size: str) -> Element:
    bracket = printer.leaf("mo", sign)
    if size:
        bracket.setAttribute("minsize", size)
        bracket.setAttribute("maxsize", size)
    else:
        bracket.setAttribute("stretchy", "false")
    return bracket


def _signs(element: Element) -> int:
    """About how wide an element is."""
    texts = re.findall(r">([^<>]+)<", element.toxml())
    return sum(len(re.sub(r"&(?:amp;)?\w+;", "", text)) for text in texts)


def _math(piece: Piece, printer: "_Printer") -> str:
    row = printer.dom.createElement("mrow")
    for element in piece:
        row.appendChild(element)
    # The printer names signs that every reader of HTML knows; a product gets a little space.
    text = re.sub(r"&amp;(?=[A-Za-z]+;)", "&", row.toxml())
    text = text.replace(_TIMES, _SPACE).replace(">-</mo>", ">\u2212</mo>")
    # Round brackets about one letter need not grow for its dot.
    text = _ROUND.sub(r'<mo stretchy="false">(</mo>\1<mo stretchy="false">)</mo>', text)
    return f'<math displaystyle="true">{text}</math>'


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
