"""Logs as text, in any dialect and with anything wrong in them, are read right or refused."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.fuzz.cases import Fuzz, WrongError, one_of, readable_columns, spoilt

#: What a cell that is no number holds; it may be refused, or be no number, but no other.
JUNK = (
    *("-", "--", "n/a", "#N/A", "TRUE", "on", "x", "1_000", "0x10", "1 234", "1'234", "12:00"),
    *("\u0661\u0662", "\u22125", "\u00bd", "1e", "e5", "1e5e3", "1..5", "++1", "1-", "5 V", "$3"),
    *(
        "1.234,5",
        "1,234.5",
        "1,234,567",
        "12.5.",
        "=A1",
        "()",
        "None",
        "null",
        "inff",
        "0b1",
        "\u221e",
    ),
)
#: Numbers at their limits, as text; `float` knows what they are.
EXTREME = (
    *("nan", "NaN", "-nan", "inf", "-inf", "Infinity", "1e308", "-1.7976931348623157e308", "1e400"),
    *(
        "5e-324",
        "1e-400",
        "-0.0",
        "0",
        "-0",
        "+1",
        "007",
        "1e+05",
        "1E5",
        "123456789012345678901234567890",
    ),
    *("0.1000000000000000055511151231257827", "9007199254740993", "1e22", "1e23"),
)
_NAMES = ("t", "q", "ref", "u", "tau", "speed", "Temp", "Zähler", "axis.pos", "flag", "q[1]", "n")
_UNITS = ("s", "mm", "mm", "V", "Nm", "rad/s", "N", "", "m", "", "rad", "1/min")
_PREAMBLES = (
    *("Datum: 2026-02-01", "Device;X1", "rate 1000", "42", "Recorder v1.2, build 7", "a\tb", "---"),
    *("# exported by a tool", "Sampling: 1,0 kHz", "1;2", '"quoted, line"', "[Header]", "x=1"),
)
_ENCODINGS = ("utf-8", "utf-8", "utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252")
_SEPARATORS = (";", "\t", ",", "|", " ")
_FORMS = ("{!r}", "{:.6f}", "{:.9e}", "{:g}", "{:+.5f}", "{:12.6f}", "{:.3f}")


@dataclass(frozen=True, slots=True, kw_only=True)
class TextLog:
    """A table, how it is written, and what was done to its text.

    Attributes
    ----------
    names, units : tuple of str
    rows : tuple of tuple of str
        Cells with a decimal point; of stamps as they are.
    separator : str
    comma : bool
        Decimal comma.
    unit_row : str
        ``none``, ``row``, or ``header`` for units in the names' brackets.
    preamble : tuple of str
    quoted, trailing, spaced, comments, blank_lines : bool
    encoding, newline : str
    stamped : bool
        The first column holds time stamps, of so many seconds as `seconds`.
    cut : int
        Letters missing at the end, before the last cell, which is missing too.
    odd : tuple of (int, str)
        Lines put in: where, and what.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    separator: str
    comma: bool
    unit_row: str
    preamble: tuple[str, ...]
    quoted: bool
    trailing: bool
    spaced: bool
    comments: bool
    blank_lines: bool
    encoding: str
    newline: str
    seconds: tuple[float, ...] = ()
    cut: int = 0
    odd: tuple[tuple[int, str], ...] = field(default_factory=tuple)

    @property
    def content(self) -> bytes:
        """The bytes of the file."""
        *lines, last = self._lines()
        if self.cut:
            # The last cell may end early and still be a number; what is before it may not.
            head = self._line([self._number(cell) for cell in self.rows[-1][:-1]])
            last = head[: max(len(head) - self.cut, 0)]
        ending = "" if self.cut else self.newline
        text = self.newline.join([*lines, last]) + ending
        return text.encode(self.encoding, errors="replace")

    def _lines(self) -> Iterator[str]:
        yield from self.preamble
        brackets = self.unit_row == "header"
        yield self._line(
            [
                f"{name} [{unit}]" if brackets and unit else name
                for name, unit in zip(self.names, self.units, strict=True)
            ]
        )
        if self.unit_row == "row":
            yield self._line([unit or "-" for unit in self.units])
        odd = dict(self.odd)
        for k, row in enumerate(self.rows):
            if k in odd:
                yield odd[k]
            if self.comments and k % 7 == 3:
                yield "# remark"
            if self.blank_lines and k % 5 == 2:
                yield ""
            yield self._line([self._number(cell) for cell in row])

    def _number(self, cell: str) -> str:
        return cell.replace(".", ",") if self.comma and _is_plain(cell) else cell

    def _line(self, cells: list[str]) -> str:
        quoted = [f'"{cell}"' for cell in cells] if self.quoted else cells
        between = (
            f" {self.separator} " if self.spaced and self.separator.strip() else self.separator
        )
        return between.join(quoted) + (self.separator if self.trailing else "")

    def value(self, row: int, column: int) -> float | None:
        """What a cell says; None where it is neither a number nor empty."""
        cell = self.rows[row][column]
        if self.seconds and column == 0:
            return self.seconds[row]
        if not cell.strip():
            return math.nan
        return float(cell) if _is_plain(cell) else None


