"""Every element that advice names can be declared as it stands there, in Python and in TOML."""

import math
import re
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest
import sympy

import axisid.elements
from axisid import Axis, Coordinate, Parameter, Record, load_axis, newton
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.misspecification import sentence
from axisid.estimation.misspecification.search import Misspecification
from axisid.estimation.misspecification.terms import TERMS, Term
from axisid.modeling.declaration import ELEMENTS, Drive

_CALL = re.compile(rf"\b(?:{'|'.join(ELEMENTS)})\((?:[^()]|\([^()]*\))*\)")

#: Terms that advice has another cure for than an element.
_OTHERS = (
    "inertia",
    "resonance",
    "delay",
    "dead band",
    "loss",
    "presliding",
    "backlash",
)


#: Of which no term says anything.
RECORD = cast(Record, None)


def _lack(term: Term) -> Misspecification:
    two = "place" in term.kind or term.kind == "turn"
    return Misspecification(
        kind=term.kind,
        parameter="",
        values=(2.5, -1.0) if two else (2.5,),
        deviation=0.1,
        before=0.0,
        at=2 * math.pi if term.kind == "turn" else 0.0123456,
        share=0.04,
        own_share=0.03,
        p_value=1e-9,
        unit=term.unit.format(force="N", unit="m"),
    )


def _by_toml(folder: Path, q: Coordinate, call: str, parameters: list[Parameter]) -> Axis:
    listed = "".join(f'{p.name} = {{ unit = "{p.unit}" }}\n' for p in parameters)
    file = folder / "advised.toml"
    file.write_text(
        f'name = "advised"\ncoordinate = {{ name = "{q.name}", unit = "{q.unit}" }}\n'
        f"drive = {{ gain = 2.0 }}\n[parameters]\n{listed}"
        f'[newton]\ninertia = "{parameters[0].name}"\nresistance = ["{call}"]\n'
    )
    return load_axis(file)


def _by_python(q: Coordinate, call: str, parameters: list[Parameter]) -> Axis:
    elements = {name: getattr(axisid.elements, name) for name in ELEMENTS}
    names = {q.name: q, **{p.name: p for p in parameters}}
    term = eval(call, {"__builtins__": {}}, {**elements, **names})  # noqa: S307  # as a user would
    return newton(
        "advised",
        coordinate=q,
        parameters=tuple(parameters),
        inertia=parameters[0],
        resistance=(term,),
        drive=axisid.elements.Drive(gain=2.0),
    )


def _declared_alike(folder: Path, q: Coordinate, sentence: str, unit: str) -> int:
    """How many calls a sentence has, each declared in both and found to be one axis."""
    calls = _CALL.findall(sentence)
    rotary = q.unit == "rad"
    own = unit.replace("N", "N m").replace("/m", "/rad").replace("(m/", "(rad/") if rotary else unit
    for call in calls:
        amounts = set(re.findall(r"[A-Za-z]\w*(?!\w*[(=])", call)) - {q.name, *ELEMENTS}
        amounts -= {"velocity", "exponent", "period"}
        parameters = [
            Parameter("inertia", "kg m^2" if rotary else "kg"),
            *(Parameter(name, own) for name in sorted(amounts)),
        ]
        assert amounts
        one, other = (
            _by_toml(folder, q, call, parameters),
            _by_python(q, call, parameters),
        )
        assert sympy.simplify(one.force - other.force) == 0
        assert {p.name for p in one.parameters} == {"inertia", *amounts}
    return len(calls)


_LINEAR, _ROTARY = Coordinate("x", unit="m"), Coordinate("theta", unit="rad")


@pytest.mark.parametrize(
    ("term", "q"),
    [
        (term, q)
        for term in TERMS.values()
        for q in (_LINEAR, _ROTARY)
        if term.kind not in _OTHERS and (term.kind, q) != ("turn", _LINEAR)
    ],
)
def test_the_element_that_a_missing_term_names_is_declared(
    tmp_path: Path, term: Term, q: Coordinate
) -> None:
    declared = SimpleNamespace(coordinate=q, drive=Drive(gain=1.0), has_stribeck=False)
    said = sentence(_lack(term), cast(GeneratedAxis, SimpleNamespace(axis=declared)), RECORD)
    assert "declare" in said
    unit = term.unit.format(force="N", unit="m")
    assert _declared_alike(tmp_path, q, said, unit) == 1
