"""Logs of twins as files: one, or a folder of many with a manifest of what is true."""

import csv
import io
import os
import tempfile
from pathlib import Path

from axisid.codegen.artefacts import replace_file, write_for_user
from axisid.support.errors import UsageError
from axisid.support.files.new_folder import kept_if_filled
from axisid.support.progress import Progress, with_progress

from .log_file import ENDINGS, twin_content
from .machines import TwinMachines

#: In the folder of the logs; what `fleet` takes.
MANIFEST = "manifest.csv"


def write_twin(machines: TwinMachines, file: str | Path) -> Path:
    """Write the log of one machine, whole or not at all.

    Parameters
    ----------
    machines : TwinMachines
        Of which the first is taken.
    file : str or Path
        Ends in ``.csv`` or ``.parquet``, which needs pyarrow.

    Raises
    ------
    UsageError
        The ending is another one, or the file cannot be written.
    AxisidError
        The twin cannot be simulated, or its axis's columns not be written.
    """
    path = Path(file)
    _check_ending(path.suffix, str(path))
    content = twin_content(machines.record(0, 0), machines.axis.declared, path)
    return write_for_user(path, content)


def write_twins(
    machines: TwinMachines,
    folder: str | Path,
    *,
    axis: str = "",
    ending: str = ".csv",
    progress: Progress | None = None,
) -> Path:
    """Write a log of each machine on each day, and a manifest: all of them or none.

    Parameters
    ----------
    machines : TwinMachines
    folder : str or Path
        May be new.
    axis : str, optional
        What the manifest says of which axis they are: a name of the library, or its file.
    ending : str
        ``.csv`` or ``.parquet``.
    progress : callable, optional

    Returns
    -------
    Path
        Of the manifest: a row for each log with ``log``, ``axis``, ``serial``, of several days the
        ``date``, and every true value as ``true NAME [UNIT]``.

    Raises
    ------
    UsageError, AxisidError
        As `write_twin`; the folder is as it was.
    """
    place = Path(folder).resolve()
    _check_ending(ending, ending)
    try:
        with (
            kept_if_filled(place),
            tempfile.TemporaryDirectory(prefix=".twins-", dir=place) as made,
        ):
            names = _logs(machines, Path(made), ending, progress)
            rows = [_row(machines, name, place, axis, *at) for name, at in names.items()]
            for name in names:
                os.replace(Path(made, name), place / name)
        replace_file(place / MANIFEST, _table(rows))
    except OSError as error:
        raise UsageError(f"{folder} cannot be written to: {error.strerror}.") from error
    return Path(folder, MANIFEST)


def twin_files(machines: TwinMachines, ending: str) -> dict[str, str]:
    """What `write_twins` writes into its folder, and which kind of file each is."""
    logs = (_name(machines, ending, *at) for at in machines.each())
    return {MANIFEST: "twin-manifest", **dict.fromkeys(logs, "twin")}


def _check_ending(ending: str, given: str) -> None:
    if ending not in ENDINGS:
        raise UsageError(
            f"{given}: a twin's log is written to {' or '.join(ENDINGS)}; give a name with "
            "that ending.",
            code="twin-ending",
        )


def _name(machines: TwinMachines, ending: str, machine: int, day: int) -> str:
    parts = (machines.axis.axis.name, machines.serial(machine), machines.date(day))
    return "-".join(filter(None, parts)) + ending


def _logs(
    machines: TwinMachines, folder: Path, ending: str, progress: Progress | None
) -> dict[str, tuple[int, int]]:
    """Write the logs; their machines and days by name."""
    places = {_name(machines, ending, *at): at for at in machines.each()}
    for name in with_progress(places, progress, lambda name: f"simulating {name}"):
        record = machines.record(*places[name])
        replace_file(folder / name, twin_content(record, machines.axis.declared, folder / name))
    return places


def _row(
    machines: TwinMachines, name: str, folder: Path, axis: str, machine: int, day: int
) -> dict[str, object]:
    dated = {"date": machines.date(day)} if machines.days > 1 else {}
    units = {p.name: p.unit for p in machines.axis.declared.parameters}
    truth = machines.truth(machine, day)
    true = {f"true {name} [{units[name]}]": value for name, value in truth.items()}
    return {
        "log": name,
        "axis": _from(folder, axis),
        "serial": machines.serial(machine),
        **dated,
        **true,
    }


def _from(folder: Path, axis: str) -> str:
    """What names an axis, a file as from a folder."""
    head, python, variable = axis.partition(".py:")
    file = Path(f"{head}.py" if python else axis)
    if file.suffix not in (".py", ".toml"):
        return axis
    try:
        told = os.path.relpath(file.resolve(), folder)
    except ValueError:  # on another drive of Windows
        told = str(file.resolve())
    return f"{told}:{variable}" if python else told


def _table(rows: list[dict[str, object]]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
