"""What a fleet has done, as it is done: a file of one line for each log."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import msgspec

from .row import FleetRow

#: In the folder of the results.
LEDGER = "fleet.jsonl"


def read_ledger(folder: Path) -> dict[str, FleetRow]:
    """The last row of each name; a line that was cut off as its run ended is passed over."""
    rows: dict[str, FleetRow] = {}
    try:
        content = (folder / LEDGER).read_bytes()
    except FileNotFoundError:
        return rows
    for line in content.splitlines():
        try:
            row = msgspec.json.decode(line, type=FleetRow)
        except (msgspec.DecodeError, UnicodeDecodeError):
            continue
        rows[row.name] = row
    return rows


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
