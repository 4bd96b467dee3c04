"""Every number and text of the catalogue is what it was; a change on purpose is recorded anew.

``AXISID_GOLDEN=record pytest tests/golden`` writes what the program says now; commit it with the
reason. On a machine whose processor or NumPy differs sums are rounded otherwise, and some figures
are rounding alone: there what is computed is skipped; record it on the revision before a change,
then hold the change against that. ``OPENBLAS_CORETYPE`` chooses the kernels of another processor.
"""

import ctypes
import json
import math
import os
import platform
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import load_axis, read_record
from tests.golden.cases import CASES, EMPS, FOLDER, Case

Run = Callable[..., tuple[int, str, str]]

#: Of a number, or of the largest one of its list.
ROUNDING = 1e-12
#: Members that name files.
PASSED_OVER = frozenset({"source", "given", "path"})


def _blas_core() -> str:
    """The processor whose kernels NumPy's BLAS chose, which differs under the same features."""
    for file in (Path(np.__file__).parents[1] / "numpy.libs").glob("*openblas*"):
        core = getattr(ctypes.CDLL(str(file)), "scipy_openblas_get_corename64_", None)
        if core is not None:
            core.restype = ctypes.c_char_p
            return str(core().decode())
    return ""


def _machine() -> dict[str, str]:
    """What decides how rounding falls."""
    features = np._core._multiarray_umath.__cpu_features__  # type: ignore[attr-defined]
    return {
        "machine": platform.machine(),
        "numpy": np.__version__,
        "blas": _blas_core(),
        "features": " ".join(sorted(name for name, there in features.items() if there)),
    }


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_output_is_the_golden_one(
    case: Case,
    run: Run,
    tmp_path: Path,
    root: Path,
    request: pytest.FixtureRequest,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("COLUMNS", "100")  # help is as wide as the terminal
    recording = os.environ.get("AXISID_GOLDEN") == "record"
    elsewhere = json.loads((FOLDER / "machine.json").read_text()) != _machine()
    if case.computes and elsewhere and not recording:
        pytest.skip("recorded on a machine that rounds otherwise: record anew before a change")
    places = {"folder": str(tmp_path), "root": str(root)}
    if case.needs_data:
        places["data"] = str(request.getfixturevalue("data_folder"))
    for step in case.before:
        _prepare(step, places, run)
    code, out, err = run(*(word.format(**places) for word in case.command.split()))
    assert code == 0, err
    for place in places.values():
        out = out.replace(f"{place}/", "")
    file = FOLDER / f"{case.name}.{'json' if case.is_json else 'txt'}"
    if recording:
        file.parent.mkdir(exist_ok=True)
        file.write_text(_kept(out) if case.is_json else out)
        (FOLDER / "machine.json").write_text(json.dumps(_machine(), indent=1) + "\n")
        return
    if not case.is_json:
        assert out == file.read_text()
        return
    differences = list(_differences(json.loads(file.read_text()), json.loads(out), "$"))
    assert not differences, "\n".join(differences[:20])


def _prepare(step: str, places: dict[str, str], run: Run) -> None:
    if step == EMPS:
        record = read_record(step.format(**places), load_axis("emps"), sample_period=1e-3)
        table = np.column_stack([record.time, record.reference, record.position, record.control])
        head = "t,qg,qm,vir"
        np.savetxt(f"{places['folder']}/log.csv", table, delimiter=",", header=head, comments="")
    elif not step.startswith(("identify", "sweep")):
        _join(Path(step.format(**places)), Path(places["folder"]) / "dfki_joined.csv")
    else:
        code, _, err = run(*(word.format(**places) for word in step.split()))
        assert code == 0, err


def _join(data: Path, log: Path) -> None:
    """What was measured of the pendulum and what was desired, in one log."""
    measured, desired = (
        np.genfromtxt(data / f"pd_system_identification_{which}.csv", delimiter=",", names=True)
        for which in ("measured", "desired")
    )
    columns = [measured["time"], measured["position"], desired["position"], measured["torque"]]
    head = "time,position,reference,torque"
    np.savetxt(log, np.column_stack(columns), delimiter=",", header=head, comments="")


def _kept(text: str) -> str:
    return json.dumps(json.loads(text), separators=(",", ":")) + "\n"


def _differences(wanted: Any, got: Any, path: str, scale: float = 0.0) -> Iterator[str]:
    """Where two documents differ beyond rounding."""
    if isinstance(wanted, dict) and isinstance(got, dict):
        for name in wanted.keys() | got.keys():
            if name in PASSED_OVER:
                continue
            if name not in wanted or name not in got:
                yield f"{path}.{name}: {'new' if name in got else 'gone'}"
            else:
                yield from _differences(wanted[name], got[name], f"{path}.{name}")
    elif isinstance(wanted, list) and isinstance(got, list) and len(wanted) == len(got):
        largest = max((abs(x) for x in _numbers(wanted)), default=0.0)
        for i, (a, b) in enumerate(zip(wanted, got, strict=True)):
            yield from _differences(a, b, f"{path}[{i}]", max(scale, largest))
    elif _is_number(wanted) and _is_number(got):
        allowed = ROUNDING * max(abs(wanted), abs(got), scale)
        if not abs(wanted - got) <= allowed and not _is_nothing(wanted, got):
            yield f"{path}: {wanted!r} became {got!r}"
    elif wanted != got:
        yield f"{path}: {wanted!r} became {got!r}"


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _is_nothing(a: float, b: float) -> bool:
    """Both are what rounding left of zero."""
    return max(abs(a), abs(b)) < 1e-13 and math.isfinite(a) and math.isfinite(b)


def _numbers(value: Any) -> Iterator[float]:
    if isinstance(value, list):
        for each in value:
            yield from _numbers(each)
    elif _is_number(value):
        yield float(value)
