"""Ledger of a fleet: a file with one JSON line for each log, written during the run."""

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from filelock import FileLock, Timeout

from axisid.estimation.estimates import Value
from axisid.estimation.verdict_checks import Belief, Check, Checked
from axisid.presentation.result_files import JsonObject, about
from axisid.support.arrays import MaybeNan, from_json
from axisid.support.errors import DataError, UsageError
from axisid.support.files import read_regular, replace_file
from axisid.support.mappings import grouped
from axisid.support.missing import Missing
from axisid.support.wording import first_of

from .robust_statistics import LARGEST

_IN_RESULT = "see the result of the log"

Status = Literal["ok", "failed", "skipped"]
#: Name in the folder of the results.
LEDGER = "fleet.jsonl"
_LOCK_SECONDS = 60.0  # longest wait for other processes, each of which writes a few lines


class FleetValue(JsonObject, frozen=True, kw_only=True):
    """A parameter of one result."""

    value: Annotated[MaybeNan, about("Minus the bias of filter and noise, if it is known.")]
    sd: Annotated[MaybeNan, about("Standard error by the chosen covariance.")]
    interval_95: tuple[MaybeNan, MaybeNan]
    unit: str


class FleetRow(
    Checked, JsonObject, frozen=True, kw_only=True, tag_field="schema", tag="axisid.fleet/1"
):
    """One log of a fleet.

    Attributes
    ----------
    name : str
        Name of its result, without the ending.
    log, axis, serial, columns, conditions
        As in its `FleetItem`.
    status : {"ok", "failed", "skipped"}
        A skipped log already had a result from an earlier run.
    reason, code : str
        Reason of the failure: a sentence, and a code for programs. The codes ``time`` and
        ``killed`` are for logs that exceeded the time limit or ended their process.
    key : str
        Hash of the log's bytes, the axis and the options: equal keys give equal results.
    method : str
        Method whose estimates the verdict judges.
    parameters : mapping of str to FleetValue
    covariance : matrix
        Covariance of the parameters, (p, p), in their order.
    failing : tuple of str
        Checks that fail, most severe first.
    unchecked : tuple of str
        Checks of the result's assumptions that could not be made.
    doubt : str
        Sentence of the most severe failed check. If no check fails, the reason why the first check
        in `unchecked` could not be made.
    seconds : float
        CPU time.
    """

    name: str
    log: str
    axis: str
    serial: str = ""
    columns: Mapping[str, str] = {}
    conditions: Mapping[str, str | float | None] = {}  # a number that is not finite is read as None
    status: Status
    reason: str = ""
    code: str = ""
    key: str = ""
    signature: str = ""
    method: str = ""
    parameters: Mapping[str, FleetValue] = {}
    covariance: tuple[tuple[MaybeNan, ...], ...] = ()
    failing: tuple[str, ...] = ()
    unchecked: tuple[str, ...] = ()
    doubt: str = ""
    seconds: float = 0.0

    @property
    def has_result(self) -> bool:
        """Return True if there is a result, from this run or an earlier one."""
        return self.status != "failed"

    @property
    def checks(self) -> tuple[Check, ...]:
        """Return the failed checks, most severe first, and the checks not evaluated.

        Only the first check has its finding; the result file contains the findings of all checks.
        """
        if not self.has_result:
            return (Check.unless("result", self.reason or "it has no result"),)
        said = (self.doubt or _IN_RESULT, *[_IN_RESULT] * len(self.failing))
        unmade = Missing(_IN_RESULT if self.failing else said[0])
        return (
            *map(Check.unless, self.failing, said),
            *(Check.not_evaluated(name, unmade) for name in self.unchecked),
        )

    @property
    def verdict(self) -> Belief | Literal[""]:
        """Return the belief in the values; empty without a result."""
        return self.belief if self.has_result else ""

    @property
    def is_comparable(self) -> bool:
        """Return True if values, standard errors and covariance are small enough to be squared."""
        own = ((each.value, each.sd) for each in self.parameters.values())
        return all(abs(each) < LARGEST for each in chain(*own, *self.covariance))