def _is_plain(cell: str) -> bool:
    """Whether a cell is a number in the dialect's own hand, written with a decimal point."""
    if not cell.isascii() or "_" in cell:
        return False
    try:
        float(cell)
    except ValueError:
        return False
    return True


def text_log(rng: np.random.Generator) -> TextLog:
    """Draw a log that is in order."""
    width, height = int(rng.integers(2, 8)), int(rng.integers(3, 60))
    chosen = rng.permutation(len(_NAMES))[:width]
    separator = one_of(rng, _SEPARATORS)
    comma = separator != "," and bool(rng.random() < 0.35)
    return TextLog(
        names=tuple(_NAMES[k] for k in chosen),
        units=tuple(_UNITS[k] for k in chosen),
        rows=tuple(zip(*(_column(rng, height) for _ in range(width)), strict=True)),
        separator=separator,
        comma=comma,
        unit_row=one_of(rng, ("none", "none", "row", "header")),
        preamble=tuple(one_of(rng, _PREAMBLES) for _ in range(int(rng.choice([0, 0, 0, 1, 2, 5])))),
        quoted=bool(rng.random() < 0.1),
        trailing=separator.strip() != "" and bool(rng.random() < 0.1),
        spaced=bool(rng.random() < 0.15),
        comments=bool(rng.random() < 0.1),
        blank_lines=bool(rng.random() < 0.1),
        encoding=one_of(rng, _ENCODINGS),
        newline=one_of(rng, ("\n", "\n", "\r\n", "\r")),
    )


def _column(rng: np.random.Generator, height: int) -> list[str]:
    """Cells of a column: a clock, a motion, whole numbers, or any numbers."""
    kind, form = int(rng.integers(5)), one_of(rng, _FORMS)
    if kind == 0:
        values = float(10 ** rng.uniform(-4, 0)) * np.arange(height)
    elif kind == 1:
        values = float(10 ** rng.uniform(-6, 6)) * np.cumsum(rng.normal(size=height))
    elif kind == 2:
        return [str(whole) for whole in rng.integers(-5, 2000, height).tolist()]
    elif kind == 3:
        values = np.repeat(rng.normal(size=height), 3)[:height]
    else:
        values = rng.normal(size=height) * 10 ** rng.uniform(-12, 12, height)
    return [form.format(value) for value in values.tolist()]


def stamped(log: TextLog, rng: np.random.Generator) -> TextLog:
    """Time stamps in the first column."""
    steps = rng.integers(1, 400_000, len(log.rows)).cumsum()  # us
    begin = int(rng.integers(0, 86_400)) * 1_000_000
    form = one_of(rng, ("2026-02-{d:02d} {t}", "2026-02-{d:02d}T{t}Z", "{d}.2.2026 {t}", "{t}"))
    cells = []
    for step in (begin + steps - steps[0]).tolist():
        day, rest = divmod(step, 86_400_000_000)
        seconds, micro = divmod(rest, 1_000_000)
        clock = f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}.{micro:06d}"
        cells.append(form.format(d=day + 1, t=clock))
    rows = tuple((cell, *row[1:]) for cell, row in zip(cells, log.rows, strict=True))
    since = tuple(((steps - steps[0]) / 1e6).tolist())
    return replace(log, rows=rows, seconds=since, separator=";", quoted=False)


def with_cell(log: TextLog, rng: np.random.Generator, cells: tuple[str, ...]) -> TextLog:
    """Another text in one of the cells, but in those of stamps."""
    row = int(rng.integers(len(log.rows)))
    column = int(rng.integers(1 if log.seconds else 0, len(log.names)))
    cell = one_of(rng, cells)
    if log.separator in cell or (log.separator == " " and not cell):
        return log
    return _changed(log, row, column, cell)


