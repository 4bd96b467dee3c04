"""Faults around native code, and arguments that no simulation and no record can start from."""

import os
import shlex
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from axisid import (
    DataError,
    EstimationError,
    Record,
    UsageError,
    build,
    derive,
    load_axis,
    read_record,
    simulate,
    sweep,
    twin_record,
)
from axisid.codegen import GeneratedAxis
from axisid.codegen.generated_axes.texts import axis_artefacts
from axisid.codegen.printers import with_loop_header
from axisid.codegen.runtime.library_cache import NativeUnavailableError, _name, find_compiler
from axisid.estimation import simulate_batch
from axisid.estimation.simulation.twin import trajectory
from tests.faults.fault import Fault, Misuse
from tests.unjudged import identify

# Without twins, which take a minute where no native code simulates.
_RUN: list[object] = ["identify", "emps2015", "--method", "idm-iv", "--bootstrap", "0"]


def _compiler(leaves: str) -> Callable[[Path], list[object]]:
    """A compiler that says all is well, whatever it leaves."""

    def make(folder: Path) -> list[object]:
        script = folder / "cc"
        script.write_text(
            f'#!/bin/sh\nfor target; do case "$target" in *.so) {leaves};; esac; done\n'
        )
        script.chmod(0o755)
        return _RUN

    return make


def _pipes(folder: Path) -> list[object]:
    """Pipes where the library and its digest should be."""
    cache = folder / "cache"
    cache.mkdir(mode=0o700)
    text = with_loop_header(axis_artefacts(derive(load_axis("emps2015")))["native.c"])
    try:
        library = cache / _name(text, find_compiler())
    except NativeUnavailableError:
        library = cache / "library.so"
    for file in (library, library.with_suffix(".sha256")):
        os.mkfifo(file)
    return _RUN


_PUBLISHED = """
from dataclasses import replace

from axisid import load_axis
from axisid.elements import Drive
from axisid.control import cascade_pd

axis = replace(
    load_axis("emps2015"),
    name="published",
    drive=Drive(gain=35.15, unit="V"),
    control=cascade_pd(kp=160.18, kv=243.45, period=1e-3, continuous=True),
)
"""


def _published(folder: Path) -> list[object]:
    """A continuous law with gains so large that its self-test once found right code wrong."""
    (folder / "published.py").write_text(_PUBLISHED)
    return ["identify", "published.py", "--method", "idm-iv"]


_OWN = {"AXISID_CACHE": "{folder}/cache", "TMPDIR": "{folder}"}

FAULTS: tuple[Fault, ...] = (
    Fault(
        name="half a library from a compiler that says all is well",
        is_slow=True,
        make=_compiler(f"head -c 5000 {shlex.quote(sys.executable)} > $target"),
        environment={**_OWN, "CC": "{folder}/cc"},
        code=0,
        says="IDM-IV.*no native code: the compiled library cannot be loaded",
    ),
    Fault(
        name="no library from a compiler that says all is well",
        is_slow=True,
        make=_compiler("true"),
        environment={**_OWN, "CC": "{folder}/cc"},
        code=0,
        says="IDM-IV.*no native code: .*cc failed: exit code 0",
    ),
    Fault(
        name="pipes in the cache of libraries",
        is_slow=True,
        make=_pipes,
        environment=_OWN,
        code=0,
        says="IDM-IV",
    ),
    Fault(
        name="right code of a fast loop",
        is_slow=True,
        make=_published,
        code=0,
        says=r"^(?!.*computes wrong values).*IDM-IV",
    ),
)


@cache
def _axis() -> GeneratedAxis:
    return build(load_axis("emps2015"))


@cache
def _record() -> Record:
    return twin_record(_axis())


_SHORT = np.linspace(0.0, 0.01, 100)
_MASKED = np.ma.masked_array(_SHORT, mask=_SHORT > 0.009)


def _one(**changed: Any) -> Callable[[], object]:
    """A simulation with one wrong argument."""
    given = {"reference": _SHORT, "period": 1e-3, **changed}
    return lambda: simulate(_axis(), **{"parameters": _axis().nominal, **given})


def _many(**changed: Any) -> Callable[[], object]:
    """A batch with one wrong argument."""
    given = {"reference": _SHORT, "period": 1e-3, **changed}
    return lambda: simulate_batch(_axis(), **{"parameters": [_axis().nominal], **given})


def _columns(**changed: Any) -> dict[str, Any]:
    record = _record()
    return {"time": record.time, "position": record.position, "control": record.control, **changed}


def _masked_position() -> Any:
    position = _record().position
    return np.ma.masked_array(position, mask=np.arange(len(position)) % 100 == 7)


