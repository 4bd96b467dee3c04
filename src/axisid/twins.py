"""Logs of twins: of one machine, or of many machines whose true values scatter and drift.

A twin is a simulated machine with known true values.

In: an axis, a description of its twins. Out: logs that `read_record` reads without options, a
manifest with the true values. Knows nothing of the identification of a log, and of the command
line.
"""

import math
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import date, timedelta
from pathlib import Path

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.monte_carlo import drawn_twin, noise_of, twin_of
from axisid.estimation.noise_models import Chain
from axisid.estimation.records import Record
from axisid.estimation.records.columns import log_content
from axisid.estimation.simulation import twin_plan
from axisid.modeling.declaration import Axis
from axisid.support.checks import is_real, is_whole, refuse
from axisid.support.errors import UsageError
from axisid.support.files import axis_file, csv_text, replace_file, write_file
from axisid.support.progress import Progress, with_progress
from axisid.support.wording import quoted

_FIRST_DAY = date(2026, 1, 1)
_MOST = 1_000_000  # machines; the noise of machine i on day d has the number i + _MOST * d
_MOST_DAYS = 10_000
_VALUES = 100  # last part of the key of the random numbers for a machine's true values
#: Text in a log that identifies it as the log of a twin.
MARK = "axisid.twin/1"
#: Name of the manifest in the folder of the logs, which `fleet` reads.
MANIFEST = "manifest.csv"


@dataclass(frozen=True, slots=True, kw_only=True)
class TwinMachines:
    """Twins of one axis whose true values differ, each with one log per day.

    Attributes
    ----------
    axis : GeneratedAxis
        Axis that declares an experiment with true values.
    count, days : int
        Number of machines, and of days.
    scatter : mapping of str to float
        Relative standard deviation of a true value between machines, at most 1, by parameter. The
        entry ``""`` applies to all other parameters.
    drift : mapping of str to float
        Relative change of a true value per day, at most 1, by parameter. The true value must keep
        its sign until the last day.
    noise : Chain or None
        Noise of the measurements; None for the noise of the experiment.
    seed : int
        Seed of all random numbers. Further machines and days do not change existing logs.
    sample_period : float or None
        Sampling period of the logs, s; None for the period of the control law.

    Raises
    ------
    UsageError, ModelError
        An attribute is outside of its range, or names no parameter.
    """

    axis: GeneratedAxis
    count: int = 1
    days: int = 1
    scatter: Mapping[str, float] = field(default_factory=dict)
    drift: Mapping[str, float] = field(default_factory=dict)
    noise: Chain | None = None
    seed: int = 1
    sample_period: float | None = None

    def __post_init__(self) -> None:
        counts = (
            ("number of machines", self.count, 1, _MOST, f"from 1 to {_MOST}"),
            ("number of days", self.days, 1, _MOST_DAYS, f"from 1 to {_MOST_DAYS}"),
            ("seed", self.seed, 0, math.inf, "of 0 or more"),
        )
        refuse(
            UsageError,
            *(
                (
                    not (is_whole(given) and least <= given <= most),
                    f"the {what} of twins is {quoted(given)}. Give a whole number {span}",
                )
                for what, given, least, most, span in counts
            ),
            code="twin",
        )
        true = self.true_values
        # Each share with the true values to which it may apply, by parameter.
        shares = [("scatter", *each, {"": 1.0, **true}) for each in self.scatter.items()]
        shares += [("drift", *each, true) for each in self.drift.items()]
        for what, name, share, values in shares:
            is_share = is_real(share) and abs(share) <= 1 and (share >= 0 or what == "drift")
            refuse(
                UsageError,
                (
                    name not in values,
                    f"the axis has no parameter of this name. Give one of {', '.join(true)}",
                ),
                (not is_share, "give a share of the value, at most 1, such as 0.02 for 2 %"),
                (
                    is_share and not share * (self.days - 1) > -1,
                    f"the value reaches 0 by day {self.days}. Give a smaller share, or fewer days",
                ),
                (
                    is_share and share and not values.get(name),
                    "the true value is 0, so a share of it has no effect. Give another true value, "
                    "or omit this share",
                ),
                before=f"the {what} of {name or 'all'} is {quoted(share)}: ",
                code="twin",
            )
        noise_of(self.noise, self.axis)

    @property
    def true_values(self) -> dict[str, float]:
        """Return the true values before scatter and drift, by declared parameter, SI."""
        plan = twin_plan(self.axis, sample_period=self.sample_period)
        return {p.name: plan.true_values[p.name] for p in self.axis.declared.parameters}

    def truth(self, machine: int, day: int) -> dict[str, float]:
        """Return the true values of a machine on a day, SI; machine and day are numbered from 0.

        The factor of the scatter is log-normal, so that a value keeps its sign.
        """
        child = np.random.SeedSequence(self.seed, spawn_key=(machine, _VALUES))
        true = self.true_values
        drawn = dict(
            zip(true, np.random.default_rng(child).standard_normal(len(true)), strict=True)
        )
        return {
            name: value
            * math.exp(self.scatter.get(name, self.scatter.get("", 0.0)) * drawn[name])
            * (1 + self.drift.get(name, 0.0) * day)
            for name, value in true.items()
        }

    def record(self, machine: int, day: int) -> Record:
        """Return the record of a machine on a day; machine and day are numbered from 0.

        Raises
        ------
        AxisidError
            The simulated loop is unstable.
        """
        axis = self.axis
        if self.scatter or self.drift:
            axis = twin_of(axis, self.truth(machine, day), None)
        plan = twin_plan(axis, sample_period=self.sample_period)
        made = drawn_twin(plan, noise_of(self.noise, axis), self.seed, machine + _MOST * day)
        named = filter(None, (self.serial(machine), self.date(day)))
        source = f"twin {' '.join(named)} of {axis.axis.name}, seed {self.seed}"
        return replace(made, provenance=replace(made.provenance, source=source))

    def date(self, day: int) -> str:
        """Return the date of a day, as ``2026-01-01``; empty if there is only one day."""
        return (_FIRST_DAY + timedelta(days=day)).isoformat() if self.days > 1 else ""

    def serial(self, machine: int) -> str:
        """Return the serial number of a machine as text, from ``0001``."""
        return f"{machine + 1:04}"


