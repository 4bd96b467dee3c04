"""Sentences of missing terms have their numbers, and name elements that can be declared."""

import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal

import pytest

from axisid import Coordinate, load_axis
from axisid.estimation.diagnostics.model_error_checks import MissingTerms, MovedParameter
from axisid.estimation.misspecification import (
    TERMS,
    CandidateTerm,
    ChangedParameter,
    MissingTerm,
    ShareOfForce,
    Term,
)
from axisid.modeling.declaration import ELEMENTS
from axisid.presentation.sentences import sentence
from axisid.support.settings import setting

_LINEAR, _ROTARY = Coordinate("x", unit="m"), Coordinate("theta", unit="rad")
_CALL = re.compile(rf"\b(?:{'|'.join(ELEMENTS)})\((?:[^()]|\([^()]*\))*\)")
_PLACES = ("velocity", "exponent", "period")  # arguments of elements that are numbers

#: Terms whose remedy is no element.
_OTHERS = (
    "inertia",
    "resonance",
    "delay",
    "dead band",
    "saturation",
    "loss",
    "presliding",
    "backlash",
)


def _missing(kind: str = "constant", q: Coordinate = _LINEAR, size: float = 2.5) -> MissingTerm:
    return MissingTerm(
        term=CandidateTerm(
            kind=kind,
            at=2 * math.pi if kind == "turn" else 0.0123456,
            cutoff=7.7,
            dead_band=0.35,
            limit=4.5,
        ),
        size=size,
        standard_error=0.1,
        unit=TERMS[kind].unit.format(force=q.force_unit, unit=q.unit),
        share=ShareOfForce(percent=6.9, beyond_percent=3.2),
        coordinate=q.name,
        coordinate_unit=q.unit,
        force_unit=q.force_unit,
        drive_unit="A",
    )


def _declared(folder: Path, q: Coordinate, call: str, unit: str) -> None:
    """Load an axis with a term as it was advised, whose parameters have a unit."""
    amounts = {*re.findall(r"[A-Za-z]\w*(?!\w*[(=])", call)} - {q.name, *ELEMENTS, *_PLACES}
    inertia = "kg m^2" if q.unit == "rad" else "kg"
    listed = "".join(f'{name} = {{ unit = "{unit}" }}\n' for name in amounts)
    file = folder / "advised.toml"
    file.write_text(
        f'name = "advised"\ncoordinate = {{ name = "{q.name}", unit = "{q.unit}" }}\n'
        f'drive = {{ gain = 2.0 }}\n[parameters]\nJ = {{ unit = "{inertia}" }}\n{listed}'
        f'[newton]\ninertia = "J"\nresistance = ["{call}"]\n'
    )
    assert {p.name for p in load_axis(file).parameters} == {"J", *amounts} > {"J"}


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
    (call,) = _CALL.findall(sentence(_missing(term.kind, q)))
    _declared(tmp_path, q, call, term.unit.format(force=q.force_unit, unit=q.unit))


@pytest.mark.parametrize("kind", TERMS)
def test_a_missing_term_has_its_size_and_its_share(kind: str) -> None:
    finding = _missing(kind)
    text = sentence(finding)
    assert "is 6.9 % of the force (rms). " in text
    assert "and 3.2 % of the force remains unexplained. " in text
    assert (f"+2.5 +- 0.1 {finding.unit}" in text) is bool(finding.unit)
    assert "{" not in text
    assert text[:1].islower() or kind == "coulomb"
    whole = replace(finding, share=ShareOfForce(percent=250.0, beyond_percent=3.2))
    assert "2.5 +-" not in sentence(whole)


@pytest.mark.parametrize(
    ("kind", "parts"),
    [
        ("resonance", ["antiresonance near 0.012 Hz", "7.7 Hz", setting("cutoff", "7.7")]),
        ("dead band", ["deadband = 0.35", "Drive(deadband=0.35)", " in A "]),
        ("saturation", ["0.012 N", "limit = 4.5", "Drive(limit=4.5)", " in A "]),
        ("stribeck", ["higher at speeds up to about 0.01 m/s"]),
    ],
)
def test_advice_has_its_number(kind: str, parts: list[str]) -> None:
    text = sentence(_missing(kind))
    assert [part for part in parts if part not in text] == []


