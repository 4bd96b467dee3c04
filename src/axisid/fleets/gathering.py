"""Results of a series: by name and folder, what is taken of each, what a ledger says of it."""

import math
import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import TypeAlias

from msgspec import structs
from scipy.special import ndtri

from axisid.estimation.choices import FIT
from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.presentation.result_files import SavedIdentification, SavedOutputFit, load_result
from axisid.support.errors import DataError, UsageError, first_of, quoted

from .ledger import LEDGER, FleetRow, fleet_value, read_ledger, strays
from .robust_centre import LARGEST

#: The rows of a folder's ledger, and what is broken in it.
Ledgers: TypeAlias = Callable[[Path], tuple[dict[str, FleetRow], str]]
#: A result of which there are several over time.
Saved: TypeAlias = SavedIdentification | SavedOutputFit

_DAY = 86_400.0  # s


def _point_of(saved: Saved, row: FleetRow | None, method: str | None) -> FleetRow:
    """A result as a row of a fleet, whatever wrote it, with what a fleet says of its log.

    Of a fit it has the outputs that were fitted, and the parameters that were free and that they
    show.
    """
    if isinstance(saved, SavedOutputFit):
        own = f"{FIT}{saved.output.replace(' and ', ',')}"
        if method not in (None, own):
            raise UsageError(
                f"{saved.file} is of a fit, which has no {quoted(method)} but {own}; leave it out.",
                code="trend",
            )
        parameters = {}
        for name, told in saved.document.parameters.items():
            value = fleet_value(saved.parameters[name])
            if told.at_bound:  # the deviation is by the 95 % interval to one side
                low, high = value.interval_95
                value = structs.replace(value, sd=float((high - low) / ndtri(INTERVAL_LEVEL.value)))
            if not told.fixed and math.isfinite(value.sd):
                parameters[name] = value
    else:
        estimate = saved.preferred if method is None else saved[method]
        own = estimate.method
        parameters = {n: fleet_value(value) for n, value in estimate.parameters.items()}
    return FleetRow(
        name=Path(saved.file).stem,
        log="" if row is None else row.log,
        axis=saved.name,
        status="ok",
        serial="" if row is None else row.serial,
        conditions={} if row is None else row.conditions,
        method=own,
        parameters=parameters,
        failing=tuple(check.name for check in saved.document.verdict if check.status == "fail"),
        signature=saved.document.signature,
    )


def place_of(point: FleetRow, by: str) -> float:
    """Where a point stands by a condition: a number, or the days of a date since 1970.

    Raises
    ------
    UsageError
        It has no such condition, or that is neither, or too large.
    """
    if by not in point.conditions:
        known = ", ".join(point.conditions) or "none"
        raise UsageError(
            f"nothing says of {point.name} what its {quoted(by)} is; it has {known}. A fleet's "
            "manifest says it, in a column of that name, and fleet.jsonl beside its results: copy "
            "that with them.",
            code="trend",
        )
    told = point.conditions[by]
    if isinstance(told, str):
        try:
            date = datetime.fromisoformat(told)
            # Without a zone it is taken as UTC, so that a place does not depend on the machine.
            return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp() / _DAY
        except ValueError:
            told = None
    if told is None or not abs(told) < LARGEST:
        raise UsageError(
            f"the {by} of {point.name} is {quoted(point.conditions[by])}; give numbers below "
            f"{LARGEST:g}, or dates such as 2026-03-01.",
            code="trend",
        )
    return float(told)


def points_of(results: object, method: str | None) -> tuple[list[FleetRow], list[str]]:
    """The points of results, in the order in which they are given, and what was left out.

    Raises
    ------
    UsageError
        There is none, something is none, or one has not the method.
    DataError
        A file cannot be read, or is no result.
    """
    listed = [results] if isinstance(results, (str, Path, Saved)) else results
    if not isinstance(listed, Iterable):
        raise UsageError(f"the results are {quoted(results)}; give files, or folders of them.")
    given = list(listed)
    ledgers: Ledgers = cache(read_ledger)  # each folder's once
    every = [saved for each in given for saved in _saved(each, ledgers)]
    files = Counter(Path(saved.file).resolve() for saved in every)
    if twice := [file for file, times in files.items() if times > 1]:
        raise UsageError(  # it would move limits and hide steps
            f"{quoted(str(twice[0]))} is given {files[twice[0]]} times; give each result once.",
            code="trend",
        )
    found = [
        _point_of(saved, ledgers(file.parent)[0].get(file.stem), method)
        for saved in every
        for file in [Path(saved.file)]
    ]
    folders = [
        Path(each) for each in given if isinstance(each, (str, Path)) and os.path.isdir(each)
    ]
    notes = [note for each in folders for note in _left_out(each, *ledgers(each), {*files})]
    if not found:
        raise UsageError(
            " ".join(
                (
                    f"there is no result in {quoted(results)}; give files that identify --json, "
                    "fit --json or a fleet wrote.",
                    *notes,
                )
            ),
            code="trend",
        )
    return found, notes


def _saved(given: object, ledgers: Ledgers) -> Iterator[Saved]:
    if isinstance(given, Saved):
        yield given
        return
    if not isinstance(given, (str, Path)):
        raise UsageError(f"a result is {quoted(given)}; give a file, a folder or load_result(...).")
    files = [given]
    if os.path.isdir(given):
        done, _ = ledgers(Path(given))
        kept = last_results(done.values())
        # What a fleet did not write in its folder may be anything.
        files = [f for f in sorted(Path(given).glob("*.json")) if not done or f.stem in kept]
    for file in files:
        found = load_result(file)
        if not isinstance(found, Saved):
            raise DataError(
                f"{file} is of a study, and a trend is of results of identify and of fit; leave it "
                "out.",
                code="trend",
            )
        yield found


def _left_out(
    folder: Path, rows: dict[str, FleetRow], broken: str, named: set[Path]
) -> Iterator[str]:
    """What is said of the results of a folder that its ledger has not."""
    left = [
        name for name in strays(folder, rows) if (folder / f"{name}.json").resolve() not in named
    ]
    if not rows and broken:
        yield f"{broken}: serial numbers and conditions are not known."
    elif rows and left:
        of = "1 result is" if len(left) == 1 else f"{len(left)} results are"
        why = f" {broken}." if broken else ""
        yield (
            f"{of} left out that {folder / LEDGER} has no line of: {first_of(left)}.{why} Give the "
            "files by name, or identify the logs again with axisid fleet --resume."
        )


def last_results(rows: Iterable[FleetRow]) -> set[str]:
    """Names of the results that are the last of their log, axis and columns.

    Of what failed since there is none.
    """
    last = {(row.log, row.axis, *sorted(row.columns.items())): row for row in rows}
    return {row.name for row in last.values() if row.has_result}
