"""Logs of twins: of one machine, or of many whose true values scatter and drift from day to day.

A twin is a simulated machine with known true values.

In: an axis, a description of its twins. Out: logs that `read_record` reads without options, a
manifest with the truth. Knows nothing of the identification of a log, and of the command line.
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
_MOST = 1_000_000  # machines: the noise of each day is that of runs from this number on
_MOST_DAYS = 10_000
_VALUES = 100  # of the random numbers of a machine, in addition to those of its noise
#: Kind of the file of a twin's log.
MARK = "axisid.twin/1"
#: Name in the folder of the logs; `fleet` reads it.
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
        By parameter, the relative standard deviation between machines, at most 1; by ``""`` that of
        all others.
    drift : mapping of str to float
        By parameter, its relative change per day, at most 1. Its sign must not change until the
        last day.
    noise : Chain or None
        Noise of the measurements; None uses that of the experiment.
    seed : int
        Seed of all: adding machines and days changes no existing ones.
    sample_period : float or None
        Sample period of the logs, s; by default that of the law.

    Raises
    ------
    UsageError, ModelError
        A value is impossible.
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
        shares = [("scatter", *each, {"": 1.0, **true}) for each in self.scatter.items()]
        shares += [("drift", *each, true) for each in self.drift.items()]
        for what, name, share, of in shares:
            is_share = is_real(share) and abs(share) <= 1 and (share >= 0 or what == "drift")
            refuse(
                UsageError,
                (
                    name not in of,
                    f"the axis has no such parameter. Its parameters are {', '.join(true)}",
                ),
                (not is_share, "give a share of the value, at most 1, such as 0.02 for 2 %"),
                (
                    is_share and not share * (self.days - 1) > -1,
                    f"the value reaches 0 by day {self.days}. Give a smaller share, or fewer days",
                ),
                (
                    is_share and share and not of.get(name),
                    "its true value is 0. Give another true value, or omit this share",
                ),
                before=f"the {what} of {name or 'all'} is {quoted(share)}: ",
                code="twin",
            )
        noise_of(self.noise, self.axis)

    @property
    def true_values(self) -> dict[str, float]:
        """Return the true values about which the machines scatter, by declared parameter, SI."""
        plan = twin_plan(self.axis, sample_period=self.sample_period)
        return {p.name: plan.true_values[p.name] for p in self.axis.declared.parameters}

    def truth(self, machine: int, day: int) -> dict[str, float]:
        """Return the true values of a machine on a day, both from 0.

        A value that scatters is log-normal, so that it keeps its sign.
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
        """Return the log of a machine on a day, both numbered from 0.

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
        """Return the date of the logs of a day; empty if there is only one day."""
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
    told = ", ".join(f"{name} = {truth[name]:.9g} {unit}" for name, unit in units.items())
    return log_content(
        record.channels(), axis, MARK, f"{record.provenance.source}; true values {told}", file
    )


def write_twin(machines: TwinMachines, file: str | Path) -> Path:
    """Write the log of the first machine on the first day, and return its path.

    The file is written completely or not at all.

    Parameters
    ----------
    machines : TwinMachines
    file : str or Path
        Ends in ``.csv`` or ``.parquet``, which needs pyarrow.

    Raises
    ------
    UsageError
        The ending is another one, or the file cannot be written.
    AxisidError
        The twin cannot be simulated, or its axis's columns cannot be written.
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
        May be new.
    axis : str, optional
        Axis in the manifest: a name of the library, or its file.
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
                        "axis": _from(place, axis),
                        "serial": machines.serial(machine),
                        **({"date": machines.date(day)} if machines.days > 1 else {}),
                        **{f"true {n} [{units[n]}]": value for n, value in true.items()},
                    }
                )
            # The manifest has the true values of these logs: the two are written before either is
            # put in its place, so that a full disk leaves earlier logs with their own manifest.
            replace_file(Path(made, MANIFEST), csv_text([rows[0], *(row.values() for row in rows)]))
            for name in (*names, MANIFEST):
                os.replace(Path(made, name), place / name)
    except OSError as error:
        raise UsageError(f"{folder} cannot be written to: {error.strerror}.") from error
    return Path(folder, MANIFEST)


def twin_files(machines: TwinMachines, ending: str) -> dict[str, str]:
    """Return the files that `write_twins` writes into its folder, with the kind of each."""
    return {MANIFEST: "twin-manifest", **dict.fromkeys(_log_names(machines, ending), "twin")}


def _log_names(machines: TwinMachines, ending: str) -> dict[str, tuple[int, int]]:
    """Return the name of every log, with its machine and its day."""
    axis = machines.axis.axis.name
    return {
        "-".join(filter(None, (axis, machines.serial(machine), machines.date(day)))) + ending: (
            machine,
            day,
        )
        for machine in range(machines.count)
        for day in range(machines.days)
    }


def _from(folder: Path, axis: str) -> str:
    """Return the name of an axis for a manifest; that of a file is relative to a folder."""
    file, variable = axis_file(axis)
    if file.suffix not in (".py", ".toml"):
        return axis
    try:
        told = os.path.relpath(file.resolve(), folder)
    except ValueError:  # on another drive of Windows
        told = str(file.resolve())
    return f"{told}:{variable}" if variable else told
