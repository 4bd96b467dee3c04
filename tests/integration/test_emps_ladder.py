"""The ladder of models of the EMPS in open loop: its document says what the code gives."""

import importlib
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import sympy

from axisid.modeling.quantities import with_numbers

ROOT = Path(__file__).resolve().parents[2]
DOCUMENT = (ROOT / "docs" / "emps_ladder.md").read_text()
FRICTION = {"Fv": 200.0, "Fc": 20.0, "Fd": -35.0, "kd": -3.0}


@pytest.fixture(scope="module")
def study() -> Iterator[ModuleType]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "examples"))
        yield importlib.import_module("emps_ladder")


@pytest.fixture(scope="module")
def models(study: ModuleType) -> ModuleType:
    return importlib.import_module("emps_ladder_models")


@pytest.fixture(scope="module")
def data(study: ModuleType, data_folder: Path) -> Any:
    file = data_folder / "emps" / "DATA_EMPS.mat"
    if not file.is_file():
        pytest.skip(f"the EMPS record is not in {file.parent}")
    return study.read_data(file)


def documented(words: str) -> list[float]:
    """Numbers of the document's row of the ladder that starts with some words."""
    (row,) = [line for line in DOCUMENT.splitlines() if line.startswith(f"| {words} |")][:1]
    return [float(n) for n in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?", row.split("|", 2)[2])]


def test_without_terms_it_is_the_published_model(models: ModuleType) -> None:
    axis = models.axis_with()
    q = axis.coordinate
    M, Fv, Fc, tau0 = (p.symbol for p in axis.parameters)
    stated = M * q.acceleration + Fv * q.velocity + Fc * sympy.sign(q.velocity) + tau0
    assert sympy.expand(axis.force - stated) == 0
    assert axis.control is None


def test_friction_at_a_scale_of_one_is_what_it_was(models: ModuleType) -> None:
    terms = ("direction", "slope", "friction slope")
    values = {"M": 95.0, "tau0": -0.5, "k": 2.0, **FRICTION}
    whole, two = models.axis_with(terms), models.rescaled(terms, values)
    frozen = whole.force.xreplace({p.symbol: values[p.name] for p in whole.parameters})
    scale, tau0 = (p.symbol for p in two.parameters)
    q = whole.coordinate
    at = {q.symbol: 0.2, q.velocity: -0.1, q.acceleration: 0.7, tau0: -0.5}
    forces = [
        float(with_numbers(force).subs({**at, scale: size}))
        for force, size in ((frozen, 1.0), (two.force, 1.0), (two.force, 1.1))
    ]
    assert forces[0] == pytest.approx(forces[1], rel=1e-12)
    friction = -20.0 - 20.0 + 0.1 * -35.0 + 3.0 * (0.2 - 0.1232)
    assert forces[2] - forces[1] == pytest.approx(0.1 * friction, rel=1e-9)


@pytest.mark.slow
def test_document_has_the_held_out_errors_of_the_first_rungs(study: ModuleType, data: Any) -> None:
    starts: list[list[Any]] = [["nominal"]] * 4
    for terms, words in (((), "published"), (("direction",), "+ direction")):
        score = study.scored(data, study.Model(terms=terms), 1.0, study.leave_one_out(), starts)
        assert 1e6 * score.error == pytest.approx(documented(words)[1], rel=0.02)
        starts = [[values] for values in score.values]


@pytest.mark.slow
def test_document_has_what_a_force_leaves(study: ModuleType, data: Any) -> None:
    limits = importlib.import_module("emps_ladder_limits")
    model = study.Model(terms=("direction",))
    values = {"M": 92.83, "Fv": 200.8, "Fc": 20.75, "tau0": -0.157, "Fd": -38.47}
    found = limits.drifts(data, model, values)
    for name, of in found.items():
        stated = documented(f"{name} window")
        assert 50.0 * 1e3 * np.array([*of.values()]) == pytest.approx(stated, rel=0.05)
