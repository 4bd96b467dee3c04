"""Formulas in LaTeX, for documents and for Markdown."""

import re
from collections.abc import Iterable, Mapping
from typing import TypeAlias

import sympy

from axisid.modeling import Coordinate, Formula

Motion: TypeAlias = Mapping[sympy.Symbol, str]

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
_MOST_TERMS = 4  # of a line


def with_named_steps(value: sympy.Expr) -> sympy.Expr:
    """SymPy prints a step as a theta, which here is a parameter of the direct model."""
    step = sympy.Function("step")
    return value.replace(sympy.Heaviside, lambda inside, _: step(inside))


def escaped_latex(text: str) -> str:
    """Plain text for a LaTeX document."""
    return " ".join(text.split()).translate(_SPECIALS)


def aligned_latex(formulas: Iterable[Formula], coordinate: Coordinate) -> str:
    """Lines for the inside of an ``align`` or ``aligned``, at ``=`` and ``:``."""
    name = symbol_latex(coordinate.name)
    motion = {
        coordinate.velocity: rf"\dot{{{name}}}",
        coordinate.acceleration: rf"\ddot{{{name}}}",
    }
    return " \\\\\n".join(_line(formula, motion) for formula in formulas)


def symbol_latex(name: str) -> str:
    """A name as one symbol: ``Fv`` is not F times v, digits and what follows ``_`` are indices."""
    head, indices = name_parts(name)
    if head in _GREEK:
        head = f"\\{head}"
    elif len(head) > 1:
        head = rf"\mathit{{{head}}}"
    index = r",\,".join(i if i.isdigit() else rf"\mathrm{{{i}}}" for i in indices)
    return f"{head}_{{{index}}}" if index else head


def name_parts(name: str) -> tuple[str, list[str]]:
    """A name's head and its indices: ``J_motor_2`` has two, ``tau0`` one."""
    head, *indices = name.split("_")
    if digits := re.search(r"\d+$", head):
        head, indices = head[: digits.start()], [digits[0], *indices]
    return head, [index for index in indices if index]


def unit_latex(unit: str) -> str:
    """A unit, upright."""
    powers = re.sub(r"(?:\^|\*\*)(?:\(([-\d/]+)\)|(-?\d+))", r"^{\1\2}", unit)
    for sign, latex in (("*", r"\cdot "), ("·", r"\cdot "), (" ", r"\,")):
        powers = powers.replace(sign, latex)
    return rf"\mathrm{{{powers}}}"


def _line(formula: Formula, motion: Motion) -> str:
    name = formula.name
    if isinstance(name, str):
        head = rf"\text{{{escaped_latex(name)}}}"
    else:
        head = _expression(name, motion)
    unit = rf"\ [{unit_latex(formula.unit)}]" if formula.unit else ""
    if formula.value is None:
        return f"{head}{unit} &:\\ {_sum(formula.column, motion)}"
    column = "" if formula.column is None else rf"\ :\ {_sum(formula.column, motion)}"
    return f"{head} &= {_sum(formula.value, motion)}{unit}{column}"


def _sum(value: sympy.Expr | None, motion: Motion) -> str:
    """An expression, a long sum on several lines."""
    if value is None:
        return ""
    terms = value.as_ordered_terms() if value.is_Add else [value]
    if len(terms) <= _MOST_TERMS:
        return _expression(value, motion)
    signed = [_expression(term, motion) for term in terms]
    signed = [signed[0], *(t if t.startswith("-") else f"+ {t}" for t in signed[1:])]
    rows = [" ".join(signed[i : i + _MOST_TERMS]) for i in range(0, len(signed), _MOST_TERMS)]
    return " \\\\\n&\\quad ".join(rows)


def _expression(value: sympy.Expr, motion: Motion) -> str:
    names = {s: motion.get(s) or symbol_latex(str(s)) for s in value.free_symbols}
    text = str(sympy.latex(with_named_steps(value), symbol_names=names, mul_symbol=r"\, "))
    # GitHub knows no operatorname, and a bar would end the cell of a table.
    return text.replace(r"\operatorname{", r"\mathrm{").replace("|", r"\vert ")
