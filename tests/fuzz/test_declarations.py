"""Declarations with anything in them are derived, shown and built, or refused in words."""

import datetime as dt
import math
import tomllib
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import build, derive, load_axis
from axisid.commands.new import scaffold
from axisid.presentation.documents.axis_page import FORMATS, axis_page
from benchmarks.random_axes import random_axis
from tests.fuzz.cases import Fuzz, WrongError, one_of, places, spoilt
from tests.fuzz.test_expressions import random_text

Tree = dict[str, Any]

_FULL = """
name = "full"
title = "everything that a declaration may have"
coordinate = { name = "q", unit = "m" }
drive = { gain = 2.0, unit = "V", limit = 10.0, relative_sd = 0.01, profile = "1 + 0.1*sin(q/p)" }
columns = { time = "t:ms", position = "pos:mm", reference = "ref", control = "u" }

[parameters]
M = { unit = "kg", nominal = 5.0, lower = 0.0, upper = 50.0, description = "moving mass" }
n = { unit = "kg", known = 0.5, known_sd = 0.01 }
b = { unit = "N/(m/s)", nominal = 3.0 }
c = { unit = "N" }
k = { unit = "N/m", nominal = 10.0 }

[constants]
p = { value = 0.05, unit = "m" }
vs = { value = 0.02, unit = "m/s" }

[newton]
inertia = "M + n"
resistance = ["b*dq", "c*(1 + 0.5*exp(-(dq/vs)**2))*sign(dq)", "k*(q - 2*p)", "n*G"]

[control]
name = "PID"
period = 1e-3
gains = { p1 = 40.0, i1 = 0.02, d1 = 4.0 }
output = "p1*(reference - measured_position) + i1*total - d1*(measured_position - last)/period"
delay = 1
memory = { last = { following = "measured_position", start = "measured_position" }, total = { following = "total + reference - measured_position", start = "0" } }

[experiment]
moves = [{ distance = 0.1, speed = 0.2, acceleration = 4.0 }, { distance = -0.1, speed = 0.1, acceleration = 4.0 }]
truth = { M = 6.0, b = 2.0, c = 1.5 }
position_noise = 1e-6
seed = 3
"""  # noqa: E501

#: What is put in the place of a value.
_VALUES: tuple[Any, ...] = (
    *(math.nan, math.inf, -math.inf, 0, 0.0, -0.0, -1, 1e308, -1e308, 5e-324, 10**30, 10**400),
    *(1, 2, 0.5, 1e-3, True, False, "", " ", "x", "M", "q", "1", "nan", "pi", "G", "é", "\u03b1"),
    *("a" * 300, "lambda", "__import__", "N", "m", "kg", "N m", "1/s", "furlong", "m**0", "1/0"),
    *([], [[]], [1.0, "a"], {}, {"a": {}}, {"unit": "N"}, dt.date(2026, 2, 1)),
    *(["M*ddq"], ["b*dq", "b*dq"], [""], "a\nb", "\\", '"', "'", "#", "\u202e"),
)
#: Expressions that are odd in one way or another.
_TEXTS = (
    *("0", "1", "M", "q", "dq", "ddq", "M*ddq", "-M", "M*M", "M**2", "1/M", "M/b", "b*c*dq", "M*q"),
    *("1/q", "1/dq", "sqrt(q)", "sqrt(dq)", "log(q)", "q**0.5", "q**-3", "exp(q)", "exp(1e3*q)"),
    *("b*sign(q)", "c*sign(dq)*sign(q)", "c*sign(dq)**2", "b*abs(dq)", "max(q, dq)", "c*sign(ddq)"),
    *("b*tanh(dq/1e-12)", "c*sin(1e9*q)", "b*dq**20", "(M + b)*q", "M*dq**2/2", "b*atan2(dq, q)"),
    *("1e300*b*q", "1e-300*b*q", "b*1e400", "M - M", "0*b", "b*(q - q)", "sin(b)*q", "b**c*q"),
    *("p*q", "vs", "undeclared*q", "b*acos(2)", "c*max(9, acos(b))*q", "b*q**b", "abs(b)*q", "G"),
    *("stribeck(c, q, velocity=vs)", "stribeck(c, q, velocity=0)", "coulomb(b**c, q)", "viscous()"),
    *("stribeck(c, q, velocity=q)", "stribeck(c, q, velocity=b, exponent=1e9)", "viscous(b, dq)"),
    *("cogging(c, 0, q, period=1e-300)", "cogging(c, c, q, period=p, harmonic=10**9)", "offset(c)"),
    *("end_stop(q, lower=1, upper=0, stiffness=1)", "load_dependent(b, c, q)", "spring(k, q, M)"),
    *("periodic_coulomb(q, dq, q, period=dq)", "gravity(1e308)", "cubic_spring(k**20, q, q)"),
)
#: Letters that mean something in TOML or in an expression.
_LETTERS = ("=", "[", "]", "{", "}", '"', "'", ",", ".", "#", "\n", "\\", "*", "(", ")", "-", "é")


