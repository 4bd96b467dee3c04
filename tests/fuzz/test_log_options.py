"""What options say of a log, in any text, is taken right or refused: scalings, windows, shifts."""

import json
import math
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from axisid import AxisidError, Record, UsageError, read_record
from axisid.commands.options.estimation_options import read_known
from axisid.estimation.logs import read_table
from axisid.estimation.records import Repairs
from axisid.estimation.records.columns.units import ScalingError, is_scaling, read_scaling
from axisid.estimation.records.segments import checked_windows
from axisid.estimation.unknowns import known_of
from tests.fuzz.cases import Fuzz, WrongError, one_of, readable_columns, spoilt

_UNITS = ("", "mm", "deg", "counts", "rpm", "V", "m/s^2", "1/min", "mm/rev", "furlong", "N m", "%")
_NUMBERS = ("1", "-1", "0", "360", "4096", ".5", "5.", "1e3", "1e999", "-0", "nan", "inf", "1_0")
_OPERATORS = ("*", "/", "+", "-", "**", "^", " ", "", ":")
#: What numbers of a unit are times, to three digits; pi is a number here.
_SIZES = {"mm": 1e-3, "deg": math.pi / 180, "V": 1.0, "rpm": math.pi / 30, "counts": 1.0}
_TIME = 1e-3 * np.arange(400)


def _text(rng: np.random.Generator) -> str:
    """Pieces of a scaling in any order."""
    kinds = (_UNITS, _NUMBERS, _OPERATORS)
    pieces = [one_of(rng, one_of(rng, kinds)) for _ in range(int(rng.integers(1, 9)))]
    return "".join(pieces)


def _right(rng: np.random.Generator) -> tuple[str, float]:
    """A scaling, and what one of its numbers is."""
    unit = one_of(rng, [*_SIZES])
    text, size = unit, _SIZES[unit]
    for _ in range(int(rng.integers(0, 5))):
        number = int(rng.integers(1, 5000))
        operator, other = one_of(rng, ("*", "/")), one_of(rng, ("", "mm", "deg", "V"))
        factor = number * _SIZES.get(other, 1.0)
        text, size = (
            f"{text}{operator}{number}{other}",
            (size * factor if operator == "*" else size / factor),
        )
    return text, size


@pytest.mark.slow
def test_scalings_of_any_text_are_read_or_refused() -> None:
    def check(text: str) -> None:
        if not is_scaling(text):
            return
        try:
            of, _ = read_scaling(text)
        except ScalingError:
            return
        if not math.isfinite(float(of)) or float(of) == 0:
            raise WrongError(f"size: {text!r} is {float(of)} each")
        if not isinstance(of.value, Fraction):
            raise WrongError(f"exact: {text!r} is {of.value!r}")

    Fuzz(
        name="scalings",
        count=3000,
        draw=_text,
        check=check,
    ).run()


def test_scalings_mean_what_they_say() -> None:
    def check(case: tuple[str, float]) -> None:
        text, size = case
        if is_scaling(text) and not math.isclose(read_scaling(text)[0], size, rel_tol=1e-12):
            raise WrongError(f"size: {text!r} is {float(read_scaling(text)[0])}, not {size}")

    Fuzz(name="right scalings", count=600, draw=_right, check=check).run()


def _record() -> Record:
    return Record(time=_TIME, position=np.sin(20 * _TIME), control=np.cos(20 * _TIME))


def _number(rng: np.random.Generator) -> float | None:
    odd = (None, math.nan, math.inf, -math.inf, 0.0, -1.0, 1e300, 0.2, 0.399)
    return one_of(rng, odd) if rng.random() < 0.4 else float(rng.uniform(-0.1, 0.5))


def test_windows_hold_the_samples_between_their_times() -> None:
    record = _record()

    def check(windows: tuple[tuple[float | None, float | None], ...]) -> None:
        found = record.windowed(*windows)
        ends = [(-math.inf if a is None else a, math.inf if b is None else b) for a, b in windows]
        inside = np.any([(a <= _TIME) & (b >= _TIME) for a, b in ends], axis=0) if ends else True
        if len(found) != np.sum(np.broadcast_to(inside, len(_TIME))):
            raise WrongError(f"samples: {len(found)} of {np.sum(inside)}")
        if len(found.spans) > max(len(windows), 1):
            raise WrongError(f"segments: {found.spans}")

    Fuzz(
        name="windows",
        count=400,
        draw=lambda rng: tuple(
            (_number(rng), _number(rng)) for _ in range(int(rng.integers(0, 4)))
        ),
        check=check,
    ).run()


_SHIFTS = (
    "1",
    "-3",
    "0",
    "1.5",
    "2ms",
    "-2 ms",
    "0.4s",
    "1e9",
    "nan",
    "inf",
    "x",
    "",
    "3 m",
    "1us",
)


