"""Formulas as LaTeX for documents and Markdown, and as MathML for browsers."""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any
from xml.dom.minidom import Element

import sympy
from sympy.printing.latex import LatexPrinter
from sympy.printing.mathml import MathMLPresentationPrinter

from axisid.modeling.quantities import (
    BALANCED,
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    REFERENCE,
    Coordinate,
    Formula,
    InReadingOrder,
    readable,
)

_DOTS = ("", "˙", "¨")  # of position, velocity and acceleration
_TIMES, _SPACE = "<mo>&InvisibleTimes;</mo>", '<mspace width="0.2em"/>'
# One letter in round brackets.
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
#: Names of the inputs of a control law.
SIGNALS = {
    REFERENCE: "reference",
    MEASURED_POSITION: "measured position",
    MEASURED_VELOCITY: "measured velocity",
    PERIOD: "period",
    BALANCED: "balanced",
}
_SPECIALS = str.maketrans(
    {
        **{c: f"\\{c}" for c in "#$%&_{}"},
        "\\": r"\textbackslash{}",
        "^": r"\textasciicircum{}",
        "~": r"\textasciitilde{}",
        "<": r"\textless{}",
        ">": r"\textgreater{}",
        "|": r"\textbar{}",
    }
)
_BETWEEN_UNITS = str.maketrans({"*": r"\cdot ", "·": r"\cdot ", " ": r"\,"})
_INDEXED = re.compile(r"([A-Z])([a-z]{1,2})")  # friction Fv is F with the index v
_MOST_TERMS = 4  # terms of a sum on one line
_LONGEST = 280  # characters of a line, unless a single term has more


def formula_mathml(formula: Formula, coordinate: Coordinate) -> str:
    """Return ``name = value`` as HTML, with one ``math`` element per term of a sum.

    The browser can then break lines between terms.

    Parameters
    ----------
    formula : Formula
        A formula with a value.
    coordinate : Coordinate
        Its velocity and acceleration are written with dots.
    """
    prepared = readable(with_named_steps(formula.value), coordinate)
    printer = _Printer(prepared, {}, coordinate)
    if isinstance(formula.name, str):
        left = printer.leaf("mi", formula.name)
    else:
        named = readable(formula.name, coordinate)
        left = _Printer(named, {}, coordinate)._print(named.value)
    pieces = [[left, printer.leaf("mo", "=")]]
    value = prepared.value
    terms = prepared.terms(value) if value.is_Add else [value]
    for i, term in enumerate(terms):
        is_negative = term.could_extract_minus_sign()
        piece = [printer._print(-term if is_negative else term)]
        if is_negative or i:
            sign = printer.leaf("mo", "-" if is_negative else "+")
            # At the start of an element it would be read as the sign of a number.
            sign.setAttribute("form", "infix" if i else "prefix")
            piece.insert(0, sign)
        pieces.append(piece)
    return f'<div class="formula">{" ".join(_element(piece, printer) for piece in pieces)}</div>'


def _element(piece: list[Element], printer: "_Printer") -> str:
    """Return MathML elements as one ``math`` element."""
    row = printer.dom.createElement("mrow")
    for element in piece:
        row.appendChild(element)
    # The printer writes signs as HTML entities; a product gets a little space.
    text = re.sub(r"&amp;(?=[A-Za-z]+;)", "&", row.toxml())
    text = text.replace(_TIMES, _SPACE).replace(">-</mo>", ">\u2212</mo>")
    # Round brackets about one letter need not grow for its dot.
    text = _ROUND.sub(r'<mo stretchy="false">(</mo>\1<mo stretchy="false">)</mo>', text)
    return f'<math displaystyle="true">{text}</math>'


class _NamingPrinter(MathMLPresentationPrinter):  # type: ignore[misc]
    """SymPy's MathML printer with the notation of names of this package.

    ``Fv`` is one symbol with an index, and ``dq`` is a dotted ``q``.
    """

    def __init__(self, settings: Mapping[str, Any], coordinate: Coordinate) -> None:
        super().__init__(settings)
        q = coordinate
        self._motion = {q.symbol: 0, q.velocity: 1, q.acceleration: 2}
        self._coordinate = q.name

    def leaf(self, kind: str, text: str) -> Element:
        """Return an element of a kind, such as ``mi``, that contains only a text."""
        made: Element = self.dom.createElement(kind)
        made.appendChild(self.dom.createTextNode(text))
        return made

    def _print_Symbol(self, symbol: sympy.Symbol, style: str = "plain") -> Element:  # noqa: ARG002, N802
        """Return a symbol: a signal of a law in words, a motion with dots, or a name."""
        if symbol in SIGNALS:
            # A text element would have no space around signs.
            return self.leaf("mi", SIGNALS[symbol])
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
        """Return a name with its indices; a constant, whose name is a number, as this number."""
        if not name.isidentifier():
            constant: Element = self._print_Float(sympy.Float(name))
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


