"""Axes drawn at random find their own true parameters in their twins, or say what is in the way."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from axisid import AxisidError, build, identify, load_axis, twin_record
from benchmarks.random_axes import RandomAxis, Term, random_axis
from tests.fuzz.cases import Fuzz, WrongError
from tests.fuzz.expressions import random_text, renamed

_DEVIATIONS, _PERCENT = 6.0, 0.5
_RATIOS = {"x": "(q/far)", "v": "(dq/fast)"}


def _identified(axis: RandomAxis, file: Path) -> None:
    """Declare, derive, generate, simulate and identify an axis from its own twin."""
    file.write_text(axis.toml, encoding="utf-8")
    built = build(load_axis(file))
    record = twin_record(built)
    result = identify(built, record)
    objections = [check.name for check in result.verdict if check.status == "fail"]
    if objections or result.failed:
        return
    truth = record.provenance.truth
    for name, value in result.preferred.parameters.items():
        apart = abs(value.corrected - truth[name])
        if not apart <= max(_DEVIATIONS * value.deviation, _PERCENT / 100 * abs(truth[name])):
            raise WrongError(f"parameter: {name} is {value}, {truth[name]!r} in truth")


def _accepted(axis: RandomAxis, file: Path) -> None:
    """The same of an axis that no stage has a reason to refuse."""
    try:
        _identified(axis, file)
    except AxisidError as error:
        raise WrongError(f"refused: {error}") from error


def wild_axis(rng: np.random.Generator) -> RandomAxis:
    """An axis with a force that is any expression of its position and speed."""
    axis = random_axis(rng)
    text = renamed(random_text(rng, ("x", "v"), depth=3), _RATIOS)
    force = Term(
        text=f"w*({text})",
        truth={"w": axis.force * float(rng.uniform(0.1, 0.5))},
        constants={"far": axis.stroke},
        speeds={"fast": axis.speed},
    )
    return replace(axis, terms=(*axis.terms, force))


def _smaller(axis: RandomAxis) -> Iterator[RandomAxis]:
    yield from (axis.without(k) for k in range(len(axis.terms)))


@pytest.mark.slow
def test_sound_axes_are_identified(tmp_path: Path) -> None:
    Fuzz(
        name="sound axes",
        count=4,
        draw=random_axis,
        check=lambda axis: _accepted(axis, tmp_path / "axis.toml"),
        smaller=_smaller,
        shown=lambda axis: axis.toml,
    ).run()


@pytest.mark.slow
def test_axes_with_any_force_are_identified_or_objected_to(tmp_path: Path) -> None:
    Fuzz(
        name="wild axes",
        count=4,
        draw=wild_axis,
        check=lambda axis: _identified(axis, tmp_path / "axis.toml"),
        smaller=_smaller,
        shown=lambda axis: axis.toml,
    ).run()
