"""Logs by name, pattern, folder or manifest."""

import glob
from collections.abc import Iterable, Iterator
from pathlib import Path

from axisid.estimation.logs import log_endings
from axisid.support.errors import UsageError
from axisid.support.user_values import quoted

from .item import FleetItem
from .manifest import is_manifest, manifest_items

_RESULTS = ".json"  # a log's ending too
_FLEET = "fleet"  # ledger and table


def gather_items(
    logs: str | Path | FleetItem | Iterable[str | Path | FleetItem], out: Path
) -> list[FleetItem]:
    """Items of all that is named, each once, in their order.

    Parameters
    ----------
    logs : path, FleetItem or iterable of them
        Files, patterns, folders (with the folders in them), manifests.
    out : Path
        Folder of the results, whose files are no logs.

    Raises
    ------
    UsageError
        There is none, or something is no path.
    DataError
        A manifest cannot be read.
    """
    listed = [logs] if isinstance(logs, (str, Path, FleetItem)) else list(logs)
    found: dict[tuple[str, str], FleetItem] = {}
    for each in listed:
        for item in _items(each, out):
            found.setdefault((item.log, item.axis), item)
    if not found:
        said = " and ".join(map(str, listed))
        raise UsageError(f"there is no log in {said or 'nothing'}; name some.", code="no-logs")
    return list(found.values())


def _items(given: object, out: Path) -> Iterator[FleetItem]:
    if isinstance(given, FleetItem):
        yield given
        return
    if not isinstance(given, (str, Path)):
        raise UsageError(
            f"a log is {quoted(given)}; give a path, a pattern, a folder or a FleetItem.",
            code="fleet-log-type",
        )
    path = Path(given)
    if path.is_dir() and not (path / "metadata.yaml").is_file():  # that of a ROS 2 bag is one log
        yield from (FleetItem(log=str(file)) for file in _logs_in(path, out))
    elif path.is_file() and is_manifest(path):
        yield from manifest_items(path)
    elif not path.exists() and glob.has_magic(str(path)):
        files = sorted(glob.glob(str(path), recursive=True))
        yield from (FleetItem(log=file) for file in files if _may_be_log(Path(file), out))
    else:
        yield FleetItem(log=str(path))


def _logs_in(folder: Path, out: Path) -> list[Path]:
    endings = log_endings()
    return sorted(
        file
        for file in folder.rglob("*")
        if file.suffix.lower() in endings and _may_be_log(file, out) and not is_manifest(file)
    )


def _may_be_log(file: Path, out: Path) -> bool:
    """Whether it is no hidden file, and nothing that a fleet wrote."""
    own = out.resolve() == file.parent.resolve() and (
        file.suffix == _RESULTS or file.stem == _FLEET
    )
    return file.is_file() and not file.name.startswith(".") and not own