_WRONG: tuple[tuple[str, Callable[[], object], str], ...] = (
    (
        "no threads",
        _many(threads=0),
        "the number of threads is 0. Give a whole number from 1 to 1024",
    ),
    (
        "a million threads",
        _many(threads=10**6),
        "the number of threads is 1000000. Give a whole number",
    ),
    (
        "threads as a float",
        _many(threads=1e6),
        r"the number of threads is 1000000\.0\. Give a whole",
    ),
    ("half a thread", _many(threads=2.5), r"the number of threads is 2\.5\. Give a whole number"),
    (
        "threads as a truth value",
        _many(threads=True),
        "the number of threads is True. Give a whole",
    ),
    ("no resolution", _one(resolution=None), "the resolution is None. Give 0 or more"),
    ("no resolution of a batch", _many(resolution=None), "the resolution is None. Give 0 or more"),
    ("an endless resolution", _one(resolution=np.inf), "the resolution is inf. Give 0 or more"),
    ("a period in words", _one(period="a"), "sampling period is 'a'"),
    (
        "a period of a batch in words",
        _many(period="a"),
        "sampling period is 'a'",
    ),
    (
        "substeps as a truth value",
        _one(substeps=True),
        "the number of substeps is True. Give a whole",
    ),
    ("a start that is no number", _one(start=np.nan), "the start is nan. Give one finite number"),
    (
        "starts that are no numbers",
        _many(start=[np.nan]),
        "the start has values that are not finite",
    ),
    ("a masked reference", _one(reference=_MASKED), "the reference: 10 of the values are masked"),
    ("a masked reference of a batch", _many(reference=_MASKED), "10 of the values are masked"),
    ("masked noise", _one(position_noise=_MASKED), "noise: 10 of the values are masked"),
    ("a complex reference", _one(reference=_SHORT * 1j), "values are complex"),
    (
        "a reference in words",
        _one(reference="abc"),
        "reference: the values are text",
    ),
    ("a ragged reference", _one(reference=[[1, 2], [3]]), "the values are not numeric"),
    (
        "masked parameters",
        _one(parameters=np.ma.masked_array([1.0, 1.0, 1.0], mask=[0, 1, 0])),
        "the parameters: 1 of the values are masked",
    ),
    (
        "wanted signals that are no names",
        _many(wanted=None),
        "the wanted signals are None. Give a list",
    ),
    (
        "masked samples of a function",
        lambda: _axis().evaluate("idm_regressor", _MASKED, 0, 0, 0),
        "idm_regressor: q: 10 of the values are masked",
    ),
    (
        "a function that there is not",
        lambda: _axis().evaluate("inverse", 0, 0, 0, 0),
        "axis 'emps2015' has no function 'inverse'",
    ),
    (
        "a vector of another length",
        lambda: _axis().mapped("ddm_from_physical", [1.0]),
        "ddm_from_physical cannot map 1 values",
    ),
    (
        "a masked column of a log",
        lambda: read_record(_columns(position=_masked_position()), _axis()),
        "the column 'position' has masked values",
    ),
    (
        "a sampling period in words",
        lambda: Record(**_columns(), sample_period="a"),
        "positive number of seconds",
    ),
    (
        "a sampling period of a log in words",
        lambda: read_record(_columns(), _axis(), sample_period="a"),  # type: ignore[arg-type]
        "positive number of seconds",
    ),
    (
        "segments that are no pairs",
        lambda: Record(**_columns(), segments=[1]),
        r"segments are \[1\]",
    ),
    (
        "cut-offs in words",
        lambda: sweep(_axis(), _record(), ["a"]),  # type: ignore[list-item]
        r"the cut-offs are \['a'\]\. Give one or more positive numbers",
    ),
    (
        "a prefilter that is none",
        lambda: identify(_axis(), _record(), 60.0),  # type: ignore[arg-type]
        r"the prefilter is 60\.0\. Give a Prefilter",
    ),
    (
        "a motion at no period",
        lambda: trajectory((), "a"),  # type: ignore[arg-type]
        "sampling period is 'a'",
    ),
)

MISUSES: tuple[Misuse, ...] = (
    *(Misuse(name=name, call=call, error=UsageError, says=says) for name, call, says in _WRONG),
    *(
        Misuse(
            name=f"{name} that is {value}",
            call=_one(parameters=parameters),
            error=EstimationError,
            says=f"axis 'emps2015' cannot be simulated with .*{name} = {value} .*Give finite",
        )
        for name, value, parameters in (
            ("Fc", "nan", [100.0, 200.0, np.nan]),
            ("Fv", "inf", [100.0, np.inf, 20.0]),
        )
    ),
    Misuse(
        name="a mass of nothing",
        call=_one(parameters=[0.0, 200.0, 20.0]),
        error=EstimationError,
        says="axis 'emps2015' has no positive inertia with M = 0 kg",
    ),
    Misuse(
        name="a masked signal of a record",
        call=lambda: Record(**_columns(position=_masked_position())),
        error=DataError,
        says="position: [0-9]+ of the values are masked",
    ),
    Misuse(
        name="a record without a position",
        call=lambda: Record(**_columns(position=None)),
        error=DataError,
        says="neither a position nor a velocity",
    ),
)
