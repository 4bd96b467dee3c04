"""Commands that are given damaged logs end with a sentence and leave nothing half done."""

import json
from pathlib import Path

import numpy as np
import pytest

from axisid import build, load_axis, twin_record
from benchmarks.random_axes import random_axis
from tests.fuzz.cases import Fuzz, pieces_left_out
from tests.fuzz.commands import kept_to
from tests.fuzz.text_logs import damaged

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
    declaration: Path, log: bytes, tmp_path: Path
) -> None:
    file, output = tmp_path / "log.csv", tmp_path / "result.json"

    def check(text: str) -> None:
        file.write_bytes(text.encode("latin-1"))
        code, written = kept_to(
            *("identify", declaration, file, "--method", "idm-ls", "--json", output),
            output=output,
        )
        if code == 0:
            json.loads(written)

    Fuzz(
        name="damaged twins",
        count=12,
        draw=lambda rng: damaged(log, rng).decode("latin-1"),
        check=check,
        smaller=pieces_left_out,
        shown=lambda text: repr(text[:3000]),
    ).run()
