"""Logs by name, pattern, folder or manifest."""

import glob
import os
from collections.abc import Hashable, Iterable, Iterator, Mapping
from pathlib import Path

from axisid.estimation.logs import log_endings
from axisid.support.errors import DataError, UsageError
from axisid.support.user_values import quoted

from .item import FleetItem
from .manifest import check_no_manifest, is_manifest, manifest_items

_RESULTS = ".json"  # a log's ending too
_FLEET = "fleet"  # ledger and table
_BY_PATH = ""  # where nothing but the path of a log is told


def gather_items(
    logs: str | Path | FleetItem | Iterable[str | Path | FleetItem], out: Path
) -> list[FleetItem]:
    """Items of all that is named, each once, in their order.

    A log is there several times where other axes or columns are told of it, as of a file of two
    machines. Where a manifest or an item tells what it is, its bare path adds nothing.

    Parameters
    ----------
    logs : path, FleetItem or iterable of them
        Files, patterns, folders (with the folders and manifests in them), manifests.
    out : Path
        Folder of the results, whose files are no logs.

    Raises
    ------
    UsageError
        There is none, or something is no path.
    DataError
        A manifest cannot be read, or the same columns of a log are told to be of another machine.
    """
    if not isinstance(logs, (str, Path, FleetItem, Iterable)):
        raise UsageError(
            f"the logs are {quoted(logs)}; give files, patterns, folders or manifests.",
            code="fleet-logs",
        )
    listed = [logs] if isinstance(logs, (str, Path, FleetItem)) else list(logs)
    told = [each for place, one in enumerate(listed, 1) for each in _items(one, out, place)]
    described = {_place(item) for item, by in told if by != _BY_PATH}
    found: dict[Hashable, tuple[FleetItem, str]] = {}
    for item, by in told:
        if by == _BY_PATH and _place(item) in described:
            continue
        before = found.setdefault((_place(item), item.axis, item.columns_text), (item, by))
        _check_alike(before, (item, by))
    if not found:
        said = " and ".join(map(str, listed))
        raise UsageError(f"there is no log in {said or 'nothing'}; name some.", code="no-logs")
    return [item for item, _ in found.values()]


def _place(item: FleetItem) -> str:
    """Where a log is, however it is named."""
    return os.path.abspath(item.log)


def _check_alike(before: tuple[FleetItem, str], again: tuple[FleetItem, str]) -> None:
    """Refuse what tells other things of the same columns of a log: one of the two is wrong."""
    (item, by), (other, by_other) = before, again
    for what in ("serial", "conditions"):
        first, second = getattr(item, what), getattr(other, what)
        if first != second:
            raise DataError(
                f"{by} and {by_other} tell other {what} of {item.log}: {_said(first)} and "
                f"{_said(second)}. Leave one out, or give each its own columns where the log is of "
                "several machines.",
                code="fleet-log-twice",
            )


def _said(told: object) -> str:
    """A serial number or conditions, as they are told."""
    pairs = told.items() if isinstance(told, Mapping) else ()
    text = ", ".join(f"{k}={v}" for k, v in pairs) if pairs else str(told or "none")
    return quoted(text) if text != "none" else text


def _items(given: object, out: Path, place: int) -> Iterator[tuple[FleetItem, str]]:
    """Items, each with who tells of it."""
    if isinstance(given, FleetItem):
        yield given, f"item {place}"
        return
    if not isinstance(given, (str, Path)):
        raise UsageError(
            f"a log is {quoted(given)}; give a path, a pattern, a folder or a FleetItem.",
            code="fleet-log-type",
        )
    path = Path(given)
    if path.is_dir() and not (path / "metadata.yaml").is_file():  # that of a ROS 2 bag is one log
        for file in _logs_in(path, out):
            if is_manifest(file):
                yield from _told_by(file)
            else:
                yield FleetItem(log=str(file)), _BY_PATH
    elif not path.exists() and glob.has_magic(str(path)):
        for name in sorted(glob.glob(str(path), recursive=True)):
            if _may_be_log(Path(name), out):
                yield from _items_of(Path(name))
    else:
        yield from _items_of(path)


def _items_of(file: Path) -> Iterator[tuple[FleetItem, str]]:
    """The item of a log, or those of a manifest."""
    if not file.is_file() or not is_manifest(file):
        check_no_manifest(file)
        yield FleetItem(log=str(file)), _BY_PATH
        return
    yield from _told_by(file)


def _told_by(manifest: Path) -> Iterator[tuple[FleetItem, str]]:
    for number, item in enumerate(manifest_items(manifest), 1):
        yield item, f"{manifest}, row {number},"


def _logs_in(folder: Path, out: Path) -> list[Path]:
    endings = log_endings()
    return sorted(
        file
        for file in folder.rglob("*")
        if file.suffix.lower() in endings and _may_be_log(file, out)
    )


def _may_be_log(file: Path, out: Path) -> bool:
    """Whether it is no hidden file, and nothing that a fleet wrote; a link to nothing may be."""
    own = out.resolve() == file.parent.resolve() and (
        file.suffix == _RESULTS or file.stem == _FLEET
    )
    return (file.is_file() or not file.exists()) and not file.name.startswith(".") and not own
