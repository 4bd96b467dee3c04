"""What a fleet has done, as it is done: a file of one line for each log."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import msgspec

from axisid.support.errors import DataError

from .row import FleetRow

#: In the folder of the results.
LEDGER = "fleet.jsonl"


def read_ledger(folder: Path) -> dict[str, FleetRow]:
    """The last row of each name, in the order in which they were written.

    A line that was cut off as its run ended is passed over.

    Raises
    ------
    DataError
        A line is JSON and no row.
    """
    rows: dict[str, FleetRow] = {}
    try:
        content = (folder / LEDGER).read_bytes()
    except FileNotFoundError:
        return rows
    for number, line in enumerate(content.splitlines(), 1):
        try:
            row = _row(line)
        except msgspec.ValidationError as error:
            raise DataError(
                f"{folder / LEDGER}: line {number} is no row of a fleet ({error}); take it out, or "
                "identify the logs anew.",
                code="fleet-ledger-line",
            ) from error
        except (msgspec.DecodeError, UnicodeDecodeError):
            continue
        rows.pop(row.name, None)
        rows[row.name] = row
    return rows


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
    with (folder / LEDGER).open("wb" if anew else "ab") as file:
        if not anew and file.tell():
            file.write(b"\n")  # the last line may have been cut off
        yield file


def write_row(file: BinaryIO, row: FleetRow) -> None:
    """Add a row, which is on its way to the disk when this returns."""
    file.write(msgspec.json.encode(row) + b"\n")
    file.flush()