def twin_content(record: Record, axis: Axis, file: Path) -> str | bytes:
    """Return the content of a log file, with the units of its columns and the true values.

    Raises
    ------
    ModelError, DataError
        Errors of `log_content`.
    """
    units = {parameter.name: parameter.unit for parameter in axis.parameters}
    truth = record.provenance.truth
    values = ", ".join(f"{name} = {truth[name]:.9g} {unit}" for name, unit in units.items())
    return log_content(
        record.channels(), axis, MARK, f"{record.provenance.source}; true values {values}", file
    )


def write_twin(machines: TwinMachines, file: str | Path) -> Path:
    """Write the log of the first machine on the first day, and return its path.

    The file is written completely or not at all.

    Parameters
    ----------
    machines : TwinMachines
    file : str or Path
        File that ends in ``.csv``, or in ``.parquet``, which needs pyarrow.

    Raises
    ------
    UsageError
        The ending is another one, or the file cannot be written.
    AxisidError
        The twin cannot be simulated, or the columns of its axis cannot be written.
    """
    path = Path(file)
    return write_file(path, twin_content(machines.record(0, 0), machines.axis.declared, path))


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
        Folder of the logs, which is created if it does not exist.
    axis : str, optional
        Axis in the manifest: a name in the library, or its file.
    ending : str
        ``.csv`` or ``.parquet``.
    progress : callable, optional

    Returns
    -------
    Path
        Path of the manifest: a row for each log with ``log``, ``axis``, ``serial``, for several
        days the ``date``, and every true value as ``true NAME [UNIT]``.

    Raises
    ------
    UsageError, AxisidError
        As `write_twin`; the files of the folder are unchanged.
    """
    place = Path(folder).resolve()
    try:
        place.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".twins-", dir=place) as made:
            names = _log_names(machines, ending)
            declared, rows = machines.axis.declared, []
            units = {p.name: p.unit for p in declared.parameters}
            for name in with_progress(names, progress, lambda name: f"simulating {name}"):
                machine, day = names[name]
                record, file = machines.record(machine, day), Path(made, name)
                replace_file(file, twin_content(record, declared, file))
                true = machines.truth(machine, day)
                rows.append(
                    {
                        "log": name,
                        "axis": _relative_axis(place, axis),
                        "serial": machines.serial(machine),
                        **({"date": machines.date(day)} if machines.days > 1 else {}),
                        **{f"true {n} [{units[n]}]": value for n, value in true.items()},
                    }
                )
            # The manifest has the true values of these logs. All are written to a temporary folder
            # and then moved, so that earlier logs keep their manifest if the disk is full.
            replace_file(Path(made, MANIFEST), csv_text([rows[0], *(row.values() for row in rows)]))
            for name in (*names, MANIFEST):
                os.replace(Path(made, name), place / name)
    except OSError as error:
        raise UsageError(f"{folder} cannot be written to: {error.strerror}.") from error
    return Path(folder, MANIFEST)


def twin_files(machines: TwinMachines, ending: str) -> dict[str, str]:
    """Return the files that `write_twins` writes, by name, with their kind as in `kinds_of`."""
    return {MANIFEST: "twin-manifest", **dict.fromkeys(_log_names(machines, ending), "twin")}


def _log_names(machines: TwinMachines, ending: str) -> dict[str, tuple[int, int]]:
    """Return machine and day of every log, numbered from 0, by the name of the log."""
    axis = machines.axis.axis.name
    return {
        "-".join(filter(None, (axis, machines.serial(machine), machines.date(day)))) + ending: (
            machine,
            day,
        )
        for machine in range(machines.count)
        for day in range(machines.days)
    }


def _relative_axis(folder: Path, axis: str) -> str:
    """Return the axis for a manifest in a folder: a name, or the path of a file from the folder."""
    file, variable = axis_file(axis)
    if file.suffix not in (".py", ".toml"):
        return axis
    try:
        path = os.path.relpath(file.resolve(), folder)
    except ValueError:  # on another drive of Windows
        path = str(file.resolve())
    return f"{path}:{variable}" if variable else path
