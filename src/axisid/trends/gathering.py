"""Results by name and folder, with what a fleet's ledger says of them."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from axisid.fleets import FleetRow, Ledger, read_ledger, strays
from axisid.presentation.saved import load_result
from axisid.support.errors import DataError, UsageError
from axisid.support.user_values import first_of, quoted

from .point import Point, Saved, point_of

_RESULTS = "*.json"


@dataclass(frozen=True, slots=True)
class Ledgers:
    """The ledgers of folders, each read once."""

    read: dict[Path, Ledger] = field(default_factory=dict)

    def of(self, folder: Path) -> Ledger:
        """The ledger of a folder."""
        if folder not in self.read:
            self.read[folder] = read_ledger(folder)
        return self.read[folder]

    def row(self, saved: Saved) -> FleetRow | None:
        """What a fleet says of a result's log."""
        file = Path(saved.file)
        return self.of(file.parent).rows.get(file.stem)


def points_of(results: object, method: str | None) -> tuple[list[Point], list[str]]:
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
    given, ledgers = list(listed), Ledgers()
    every = [saved for each in given for saved in _saved(each, ledgers)]
    _check_once(every)
    found = [point_of(saved, ledgers.row(saved), method) for saved in every]
    named = {Path(saved.file).resolve() for saved in every}
    notes = [note for each in given for note in _left_out(each, ledgers, named)]
    if not found:
        raise UsageError(
            " ".join(
                (
                    f"there is no result in {quoted(results)}; give files that identify --json, "
                    "fit --json or a fleet wrote.",
                    *notes,
                )
            ),
            code="no-results",
        )
    return found, notes


def _check_once(results: Sequence[Saved]) -> None:
    """A result that counts twice moves limits and hides steps."""
    files = Counter(Path(saved.file).resolve() for saved in results)
    if twice := [str(file) for file, times in files.items() if times > 1]:
        raise UsageError(
            f"{quoted(twice[0])} is given {files[Path(twice[0])]} times; give each result once.",
            code="result-twice",
        )


def _saved(given: object, ledgers: Ledgers) -> Iterator[Saved]:
    if isinstance(given, Saved):
        yield given
    elif not isinstance(given, (str, Path)):
        raise UsageError(f"a result is {quoted(given)}; give a file, a folder or load_result(...).")
    elif _is_folder(given):
        done = ledgers.of(Path(given)).rows
        files = sorted(Path(given).glob(_RESULTS))
        # What a fleet did not write in its folder may be anything.
        kept = last_results(done.values())
        yield from (_loaded(file) for file in files if not done or file.stem in kept)
    else:
        yield _loaded(given)


def _is_folder(given: str | Path) -> bool:
    """Whether it names a folder; what no name can be is told where it is read as a file."""
    try:
        return Path(given).is_dir()
    except OSError:
        return False


def _left_out(given: object, ledgers: Ledgers, named: set[Path]) -> Iterator[str]:
    """What is said of the results of a folder that its ledger has not."""
    if not isinstance(given, (str, Path)) or not _is_folder(given):
        return
    folder, ledger = Path(given), ledgers.of(Path(given))
    if not ledger.rows:
        if ledger.broken:
            yield f"{ledger.broken_text()}: serial numbers and conditions are not known."
        return
    unnamed = (
        n for n in strays(folder, ledger.rows) if (folder / f"{n}.json").resolve() not in named
    )
    if left := list(unnamed):
        of = "1 result is" if len(left) == 1 else f"{len(left)} results are"
        why = f" {ledger.broken_text()}." if ledger.broken else ""
        yield (
            f"{of} left out that {ledger.file} has no line of: {first_of(left)}.{why} Give the "
            "files by name, or identify the logs again with axisid fleet --resume."
        )


def last_results(rows: Iterable[FleetRow]) -> set[str]:
    """Names of the results that are the last of their log, axis and columns.

    Of what failed since there is none.
    """
    last = {(row.log, row.axis, *sorted(row.columns.items())): row for row in rows}
    return {row.name for row in last.values() if row.has_result}


def _loaded(file: str | Path) -> Saved:
    found = load_result(file)
    if not isinstance(found, Saved):
        raise DataError(
            f"{file} is of a study, and a trend is of results of identify and of fit; leave it "
            "out.",
            code="trend-of-study",
        )
    return found
