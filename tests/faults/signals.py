"""Faults of signals: time in other units, clocks that jump or drift, spikes, cut-off values."""

import json
from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from axisid import DataError, Record, build, load_axis, twin_record
from tests.faults.fault import Fault, Misuse
from tests.files import csv_file
from tests.run_files import run_file

Columns = dict[str, np.ndarray]
Spoil = Callable[[Columns], Columns]

_LS = ("--method", "idm-ls")
_RESULT = "result.json"
_ROW = 4130  # where one sample or more is spoilt


@cache
def _twin(axis: str) -> Record:
    """The axis's own twin, whose parameters are known."""
    return twin_record(build(load_axis(axis)))


def _log(
    folder: Path,
    spoil: Spoil | str,
    *options: object,
    axis: str = "emps2015",
    without: str = "",
    digits: str = "%.9g",
    cut: int = 0,
    said: Mapping[str, object] = MappingProxyType({}),
) -> list[object]:
    """Write the log of a twin, spoilt, with so many letters of its end cut off.

    What is said of it goes into a run.toml.
    """
    record = _twin(axis)
    change = _SPOILS[spoil] if isinstance(spoil, str) else spoil
    columns = change({role: values.copy() for role, values in record.channels().items()})
    kept = {role: values for role, values in columns.items() if role != without}
    names = load_axis(axis).columns
    named = {names.get(role, role): values for role, values in kept.items()}
    file = csv_file(folder / "log.csv", named, digits)
    if cut:
        file.write_text(file.read_text().rstrip()[:-cut])
    return ["identify", axis, run_file(file, **said) if said else file, *_LS, *options]


def _slower(columns: Columns, factor: float) -> Columns:
    return columns | {"time": factor * columns["time"]}


#: Ways to spoil all columns.
_SPOILS: dict[str, Spoil] = {
    "thinned": lambda columns: {role: values[::2] for role, values in columns.items()},
    "timeless": lambda columns: {
        role: values for role, values in columns.items() if role not in ("time", "reference")
    },
    "joined": lambda columns: {
        role: np.concatenate([values, values]) for role, values in columns.items()
    },
    "coarse": lambda columns: columns | {"time": np.floor(250 * columns["time"] + 1e-9) / 250},
    "same": lambda columns: columns,
}


def _burst(columns: Columns) -> Columns:
    columns["position"][_ROW : _ROW + 40] = np.nan
    return columns


def _stepped(columns: Columns, seconds: float) -> Columns:
    columns["time"][_ROW:] += seconds
    return columns


def _swapped(columns: Columns) -> Columns:
    for values in columns.values():
        values[[_ROW, _ROW + 1]] = values[[_ROW + 1, _ROW]]
    return columns


def _drifting(columns: Columns) -> Columns:
    """The same motion, sampled by a clock that runs down."""
    time, count = columns["time"], len(columns["time"])
    own = np.cumsum(np.linspace(0.72e-3, 1.28e-3, count))
    own = own[own < time[-1]]
    return {role: np.interp(own, time, values) for role, values in columns.items()} | {"time": own}


def _spiked(columns: Columns) -> Columns:
    columns["position"][_ROW] += 5e-3
    return columns


def _clipped(columns: Columns) -> Columns:
    level = 0.6 * float(np.quantile(np.abs(columns["control"]), 0.999))
    return columns | {"control": np.clip(columns["control"], -level, level)}


def _is_right(folder: Path, _out: str, *, axis: str = "emps2015", off: float = 0.01) -> None:
    """The mass is the twin's."""
    written = json.loads((folder / _RESULT).read_text())
    (estimate,) = written["estimates"]
    value = estimate["parameters"]["M"]["value"]
    assert abs(value / _twin(axis).provenance.truth["M"] - 1) < off


def _repaired(name: str, make: Callable[..., list[object]], says: str, **options: Any) -> Fault:
    """A row of a fault that is mended: the result is right."""
    return Fault(name=name, make=make, code=0, says=says, after=partial(_is_right, **options))


def _wrong_time(factor: float, *options: object) -> Callable[[Path], list[object]]:
    return lambda folder: _log(
        folder, partial(_slower, factor=factor), *options, without="reference"
    )


