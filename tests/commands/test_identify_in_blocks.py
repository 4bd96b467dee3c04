"""``axisid identify --stream``: loops of a log in blocks are compiled, and say the same."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import axisid.codegen.artefacts as artefacts
from axisid import Record
from axisid.codegen.artefacts import build

Run = Callable[..., tuple[int, str, str]]


@pytest.mark.parametrize(
    ("options", "native"),
    [(("idm-iv",), True), (("idm-iv", "--no-native"), False), (("idm-ls",), False)],
)
def test_what_simulates_loops_in_blocks_is_compiled_unless_told_otherwise(
    run: Run,
    tmp_path: Path,
    twin: Record,
    monkeypatch: pytest.MonkeyPatch,
    options: tuple[str, ...],
    native: bool,
) -> None:
    assert twin.reference is not None
    assert twin.control is not None
    told: list[bool] = []

    def watched(axis: Any, *, native: bool) -> Any:
        told.append(native)
        return build(axis, native=native)

    monkeypatch.setattr(artefacts, "build", watched)
    log = tmp_path / "log.csv"
    table = np.column_stack([twin.time, twin.position, twin.reference, twin.control])
    np.savetxt(log, table, delimiter=",", header="time,position,reference,control", comments="")
    args = ("identify", "emps2015", log, "--stream", "--json", "-", "--method", *options)
    code, out, err = run(*args)
    assert code == 0, err
    assert told == [native]
    assert json.loads(out)["parameters"]["M"]["value"] == pytest.approx(100.2, rel=0.01)