class _Printer(InReadingOrder, _NamingPrinter):
    """MathML printer with the names of this package, and terms in reading order."""


def with_named_steps(value: sympy.Expr) -> sympy.Expr:
    """Return an expression in which Heaviside functions are called ``step``.

    SymPy writes them as theta, which is a parameter of the direct model.
    """
    return value.replace(sympy.Heaviside, lambda inside, _: sympy.Function("step")(inside))


def escaped_latex(text: str) -> str:
    """Return plain text escaped for LaTeX."""
    return " ".join(text.split()).translate(_SPECIALS)


def aligned_latex(formulas: Iterable[Formula], coordinate: Coordinate) -> str:
    """Return formulas as lines of ``align`` or ``aligned``, aligned at ``=`` or ``:``."""
    return " \\\\\n".join(_line(formula, coordinate) for formula in formulas)


def symbol_latex(name: str) -> str:
    """Return a name as one LaTeX symbol; digits and parts after ``_`` become indices.

    ``Fv`` is F with the index v, not F times v. A constant, whose name is a number, is this number.
    """
    if not name.isidentifier():
        return str(sympy.latex(sympy.Float(name)))
    head, indices = name_parts(name)
    if head in _GREEK:
        head = f"\\{head}"
    elif len(head) > 1:
        head = rf"\mathit{{{head}}}"
    index = r",\,".join(i if i.isdigit() else rf"\mathrm{{{i}}}" for i in indices)
    return f"{head}_{{{index}}}" if index else head


def name_parts(name: str) -> tuple[str, list[str]]:
    """Return head and indices of a name: ``J_motor_2`` has two indices, ``tau0`` and ``Fv`` one."""
    head, *indices = name.split("_")
    short = None if head in _GREEK else _INDEXED.fullmatch(head)
    digits = re.search(r"\d+$", head)
    if short:
        head, indices = short[1], [*short.groups()[1:], *indices]
    elif digits:
        head, indices = head[: digits.start()], [digits[0], *indices]
    return head, [index for index in indices if index]


def unit_latex(unit: str) -> str:
    """Return a unit in upright letters, as LaTeX."""
    powers = re.sub(r"(?:\^|\*\*)(?:\(([-\d/]+)\)|(-?\d+))", r"^{\1\2}", unit)
    return rf"\mathrm{{{powers.translate(_BETWEEN_UNITS)}}}"


def _line(formula: Formula, q: Coordinate) -> str:
    """Return a formula as a line of ``align``: name, value, unit and column of the regressor."""
    name = formula.name
    if isinstance(name, str):
        head = rf"\text{{{escaped_latex(name)}}}"
    else:
        head = " ".join(_terms(name, q))
    unit = rf"\ [{unit_latex(formula.unit)}]" if formula.unit else ""
    if formula.value is None:
        return f"{head}{unit} &:\\ {_sum(formula.column, q)}"
    column = "" if formula.column is None else rf"\ :\ {_sum(formula.column, q)}"
    return f"{head} &= {_sum(formula.value, q)}{unit}{column}"


def _sum(value: sympy.Expr | None, q: Coordinate) -> str:
    """Return an expression as LaTeX, a long sum on several lines; empty for None."""
    return "" if value is None else " \\\\\n&\\quad ".join(_rows(_terms(value, q)))


def _rows(terms: Sequence[str]) -> list[str]:
    """Return terms with their signs in lines of limited length."""
    rows: list[list[str]] = [[]]
    for i, term in enumerate(terms):
        full = len(rows[-1]) == _MOST_TERMS or len("".join([*rows[-1], term])) > _LONGEST
        if rows[-1] and full:
            rows.append([])
        rows[-1].append(f"+ {term}" if i and not term.startswith("-") else term)
    return [" ".join(row) for row in rows]


class _LatexPrinter(InReadingOrder, LatexPrinter):  # type: ignore[misc]
    """SymPy's LaTeX printer with terms in reading order."""


def _terms(value: sympy.Expr, q: Coordinate) -> list[str]:
    """Return the terms of an expression as LaTeX, in reading order."""
    prepared = readable(with_named_steps(value), q)
    name = symbol_latex(q.name)
    typeset = {s: rf"\text{{{words}}}" for s, words in SIGNALS.items()}
    typeset |= {q.velocity: rf"\dot{{{name}}}", q.acceleration: rf"\ddot{{{name}}}"}
    names = {
        s: typeset.get(s) or symbol_latex(s.name)
        for s in prepared.names.values()
        if isinstance(s, sympy.Symbol)
    }
    printer = _LatexPrinter(prepared, {"symbol_names": names, "mul_symbol": r"\, "})
    whole = prepared.value
    texts = map(printer.doprint, prepared.terms(whole) if whole.is_Add else [whole])
    # GitHub knows no operatorname, and a bar would end the cell of a table.
    return [t.replace(r"\operatorname{", r"\mathrm{").replace("|", r"\vert ") for t in texts]
