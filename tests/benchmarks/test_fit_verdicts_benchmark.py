"""The study of the verdicts of fits in small: right machines pass, a wrong one is named."""

import re
from importlib import import_module
from typing import Any

import pytest

study: Any = import_module("fit_verdicts")


@pytest.mark.slow
@pytest.mark.parametrize("output", ["control", "position"])
def test_a_right_machine_is_believed(output: str) -> None:
    found = study.figures_of("2 s of it", output, runs=6, seed=1)
    # In 2 s of position alone viscous friction is known to about 30 %, where it is told so.
    assert found["believed"] >= 5
    assert set(found["checks_failed"]) <= {"precision"}


@pytest.mark.slow
def test_a_position_that_friction_holds_is_believed() -> None:
    """Noise moves it otherwise at rest than in motion, which no autoregression has."""
    assert study.figures_of("pendulum", "position", runs=3, seed=1)["believed"] == 3


@pytest.mark.slow
def test_what_a_model_lacks_is_named() -> None:
    found = study.figures_of("missing offset", "control", runs=2, seed=1)
    assert found["named"] == {"a constant force: declare offset(F0)": 2}
    assert not found["believed"]


def test_how_often_right_machines_may_fail_is_told_with_its_chance() -> None:
    """None of 40: up to 7 % by 0.93**40 = 5 %."""
    assert study.most_believable(0, 40) == pytest.approx(1 - 0.05 ** (1 / 40))
    assert study.most_believable(3, 3) == 1.0
    counted = {"runs": 20, "believed": 19}
    right = study.right_of({"fine encoder": counted, "sines": counted, "spring": counted})
    assert (right["runs"], right["failed"]) == (40, 2)


@pytest.mark.slow
@pytest.mark.parametrize("asked", [{"free": "all"}, {"prior": 1e-3}, {"gain": 0.03}])
def test_free_gains_and_right_priors_are_believed(asked: dict[str, Any]) -> None:
    assert study.figures_of("emps2015", "control", runs=2, seed=1, **asked)["believed"] == 2


@pytest.mark.slow
def test_an_open_loop_from_rest_tells_friction_that_dips() -> None:
    """The window from rest, whose start hardly shows, outweighs none of the others."""
    found = study.figures_of("friction dip", "open-loop", runs=1, seed=1, horizon=0.5)
    assert found["checks_failed"] == {"missing terms": 1}
    (named,) = found["named"]
    assert "declare stribeck(Fs, q" in named


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("load behind a spring, 12 Hz", "a resonance: one of the loop near 1"),
        ("cogging of 5 mm", r"declare cogging\(a, b, q, period=0\.00(5|49\d|50\d)\)"),
        ("friction every 20 mm", r"declare periodic_coulomb\(a, b, q, period=0\.0(2|19\d|20\d)\)"),
        ("delay not declared", "another lag or delay of the drive"),
    ],
)
def test_a_fit_names_what_identify_names(name: str, said: str) -> None:
    (named,) = study.figures_of(name, "control", runs=1, seed=3)["named"]
    assert re.search(said, named)
