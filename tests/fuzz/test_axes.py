"""Axes drawn at random find their own true parameters in their twins, or say what is in the way.

So do damaged logs of them, which leave nothing half done.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from axisid import (
    AxisidError,
    build,
    load_axis,
    twin_record,
)
from benchmarks.random_axes import RandomAxis, Term, random_axis
from tests.fuzz.cases import Fuzz, Run, WrongError, kept_to
from tests.fuzz.test_expressions import random_text, renamed
from tests.fuzz.test_text_logs import damaged
from tests.unjudged import identify

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


@pytest.mark.slow
def test_sound_axes_are_identified(tmp_path: Path) -> None:
    Fuzz(
        name="sound axes",
        count=4,
        draw=random_axis,
        check=lambda axis: _accepted(axis, tmp_path / "axis.toml"),
        shown=lambda axis: axis.toml,
    ).run()


@pytest.mark.slow
def test_axes_with_any_force_are_identified_or_objected_to(tmp_path: Path) -> None:
    Fuzz(
        name="wild axes",
        count=4,
        draw=wild_axis,
        check=lambda axis: _identified(axis, tmp_path / "axis.toml"),
        shown=lambda axis: axis.toml,
    ).run()


_ROWS = 1500


@pytest.fixture(scope="module")
def declaration(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("axis") / "axis.toml"
    file.write_text(random_axis(np.random.default_rng(8)).toml, encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def log(declaration: Path) -> bytes:
    record = twin_record(build(load_axis(declaration)))
    columns = {role: values[:_ROWS] for role, values in record.channels().items()}
    rows = (",".join(f"{x:.9g}" for x in row) for row in zip(*columns.values(), strict=True))
    return "\n".join([",".join(columns), *rows, ""]).encode()


@pytest.mark.slow
def test_damaged_logs_are_identified_or_refused(
    run: Run, declaration: Path, log: bytes, tmp_path: Path
) -> None:
    file, output = tmp_path / "log.csv", tmp_path / "result.json"

    def check(text: str) -> None:
        file.write_bytes(text.encode("latin-1"))
        code, written = kept_to(
            run,
            *("identify", declaration, file, "--method", "idm-ls", "--json", output),
            output=output,
        )
        if code == 0:
            json.loads(written)

    Fuzz(
        name="damaged twins",
        count=12,
        draw=lambda rng: damaged(log, rng),
        check=check,
        shown=lambda text: repr(text[:3000]),
    ).run()