def test_the_sign_of_a_term_changes_its_sentence() -> None:
    assert "lower at speeds" in sentence(_missing("stribeck", size=-2.5))
    early = sentence(_missing("delay", size=-1e-3))
    assert "feed-forward" in early
    assert "feed-forward" not in sentence(_missing("delay", size=1e-3))


def test_an_element_that_is_declared_asks_for_other_numbers() -> None:
    finding = _missing("stribeck")
    finding = replace(finding, term=replace(finding.term, is_declared=True))
    assert not _CALL.findall(sentence(finding))


def test_other_terms_are_named_with_their_own_numbers() -> None:
    others = (CandidateTerm(kind="place", at=0.2), CandidateTerm(kind="dead band"))
    text = sentence(replace(_missing(), others=others))
    assert "alternative to a constant force, add cogging(a, b, x, period=0.2)" in text
    assert "deadband" not in text


def test_a_term_of_the_users_own_has_its_words() -> None:
    finding = _missing()
    words = {"what": "ripple at {at:.2g} {unit}", "declare": "use rip({q})"}
    own = CandidateTerm(kind="own", at=0.2, **words)
    text = sentence(replace(finding, term=own))
    assert text.startswith("ripple at 0.2 m: +2.5 +- 0.1 N")
    assert text.endswith("Use rip(x)")
    assert "unnamed" in sentence(replace(finding, term=CandidateTerm(kind="unnamed")))


def _changed(
    change: Literal["held", "drift", "step"], *, is_gain: bool = False, size: float = 3.0
) -> ChangedParameter:
    return ChangedParameter(
        parameter="Fc",
        is_gain=is_gain,
        change=change,
        size=size,
        standard_error=0.2,
        unit="N",
        percent=None if change == "held" else 12.0,
        seconds=4.2 if change == "step" else None,
        share=ShareOfForce(percent=2.0, beyond_percent=2.0),
    )


@pytest.mark.parametrize(
    ("finding", "parts"),
    [
        (_changed("held"), ["Fc is 3 +- 0.2 N larger", "2 % of the force"]),
        (_changed("held", size=-3.0), ["Fc is 3 +- 0.2 N smaller"]),
        (_changed("drift"), ["Fc drifts with time: +3 +- 0.2 N (+12 %)", "2 % of the force"]),
        (_changed("step"), ["Fc changes by +3 +- 0.2 N (+12 %)", "4.2 s"]),
        (_changed("step", is_gain=True), ["the drive gain"]),
    ],
)
def test_a_parameter_that_changes_has_its_change(
    finding: ChangedParameter, parts: list[str]
) -> None:
    text = sentence(finding)
    assert [part for part in parts if part not in text] == []


@pytest.mark.parametrize("may_be_long_delay", [False, True])
def test_missing_terms_are_said_one_after_another(may_be_long_delay: bool) -> None:
    found = (_missing(), _changed("drift"))
    text = sentence(MissingTerms(found=found, may_be_long_delay=may_be_long_delay))
    assert text.startswith("2 errors of the model")
    assert "(1) A constant force" in text
    assert "(2) The parameter Fc drifts" in text
    assert ("declared too long" in text) is may_be_long_delay
    assert sentence(MissingTerms(found=()))


@pytest.mark.parametrize("is_changing", [False, True])
def test_a_moved_parameter_has_its_change_and_the_threshold(is_changing: bool) -> None:
    finding = MovedParameter(
        parameter="Fv", percent=42.0, most_percent=30.0, is_changing=is_changing
    )
    text = sentence(finding)
    assert "Fv" in text
    assert "42 % of its value" in text
    assert "30 %" in text


def test_a_moved_parameter_has_the_missing_term_and_its_values() -> None:
    finding = MovedParameter(
        parameter="Fv",
        percent=50.0,
        most_percent=30.0,
        is_changing=False,
        values=(412.0, 207.0, 186.0),
        unit="N/(m/s)",
        cause=_missing("coulomb"),
    )
    text = sentence(finding)
    for part in ("Coulomb friction", "from 412 to 207 N/(m/s)", "186 N/(m/s)", "Do not use Fv"):
        assert part in text


@pytest.mark.parametrize("make", [_missing, lambda: _changed("drift")])
def test_an_equal_share_is_said_once(make: Callable[[], MissingTerm | ChangedParameter]) -> None:
    text = sentence(replace(make(), share=ShareOfForce(percent=5.0, beyond_percent=5.0)))
    assert text.count("5 %") == 1
