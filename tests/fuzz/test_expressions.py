"""Expressions as text mean what they say, in many digits, or are refused in words."""

import re
from collections.abc import Iterator
from pathlib import Path

import mpmath
import numpy as np
import pytest

from axisid import build, load_axis
from axisid.modeling.quantities.symbols import Coordinate
from axisid.modeling.text.expression import read_expression
from axisid.modeling.text.grammar import DYNAMICS
from tests.fuzz.cases import Fuzz, WrongError, pieces_left_out
from tests.fuzz.expressions import (
    NoValueError,
    exact_value,
    random_text,
    renamed,
    smaller_texts,
    spoilt,
)

NAMES = ("x", "v")
_RELATIVE, _OF_LARGEST, _ROUNDINGS = 1e-9, 1e-12, 100.0
_RATIOS = {"x": "(q/a)", "v": "(dq/w)"}
_SPREADS = (1.0, 3.0, 0.1, 1e-3)

# Lengths and speeds over 1 have no unit, so that no expression of them is refused for its units.
_AXIS = """
name = "written"
coordinate = {{ name = "q", unit = "rad" }}
drive = {{ gain = 1.0 }}
[parameters]
J = {{ unit = "kg m^2", nominal = 1.0 }}
b = {{ unit = "N m" }}
[constants]
a = {{ value = 1.0, unit = "rad" }}
w = {{ value = 1.0, unit = "rad/s" }}
[newton]
inertia = "J"
resistance = ["b*({})"]
"""


def _points(text: str) -> Iterator[tuple[float, float]]:
    """Where an expression is looked at: anywhere, and near its own numbers, where parts cancel."""
    rng = np.random.default_rng(len(text))
    for spread in _SPREADS:
        yield tuple(spread * rng.normal(size=2))
    near = [float(number) for number in re.findall(r"\b\d[\d.]*(?:e-?\d+)?", text)]
    for number in near[:4]:
        beside = number + 10 ** rng.uniform(-7, -0.5) * rng.normal()
        yield from ((beside, rng.normal()), (rng.normal(), beside), (beside, beside))


def _check(text: str, file: Path) -> None:
    """Hold the force of an axis against what its expression says."""
    file.write_text(_AXIS.format(renamed(text, _RATIOS)), encoding="utf-8")
    built = build(load_axis(file), native=False)
    force = built.functions["inverse_dynamics"]
    for x, v in _points(text):
        try:
            right, rounding = exact_value(text, {"x": x, "v": v})
        except NoValueError:
            continue
        got = float(force(x, v, 0.0, float(np.sign(v)), [1.0, 1.0]))
        allowed = _ROUNDINGS * rounding + _RELATIVE * abs(right) + _OF_LARGEST
        if not abs(got - right) <= allowed:
            raise WrongError(f"value: {got!r} for {right!r} at x = {x!r}, v = {v!r}")


@pytest.mark.slow
def test_forces_are_those_of_the_text(tmp_path: Path) -> None:
    Fuzz(
        name="expressions",
        count=40,
        draw=lambda rng: random_text(rng, NAMES),
        check=lambda text: _check(text, tmp_path / "axis.toml"),
        smaller=smaller_texts,
        shown=str,
    ).run()


@pytest.mark.slow
def test_spoilt_text_is_read_or_refused_at_once() -> None:
    q = Coordinate("x", unit="m")
    symbols = {"x": q.symbol, "v": q.velocity}
    Fuzz(
        name="spoilt expressions",
        count=1000,
        draw=lambda rng: spoilt(random_text(rng, NAMES), rng),
        check=lambda text: read_expression(text, symbols, DYNAMICS) and None,
        smaller=pieces_left_out,
        shown=repr,
    ).run()


@pytest.mark.parametrize(
    ("text", "value"), [("x**2 - v", 2.25 - 0.5), ("max(x, v)*sign(-v)", -1.5), ("1/2*x", 0.75)]
)
def test_the_yardstick_knows_what_a_text_means(text: str, value: float) -> None:
    found, rounding = exact_value(text, {"x": 1.5, "v": 0.5})
    assert found == value
    assert rounding <= 1e-15
    with pytest.raises(NoValueError):
        exact_value("sqrt(-x)", {"x": 1.5})
    assert mpmath.mp.dps == 15