def _changed(log: TextLog, row: int, column: int, cell: str) -> TextLog:
    cells = (*log.rows[row][:column], cell, *log.rows[row][column + 1 :])
    return replace(log, rows=(*log.rows[:row], cells, *log.rows[row + 1 :]))


def empty(log: TextLog, rng: np.random.Generator) -> TextLog:
    """Empty cells, as a column of a lower rate has."""
    for _ in range(int(rng.integers(1, 5))):
        fewer = with_cell(log, rng, ("",))
        # A line of separators alone is a blank one.
        log = fewer if all(any(map(str.strip, row)) for row in fewer.rows) else log
    return log


def thousands(log: TextLog, rng: np.random.Generator) -> TextLog:
    """A column of large whole numbers, a comma between thousands."""
    if log.comma or log.separator in ", ":
        return log
    column = int(rng.integers(1, len(log.names)))
    for row in range(len(log.rows)):
        log = _changed(log, row, column, f"{int(rng.integers(1000, 10**7)):,}")
    return log


def ragged(log: TextLog, rng: np.random.Generator) -> TextLog:
    """A line of another width, which is no row of the table."""
    cells = log.rows[int(rng.integers(len(log.rows)))]
    line = log.separator.join(cells[:-1] if rng.random() < 0.5 else (*cells, "7"))
    where = int(rng.integers(1, len(log.rows)))
    alike = log.trailing or not line.strip(" \t;,|")  # as wide as the others, or blank
    return log if alike else replace(log, odd=((where, line),))


def cut(log: TextLog, rng: np.random.Generator) -> TextLog:
    """The end missing, from within the last line, but not from within its last cell alone."""
    return replace(log, cut=int(rng.integers(1, 30)), trailing=False)


CHANGES: tuple[Callable[[TextLog, np.random.Generator], TextLog], ...] = (
    stamped,
    partial(with_cell, cells=JUNK),
    partial(with_cell, cells=EXTREME),
    empty,
    thousands,
    ragged,
    cut,
)


def changed_log(rng: np.random.Generator) -> TextLog:
    """Draw a log, in order or with one or two things wrong in it."""
    log = text_log(rng)
    for _ in range(int(rng.choice([0, 1, 1, 2]))):
        log = one_of(rng, CHANGES)(log, rng)
    return log


def damaged(log: bytes, rng: np.random.Generator) -> str:
    """The bytes of a log, some of them lost, doubled or put in, as letters."""
    odd = ("\0", '"', "\n", ";", ",", "\xff", "e", "\x1a", chr(int(rng.integers(256))))
    return spoilt(log.decode("latin-1"), rng, odd, most=12)


def _compare(log: TextLog, name: str, column: int, values: np.ndarray) -> None:
    """Hold a column that was read against what was written."""
    if log.odd:
        raise WrongError(f"a line that is no row is passed over: column {name}")
    rows = len(log.rows)
    if len(values) not in ((rows, rows - 1) if log.cut else (rows,)):
        raise WrongError(f"rows: {len(values)} of {rows} in column {name}")
    for row, value in enumerate(values.tolist()):
        written = log.value(row, column)
        if log.cut and row == rows - 1 and math.isnan(value):
            continue
        if written is None:
            if not math.isnan(value):
                raise WrongError(f"junk: {log.rows[row][column]!r} is read as {value!r}")
            continue
        alike = value == written or (math.isnan(value) and math.isnan(written))
        close = bool(log.seconds) and column == 0 and abs(value - written) < 1e-6
        if not (alike or close):
            raise WrongError(f"number: {log.rows[row][column]!r} is read as {value!r}")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "log.csv"


@pytest.mark.slow
def test_what_is_read_is_what_was_written(file: Path) -> None:
    def check(log: TextLog) -> None:
        places = {name: k for k, name in enumerate(log.names)}
        file.write_bytes(log.content)
        for name, values in readable_columns(file).items():
            if name not in places:
                raise WrongError(f"name: a column {name!r} that was not written")
            _compare(log, name, places[name], values)

    Fuzz(
        name="text logs",
        count=600,
        draw=changed_log,
        check=check,
        shown=lambda log: repr(log.content),
    ).run()


@pytest.mark.slow
def test_damaged_bytes_are_read_or_refused(file: Path) -> None:
    def check(text: str) -> None:
        file.write_bytes(text.encode("latin-1"))
        readable_columns(file)

    Fuzz(
        name="damaged logs",
        count=600,
        draw=lambda rng: damaged(changed_log(rng).content, rng),
        check=check,
        shown=lambda text: repr(text.encode("latin-1")),
    ).run()
