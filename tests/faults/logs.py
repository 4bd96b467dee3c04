"""Faults of logs as files: what cannot be read, or not as it stands."""

from pathlib import Path

from tests.faults.fault import Fault, Misuse


def _missing(folder: Path) -> list[object]:
    return ["identify", "emps2015", folder / "absent.csv"]


FAULTS: tuple[Fault, ...] = (
    Fault(name="a log that is not there", make=_missing, code=3, says="cannot be read"),
)
MISUSES: tuple[Misuse, ...] = ()
