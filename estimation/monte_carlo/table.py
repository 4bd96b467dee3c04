"""The numbers of a study as a file: NumPy's npz, or Parquet, a row for each run."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.tables import library, npz_bytes, parquet_bytes
from axisid.support.errors import UsageError
from axisid.support.files.regular_file import write_file
from axisid.support.version import __version__

from .plan import declared_figures
from .result import MonteCarlo
from .runs import INTERVALS, PARAMETER, STATUSES, Estimand

#: Endings of the files that a study can be written to.
OUTPUT_SUFFIXES = (".npz", ".parquet")
#: What a file says of itself, under this name.
SETTINGS = "axisid.monte_carlo"


def run_columns(result: MonteCarlo) -> dict[str, NDArray[Any]]:
    """The numbers of every run by column, (R,) each.

    ``run``, ``status`` and ``reason``; of every estimand ``idm-iv.M`` (the value), ``.corrected``
    (without its bias) and ``.hac.sd``, ``.hac.low``, ``.hac.high`` of each interval; of
    every check ``check.control law``, how it ended, empty where the run was not judged.
    """
    columns: dict[str, NDArray[Any]] = {
        "run": result.numbers.runs,
        "status": np.array(result.statuses, dtype=np.str_),
        "reason": np.array(result.reasons, dtype=np.str_),
    }
    for place in range(len(result.estimands)):
        columns |= _of_estimand(result, place)
    words = np.array([*STATUSES, ""])  # -1 is the last
    for i, check in enumerate(result.numbers.checks):
        columns[f"check.{check}"] = words[result.numbers.statuses[:, i]]
    return columns


def _of_estimand(result: MonteCarlo, place: int) -> dict[str, NDArray[Any]]:
    """The columns of an estimand, which have its unit."""
    name = column_name(result.estimands[place])
    columns = {name: result.values[:, place], f"{name}.corrected": result.corrected[:, place]}
    for of in INTERVALS:
        stated = result.deviations(of)[:, place]
        if not np.isfinite(stated).any():
            continue
        columns[f"{name}.{of}.sd"] = stated
        low, high = result.intervals(of)[:, place].T
        columns[f"{name}.{of}.low"], columns[f"{name}.{of}.high"] = low, high
    return columns


def column_name(estimand: Estimand) -> str:
    """What an estimand's columns begin with."""
    kind = () if estimand.kind == PARAMETER else (estimand.kind,)
    return ".".join((estimand.method, *kind, estimand.name))


def column_units(result: MonteCarlo) -> dict[str, str]:
    """Units of the columns of `run_columns` that have one."""
    return {
        name: estimand.unit
        for place, estimand in enumerate(result.estimands)
        for name in _of_estimand(result, place)
    }


def settings_text(result: MonteCarlo) -> str:
    """What a file says of the study, as JSON: its axes, all that was asked for, true values."""
    plan = result.plan
    return json.dumps(
        {
            "axis": plan.axis.axis.name,
            "signature": plan.axis.signature,
            "twin": plan.twin.axis.name,
            "twin_signature": plan.twin.signature,
            "seed": plan.seed,
            "runs": plan.runs,
            "done": len(result),
            "methods": list(plan.methods),
            "noise": declared_figures(plan.noise),
            "chain": asdict(plan.noise),
            "prefilter": asdict(plan.prefilter),
            "settings": dict(plan.settings),
            "levels": asdict(plan.levels),
            "checks": plan.checks,
            "truth": {
                column_name(each): truth
                for each, truth in zip(result.estimands, result.truths.tolist(), strict=True)
                if np.isfinite(truth)
            },
            "units": column_units(result),
            "axisid": __version__,
        }
    )


def write_runs(result: MonteCarlo, path: str | Path) -> None:
    """Write the numbers of every run, whole or not at all.

    Parameters
    ----------
    result : MonteCarlo
    path : str or Path
        ``.npz`` (`numpy.load`) or ``.parquet``, which needs pyarrow; columns as `run_columns` says.

    Raises
    ------
    UsageError
        The name has another ending, or the file cannot be written.
    DataError
        pyarrow is not installed.
    """
    file = Path(path)
    check_output(file)
    columns, about = run_columns(result), {SETTINGS: settings_text(result)}
    if file.suffix == ".npz":
        content = npz_bytes({**columns, **about})
    else:
        content = parquet_bytes(columns, column_units(result), about, file)
    write_file(file, content)


def check_output(file: Path) -> None:
    """Refuse a file that no study can be written to, before anything is computed.

    Raises
    ------
    UsageError
        As `write_runs`.
    DataError
        As `write_runs`.
    """
    if file.suffix not in OUTPUT_SUFFIXES:
        raise UsageError(
            f"{file}: the numbers of a study are written to {' or '.join(OUTPUT_SUFFIXES)}; give "
            "a name with that ending.",
            code="monte-carlo-output",
        )
    if file.suffix == ".parquet":
        library("pyarrow.parquet", "parquet", file)