def unchecked_of(rows: Iterable[FleetRow], of: str = "") -> tuple[Check, ...]:
    """Return each check that could not be made in one or more rows; its reason names the rows.

    Parameters
    ----------
    rows : iterable of FleetRow
    of : str
        Beginning of the reason, such as the name of a series with a colon.
    """
    found = grouped((name, row.name) for row in rows for name in row.unchecked)
    return tuple(
        Check.not_evaluated(name, Missing(f"{of}the check was not possible in {first_of(names)}"))
        for name, names in found.items()
    )


def fleet_value(value: Value) -> FleetValue:
    """Return a value minus its bias, with standard error and interval by its chosen covariance."""
    low, high = map(float, value.interval)
    return FleetValue(
        value=float(value.corrected),
        sd=float(value.deviation),
        interval_95=(low, high),
        unit=value.unit,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Ledger:
    """The rows of a folder's ledger, by the name of the result.

    Attributes
    ----------
    last : mapping of str to FleetRow
        The last row of each name.
    results : mapping of str to FleetRow
        The last row with a result of each name, which belongs to the result file. If a later
        identification failed, `last` has its row.
    broken : str
        Text on lines that are not JSON, with their numbers; empty if there are none. A line may
        have been cut off when its run was interrupted.
    """

    last: Mapping[str, FleetRow]
    results: Mapping[str, FleetRow]
    broken: str


def read_ledger(folder: Path) -> Ledger:
    """Return the ledger of a folder; without a file it has no rows.

    Raises
    ------
    DataError
        A line is JSON but not a row.
    """
    file = folder / LEDGER
    last: dict[str, FleetRow] = {}
    results: dict[str, FleetRow] = {}
    broken: list[str] = []
    try:
        content = read_regular(file)
    except FileNotFoundError:
        content = b""
    for number, line in enumerate(content.splitlines(), 1):
        if not line.strip():
            continue
        try:
            row = msgspec.convert(msgspec.json.decode(line), FleetRow, dec_hook=from_json)
        except msgspec.ValidationError as error:
            raise DataError(
                f"{file}: line {number} is not a row of a fleet ({error}). Delete the line, or "
                "choose another folder for the results.",
                code="fleet",
            ) from error
        except (msgspec.DecodeError, UnicodeDecodeError):
            broken.append(str(number))
            continue
        last.pop(row.name, None)
        last[row.name] = row
        if row.has_result:
            results.pop(row.name, None)
            results[row.name] = row
    lines = "1 line" if len(broken) == 1 else f"{len(broken)} lines"
    text = f"{lines} of {file} cannot be read (line {first_of(broken)})" if broken else ""
    return Ledger(last=last, results=results, broken=text)


def write_rows(folder: Path, rows: Iterable[FleetRow]) -> None:
    """Append rows to the ledger of a folder: all of them, or none.

    The rows are in the file when the function returns, each on its own line, even if the last line
    of the file was cut off. Processes that write the same ledger wait for one another.

    Raises
    ------
    UsageError
        The file system refuses, or another process does not release the ledger; the ledger is
        unchanged.
    """
    place = folder / LEDGER
    lines = b"".join(msgspec.json.encode(row) + b"\n" for row in rows)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with _locked(place):
            _append(place, lines)
    except OSError as error:
        raise UsageError(f"{place} cannot be written: {error.strerror}.", code="file") from error


def _append(place: Path, lines: bytes) -> None:
    """Append lines to a file, which may end within a line; restore the file if this fails."""
    if not place.exists():
        replace_file(place, lines)
        return
    whole = place.stat().st_size
    try:
        with place.open("a+b") as file:
            file.seek(max(whole - 1, 0))
            file.write(lines if file.read() in b"\n" else b"\n" + lines)
    except OSError:
        with suppress(OSError):
            os.truncate(place, whole)
        raise


@contextmanager
def _locked(place: Path) -> Iterator[None]:
    """Lock a file against other processes within the context, if the file system has locks.

    Raises
    ------
    UsageError
        Another process holds the lock for too long.
    OSError
        The lock cannot be made.
    """
    lock = FileLock(place.with_name(f".{place.name}.lock"), timeout=_LOCK_SECONDS)
    has_locks = True
    try:
        lock.acquire()
    except Timeout as error:
        raise UsageError(
            f"{place} cannot be written: another process has locked it for {_LOCK_SECONDS:g} s. "
            "End that process, or choose another folder for the results.",
            code="file",
        ) from error
    except NotImplementedError:
        has_locks = False
    try:
        yield
    finally:
        if has_locks:
            lock.release()
