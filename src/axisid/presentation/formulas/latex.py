"""Formulas in LaTeX, for documents and for Markdown."""

import re
from collections.abc import Iterable, Sequence

import sympy
from sympy.printing.latex import LatexPrinter

from axisid.modeling.declaration import Axis, equation_of_motion
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

#: What a control law reads, in words.
SIGNALS = {
    REFERENCE: "reference",
    MEASURED_POSITION: "measured position",
    MEASURED_VELOCITY: "measured velocity",
    PERIOD: "period",
    BALANCED: "balanced",
}

_GREEK = frozenset(
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau "
    "upsilon phi chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega".split()
)
_SPECIAL = {
    **{c: f"\\{c}" for c in "#$%&_{}"},
    "\\": r"\textbackslash{}",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
}
_SPECIALS = str.maketrans(_SPECIAL)
_INDEXED = re.compile(r"([A-Z])([a-z]{1,2})")  # friction Fv is F with the index v
_MOST_TERMS = 4  # of a line
_LONGEST = 280  # characters of a line, unless one term has more


def with_named_steps(value: sympy.Expr) -> sympy.Expr:
    """SymPy prints a step as a theta, which here is a parameter of the direct model."""
    step = sympy.Function("step")
    return value.replace(sympy.Heaviside, lambda inside, _: step(inside))


def escaped_latex(text: str) -> str:
    """Plain text for a LaTeX document."""
    return " ".join(text.split()).translate(_SPECIALS)


def aligned_latex(formulas: Iterable[Formula], coordinate: Coordinate) -> str:
    """Lines for the inside of an ``align`` or ``aligned``, at ``=`` and ``:``."""
    return " \\\\\n".join(_line(formula, coordinate) for formula in formulas)


def equation_latex(axis: Axis) -> str:
    """The equation of motion in Markdown, its rows apart, since not all know ``aligned``."""
    formula, q = equation_of_motion(axis), axis.coordinate
    left = " ".join(_terms(formula.name, q))
    first, *others = _rows(_terms(formula.value, q))
    rows = [f"{left} = {first}", *others]
    rows[-1] += rf"\ [{unit_latex(formula.unit)}]"
    return "\n\n".join(f"$$\n{row}\n$$" for row in rows)


def symbol_latex(name: str) -> str:
    """A name as one symbol: ``Fv`` is not F times v, digits and what follows ``_`` are indices."""
    if not name.isidentifier():
        return str(sympy.latex(sympy.Float(name)))  # a constant without a name
    head, indices = name_parts(name)
    if head in _GREEK:
        head = f"\\{head}"
    elif len(head) > 1:
        head = rf"\mathit{{{head}}}"
    index = r",\,".join(i if i.isdigit() else rf"\mathrm{{{i}}}" for i in indices)
    return f"{head}_{{{index}}}" if index else head


def name_parts(name: str) -> tuple[str, list[str]]:
    """A name's head and its indices: ``J_motor_2`` has two, ``tau0`` and ``Fv`` one."""
    head, *indices = name.split("_")
    if head not in _GREEK and (short := _INDEXED.fullmatch(head)):
        head, indices = short[1], [*short.groups()[1:], *indices]
    elif digits := re.search(r"\d+$", head):
        head, indices = head[: digits.start()], [digits[0], *indices]
    return head, [index for index in indices if index]


def unit_latex(unit: str) -> str:
    """A unit, upright."""
    powers = re.sub(r"(?:\^|\*\*)(?:\(([-\d/]+)\)|(-?\d+))", r"^{\1\2}", unit)
    for sign, latex in (("*", r"\cdot "), ("·", r"\cdot "), (" ", r"\,")):
        powers = powers.replace(sign, latex)
    return rf"\mathrm{{{powers}}}"


def _line(formula: Formula, q: Coordinate) -> str:
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
    """An expression, a long sum on several lines."""
    if value is None:
        return ""
    return " \\\\\n&\\quad ".join(_rows(_terms(value, q)))


def _rows(terms: Sequence[str]) -> list[str]:
    """Terms with their signs, a few to a row."""
    rows: list[list[str]] = [[]]
    for term in terms:
        first = rows == [[]]
        full = len(rows[-1]) == _MOST_TERMS or len("".join([*rows[-1], term])) > _LONGEST
        if rows[-1] and full:
            rows.append([])
        rows[-1].append(term if first or term.startswith("-") else f"+ {term}")
    return [" ".join(row) for row in rows]


class _LatexPrinter(InReadingOrder, LatexPrinter):  # type: ignore[misc]
    pass


def _terms(value: sympy.Expr, q: Coordinate) -> list[str]:
    """The terms of an expression in the order in which they are read."""
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