_TIME_BASE = (
    *(
        Fault(
            name=f"time times {factor:g} without a reference",
            make=_wrong_time(factor, *options),
            code=0,
            says=r"Do not use .*: the recorded control .* FAIL law: the record is sampled every "
            rf"{factor * 1e-3:g} s, .* the control law runs every 0\.001 s",
        )
        for factor, options in (
            (1.05, ()),
            (2.0, ()),
            (1.001, ()),
            (1000.0, ("--cutoff", "0.06")),
        )
    ),
    Fault(
        name="time times 2, resampled at the law's rate",
        is_slow=True,
        make=_wrong_time(2.0, "--resample", "1000"),
        code=0,
        says="FAIL law: the record is sampled every 0.002 s",
    ),
    Fault(
        name="a sampling period that nothing confirms",
        make=lambda folder: _log(folder, "timeless", said={"sample_period": 1.05e-3}),
        code=0,
        says=r"FAIL law.*0\.00105 s.*sample_period",
    ),
    Fault(
        name="a log that keeps one sample in two",
        make=lambda folder: _log(folder, "thinned", without="reference"),
        code=0,
        says=r"FAIL law.*0\.002 s.*sample_period = 0\.002 in run\.toml",
    ),
    _repaired(
        "a log that keeps one sample in two, as the user confirms",
        lambda folder: _log(
            folder,
            "thinned",
            *("--json", folder / _RESULT),
            said={"sample_period": 2e-3},
            without="reference",
        ),
        r"law.*: not evaluated\. The record is sampled every 0\.002 s",
    ),
    Fault(
        name="a period that drifts",
        make=lambda folder: _log(folder, _drifting),
        code=3,
        says=r"the sampling period drifts from 0\.7\d+ to 1\.2\d+ ms .*\(--resample auto\)",
    ),
    _repaired(
        "a period that drifts, resampled",
        lambda folder: _log(folder, _drifting, "--resample", "auto", "--json", folder / _RESULT),
        "resampled at",
        off=0.03,
    ),
)

_CLOCK = (
    Fault(
        name="two logs in one file",
        make=lambda folder: _log(folder, "joined"),
        code=3,
        says=r"does not increase in data row 7802.*another log was appended.*--gaps split",
    ),
    _repaired(
        "two logs in one file, cut",
        lambda folder: _log(folder, "joined", "--gaps", "split", "--json", folder / _RESULT),
        "clock is set back once, before data row 7802, from 7.8 s to 0 s",
    ),
    Fault(
        name="a clock that is set back by less than a sample",
        make=lambda folder: _log(folder, partial(_stepped, seconds=-0.7e-3)),
        code=3,
        says=r"before data row 4131 is 0\.0003 s.*\(--gaps split\)",
    ),
    _repaired(
        "a clock that is set back by half a second, cut",
        lambda folder: _log(
            folder,
            partial(_stepped, seconds=-0.5),
            *("--gaps", "split", "--resample", "auto", "--json", folder / _RESULT),
        ),
        "clock is set back once, before data row 4131",
    ),
    Fault(
        name="a clock that is set forward",
        make=lambda folder: _log(folder, partial(_stepped, seconds=0.5)),
        code=3,
        says=r"before data row 4131 is 0\.501 s.*\(--gaps split\)",
    ),
    Fault(
        name="rows out of order",
        make=lambda folder: _log(folder, _swapped),
        code=3,
        says=r"does not increase in data row 4132.*If rows are out of order",
    ),
    Fault(
        name="time stamps of too few digits",
        make=lambda folder: _log(folder, "coarse"),
        code=3,
        says=r"too coarse.*set sample_period in run.toml",
    ),
    _repaired(
        "time stamps of too few digits, counted",
        lambda folder: _log(
            folder, "coarse", "--json", folder / _RESULT, said={"sample_period": 1e-3}
        ),
        "time stamps with steps of 0 to 4 ms are replaced by a count",
    ),
    Fault(
        name="a burst of empty cells",
        make=lambda folder: _log(folder, _burst),
        code=3,
        says=r"nan in data row 4131 \(40 of.*\(--resample auto\).*\(--gaps split\)",
    ),
    _repaired(
        "a burst of empty cells, resampled and cut",
        lambda folder: _log(
            folder, _burst, "--resample", "auto", "--gaps", "split", "--json", folder / _RESULT
        ),
        "cut at 1 gap",
    ),
)

_VALUES = (
    _repaired(
        "a spike in the position",
        lambda folder: _log(folder, _spiked, "--json", folder / _RESULT),
        r"outliers.* are masked.* at 4\.13 s",
    ),
    _repaired(
        "a last row cut inside its last number",
        lambda folder: _log(folder, "same", "--json", folder / _RESULT, digits="%.6f", cut=4),
        "1 incomplete line at the end is left out, from line 7802",
    ),
    Fault(
        name="a control that the recorder cut off",
        is_slow=True,
        make=lambda folder: _log(folder, _clipped, axis="emps"),
        code=0,
        says="FAIL law",
    ),
    _repaired(
        "a control that the recorder cut off, masked",
        lambda folder: _log(
            folder,
            _clipped,
            *("--json", folder / _RESULT),
            axis="emps",
            said={"mask": "clipped"},
        ),
        r"clipped samples are masked.*: control \d+ \(at -.* and .*\).* pass law, ",
        axis="emps",
    ),
)

FAULTS: tuple[Fault, ...] = (*_TIME_BASE, *_CLOCK, *_VALUES)


def _drifting_record() -> Record:
    time = np.cumsum(np.linspace(0.9e-3, 1.1e-3, 1000))
    return Record(time=time, position=np.sin(time))


MISUSES: tuple[Misuse, ...] = (
    Misuse(
        name="a record whose period drifts",
        call=_drifting_record,
        error=DataError,
        says="the sampling period drifts from 0.91011 to 1.07027 ms",
    ),
)
