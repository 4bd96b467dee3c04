"""The model of an axis on a page: its equation of motion, its drive and its control law."""

from html import escape

import sympy

from axisid.modeling.declaration import Axis, ControlLaw, Memory, equation_of_motion
from axisid.modeling.quantities import FORCE, Coordinate, Formula, written
from axisid.presentation.formulas import formula_mathml


def model_html(axis: Axis) -> str:
    """The equation of motion, the drive and the control law."""
    q, law = axis.coordinate, axis.control
    motion = formula_mathml(equation_of_motion(axis), q)
    said = (
        f"Position {q.name} in {q.unit}; {FORCE}, the drive's force, is {axis.drive.force_text(q)}."
    )
    said += f" There {axis.drive.timing_text}." if axis.drive.timing_text else ""
    equation = f'<div class="equation">{motion}<p>{escape(said)}</p></div>'
    return equation if law is None else equation + _law(law, q)


def _law(law: ControlLaw, q: Coordinate) -> str:
    """What the drive computes once a period, and what it remembers until the next."""
    formulas = [Formula(name="control", value=law.output)]
    formulas += [Formula(name=_next(memory), value=memory.following) for memory in law.memory]
    typeset = "".join(formula_mathml(formula, q) for formula in formulas)
    how = "continuous" if law.continuous else f"evaluated every {1e3 * law.period:g} ms and held"
    late = f", applied {law.delay} samples late" if law.delay else ""
    gains = ", ".join(f"{name} = {value:g}" for name, value in law.gains.items())
    facts = f"{law.name}, {how}{late}" + (f"; {gains}." if gains else ".")
    if law.memory:
        starts = ", ".join(f"{m.name} = {written(m.start, q)}" for m in law.memory)
        facts += f" Kept from sample to sample; at the first: {starts.replace('_', ' ')}."
    return f'<h3>Control law</h3><div class="equation">{typeset}<p>{escape(facts)}</p></div>'


def _next(memory: Memory) -> sympy.Symbol:
    return sympy.Symbol(f"{memory.name}_next")