def test_shifts_move_a_column_by_what_they_say_or_are_refused() -> None:
    record = _record()

    def check(case: tuple[str, str]) -> None:
        role, amount = case
        moved = record.shifted(**{role: amount})
        lost = len(record) - len(moved)
        if not np.array_equal(moved.time, _TIME[np.isin(_TIME, moved.time)]):
            raise WrongError("times: not those of the record")
        column = moved.channels()[role]
        first = np.flatnonzero(record.channels()[role] == column[0])
        place = np.flatnonzero(moved.time[0] == _TIME)
        if abs(int(place[0]) - int(first[0])) != lost:
            raise WrongError(f"shift: {amount!r} moved by {place - first} and lost {lost}")

    Fuzz(
        name="shifts",
        count=150,
        draw=lambda rng: (one_of(rng, ("control", "position", "speed")), one_of(rng, _SHIFTS)),
        check=check,
    ).run()


def test_texts_of_windows_and_of_known_values_are_read_or_refused() -> None:
    letters = [*"0123456789.,=+-±/ eEmx_", "+-", "nan", "inf", "..", "m_add"]

    def check(text: str) -> None:
        try:
            found = checked_windows(text)
        except UsageError:
            found = ()
        if any(not start < stop for start, stop in found):
            raise WrongError(f"window: {text!r} is {found}")
        told = read_known([text])
        for known in known_of(told, len(next(iter(told.values())))).values():
            if not all(math.isfinite(number) for pair in known for number in pair):
                raise WrongError(f"known: {text!r} is {known}")

    Fuzz(
        name="known and windows",
        count=1500,
        draw=lambda rng: (
            one_of(rng, ("m=1", "m_add=0,20+-0.01", "2..5", ""))
            + "".join(one_of(rng, letters) for _ in range(int(rng.integers(0, 7))))
        ),
        check=check,
    ).run()


def _rows(rng: np.random.Generator) -> dict[str, list[float]]:
    count = int(rng.integers(3, 9))
    return {name: [round(float(x), 6) for x in rng.normal(size=count)] for name in ("t", "q", "u")}


def _as_records(rows: dict[str, list[float]]) -> list[dict[str, float]]:
    return [dict(zip(rows, values, strict=True)) for values in zip(*rows.values(), strict=True)]


#: How a table is written as JSON or as lines, with the ending of its file.
_FORMS: dict[str, tuple[str, Callable[[dict[str, list[float]]], str]]] = {
    "arrays": (".json", json.dumps),
    "records": (".json", lambda rows: json.dumps(_as_records(rows))),
    "split": (
        ".json",
        lambda rows: json.dumps({"columns": [*rows], "data": [*zip(*rows.values(), strict=True)]}),
    ),
    "lines": (".jsonl", lambda rows: "\n".join(map(json.dumps, _as_records(rows)))),
}


@pytest.mark.parametrize("form", [*_FORMS])
def test_a_table_is_read_as_it_was_written_in_every_form(form: str, tmp_path: Path) -> None:
    ending, write = _FORMS[form]
    file = tmp_path / f"log{ending}"

    def check(rows: dict[str, list[float]]) -> None:
        file.write_text(write(rows))
        table = read_table(file)
        for name, values in rows.items():
            if table.columns[name].read().values.tolist() != values:
                raise WrongError(f"numbers: column {name} of {values}")

    Fuzz(
        name=f"tables as {form}",
        count=40,
        draw=_rows,
        check=check,
    ).run()


@pytest.mark.parametrize("form", [*_FORMS])
def test_a_damaged_table_is_read_or_refused_in_every_form(form: str, tmp_path: Path) -> None:
    ending, write = _FORMS[form]
    file = tmp_path / f"log{ending}"
    odd = [*'{}[]",:;', "null", "true", "1e999", "\\u0000", "\n", "NaN", "\x00"]

    def draw(rng: np.random.Generator) -> str:
        return spoilt(write(_rows(rng)), rng, odd)

    def check(text: str) -> None:
        file.write_text(text)
        readable_columns(file)

    Fuzz(
        name=f"damaged {form}",
        count=80,
        draw=draw,
        check=check,
    ).run()


def test_options_together_are_served_or_refused() -> None:
    """A scaling, windows, a shift and a repair of one log."""
    log = {"time": _TIME, "position": 1e3 * np.sin(20 * _TIME) + 0.5, "control": np.cos(20 * _TIME)}

    def draw(rng: np.random.Generator) -> dict[str, object]:
        return {
            "scaling": _right(rng)[0] if rng.random() < 0.5 else _text(rng),
            "windows": [(_number(rng), _number(rng)) for _ in range(int(rng.integers(0, 3)))],
            "shift": one_of(rng, _SHIFTS),
            "resample": one_of(rng, (None, "auto", 2000.0, 1.0, -1.0)),
        }

    def check(case: dict[str, object]) -> None:
        try:
            repairs = Repairs(shift={"control": case["shift"]}, resample=case["resample"])  # type: ignore[arg-type, dict-item]
        except AxisidError:
            repairs = Repairs()
        record = read_record(
            log,
            columns={"position": f"position:{case['scaling']}"},
            windows=case["windows"],  # type: ignore[arg-type]
            repairs=repairs,
        )
        if not all(np.all(np.isfinite(values)) for values in record.channels().values()):
            raise WrongError(f"not finite: {record}")

    Fuzz(name="options together", count=150, draw=draw, check=check).run()