def declared(rng: np.random.Generator) -> str:
    """Draw a declaration that is in order."""
    kind = int(rng.integers(4))
    if kind == 0:
        return _FULL
    if kind == 1:
        return scaffold("drawn", newton=bool(rng.random() < 0.5), toml=True)
    return random_axis(rng).toml


def changed_declaration(rng: np.random.Generator) -> str:
    """Draw a declaration with something in it changed."""
    text = declared(rng)
    if rng.random() < 0.2:
        return spoilt(text, rng, _LETTERS, most=5)
    tree = tomllib.loads(text)
    for _ in range(int(rng.choice([1, 1, 2, 3]))):
        _change(tree, rng)
    return written(tree)


def _change(tree: Tree, rng: np.random.Generator) -> None:
    """Change one place: another value or expression, another key, none, or that of elsewhere."""
    there = list(places(tree))
    if not there:
        return
    _, holder, key = one_of(rng, there)
    kind = int(rng.integers(6))
    if kind == 0:
        del holder[key]
    elif kind == 1 and isinstance(holder, dict):
        holder[one_of(rng, ("x", "", "dq", "G", "limit", "unit", "a b", "é", "nominal"))] = (
            holder.pop(key)
        )
    elif kind == 2:
        _, other, place = one_of(rng, there)
        holder[key] = deepcopy(other[place])
    elif isinstance(holder[key], str) and rng.random() < 0.7:
        holder[key] = one_of(rng, _TEXTS) if rng.random() < 0.6 else random_text(rng, _SYMBOLS)
    else:
        holder[key] = deepcopy(one_of(rng, _VALUES))


_SYMBOLS = ("M", "b", "c", "q", "dq")


def written(tree: Tree) -> str:
    """A tree as TOML."""
    return "".join(f"{_key(key)} = {_written(value)}\n" for key, value in tree.items())


def _written(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(k)} = {_written(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_written, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return _key(value)
    return str(value) if isinstance(value, (int, dt.date)) else repr(float(value))


def _key(text: str) -> str:
    """In quotes."""
    plain = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{plain}"'


def _use(text: str, file: Path) -> None:
    """What `show` and every command after it make of a declaration."""
    file.write_text(text, encoding="utf-8")
    axis = load_axis(file)
    model = derive(axis)
    for form in FORMATS:
        page = axis_page(model, form)
        if "Traceback" in page or "object at 0x" in page:
            raise WrongError(f"page: {page}")
    build(axis, native=False)


@pytest.mark.slow
def test_changed_declarations_are_used_or_refused(tmp_path: Path) -> None:
    Fuzz(
        name="declarations",
        count=120,
        draw=changed_declaration,
        check=lambda text: _use(text, tmp_path / "axis.toml"),
        shown=str,
    ).run()


@pytest.mark.slow
def test_declarations_in_order_are_used(tmp_path: Path) -> None:
    def check(text: str) -> None:
        try:
            _use(text, tmp_path / "axis.toml")
        except ValueError as error:
            raise WrongError(f"refused: {error}") from error

    Fuzz(
        name="sound declarations",
        count=10,
        draw=declared,
        check=check,
        shown=str,
    ).run()
