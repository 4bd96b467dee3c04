"""What a fleet has done, as it is done: a file of one line for each log."""

import math
from collections.abc import Container, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import msgspec

from axisid.support.errors import DataError
from axisid.support.user_values import first_of

from .row import FleetRow

#: In the folder of the results.
LEDGER = "fleet.jsonl"
_RESULTS = ("axisid.identification/", "axisid.fit/")  # schemas


@dataclass(frozen=True, slots=True, kw_only=True)
class Ledger:
    """What a folder's ledger says.

    Attributes
    ----------
    file : Path
    rows : dict of str to FleetRow
        The last one of each name, in the order in which they were written.
    broken : tuple of int
        Numbers of the lines that are no JSON, from 1.
    """

    file: Path
    rows: dict[str, FleetRow] = field(default_factory=dict)
    broken: tuple[int, ...] = ()

    def broken_text(self) -> str:
        """How many lines are broken, and which; empty where none is."""
        if not self.broken:
            return ""
        lines = "1 line" if len(self.broken) == 1 else f"{len(self.broken)} lines"
        return f"{lines} of {self.file} cannot be read ({first_of(list(map(str, self.broken)))})"


def read_ledger(folder: Path) -> Ledger:
    """The ledger of a folder; without rows where there is none.

    A line may have been cut off as its run ended.

    Raises
    ------
    DataError
        A line is JSON and no row.
    """
    file = folder / LEDGER
    rows: dict[str, FleetRow] = {}
    broken: list[int] = []
    try:
        content = file.read_bytes()
    except FileNotFoundError:
        return Ledger(file=file)
    for number, line in enumerate(content.splitlines(), 1):
        if not line.strip():
            continue
        try:
            row = _row(line)
        except msgspec.ValidationError as error:
            raise DataError(
                f"{file}: line {number} is no row of a fleet ({error}); take it out, or identify "
                "the logs anew.",
                code="fleet-ledger-line",
            ) from error
        except (msgspec.DecodeError, UnicodeDecodeError):
            broken.append(number)
            continue
        rows.pop(row.name, None)
        rows[row.name] = row
    return Ledger(file=file, rows=rows, broken=tuple(broken))


def strays(folder: Path, names: Container[str]) -> list[str]:
    """Names of the results in a folder that are not among those that are known, in their order."""
    files = sorted(file for file in folder.glob("*.json") if file.stem not in names)
    return [file.stem for file in files if _is_result(file)]


def _is_result(file: Path) -> bool:
    """Whether it is whole JSON of what a log may have as its result."""
    try:
        return msgspec.json.decode(file.read_bytes(), type=_Anything).schema.startswith(_RESULTS)
    except (OSError, msgspec.MsgspecError, UnicodeDecodeError):
        return False


class _Anything(msgspec.Struct):
    """JSON of some schema."""

    schema: str


def _row(line: bytes) -> FleetRow:
    try:
        return msgspec.json.decode(line, type=FleetRow)
    except msgspec.ValidationError:
        return msgspec.convert(_numbers(msgspec.json.decode(line)), FleetRow)


def _numbers(told: Any) -> Any:
    """What is told, with a number in place of each null: JSON writes so what is not finite."""
    if isinstance(told, dict):
        return {name: _numbers(value) for name, value in told.items()}
    if isinstance(told, list):
        return [_numbers(value) for value in told]
    return math.nan if told is None else told


@contextmanager
def ledger_of(folder: Path, *, anew: bool) -> Iterator[BinaryIO]:
    """The ledger to write to, without what it held, or after that."""
    folder.mkdir(parents=True, exist_ok=True)
    place = folder / LEDGER
    cut = not anew and place.is_file() and place.read_bytes()[-1:] not in b"\n"
    with place.open("wb" if anew else "ab") as file:
        if cut:
            file.write(b"\n")
        yield file


def write_row(file: BinaryIO, row: FleetRow) -> None:
    """Add a row, which is on its way to the disk when this returns."""
    file.write(msgspec.json.encode(row) + b"\n")
    file.flush()
