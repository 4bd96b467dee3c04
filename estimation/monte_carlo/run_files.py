"""Files of the numbers of a study: NumPy's npz or Parquet, one row for each run."""

import json
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import Array
from axisid.support.errors import UsageError
from axisid.support.files import write_file
from axisid.support.libraries import library
from axisid.support.table_bytes import npz_bytes, parquet_bytes
from axisid.support.version import __version__

from .drawn_twins import declared_figures
from .result import MonteCarlo
from .runs import INTERVALS, PARAMETER, STATUSES, Estimand

#: Suffixes of the files that a study can be written to.
OUTPUT_SUFFIXES = (".npz", ".parquet")
#: Name of the entry of a file with the metadata of the study: axes, settings, true values.
SETTINGS = "axisid.monte_carlo"


def run_columns(result: MonteCarlo) -> dict[str, NDArray[Any]]:
    """Return the numbers of every run by name of the column, (R,) each.

    The first columns are ``run``, ``status`` and ``reason``. Each estimand has columns such as
    ``idm-iv.M`` (the value), ``idm-iv.M.corrected`` (the value minus its bias), and
    ``idm-iv.M.hac.sd``, ``.low`` and ``.high`` (standard error and bounds of each kind of
    interval). Each check has a column such as ``check.control law`` with its status, which is empty
    for a run without a verdict.
    """
    columns: dict[str, NDArray[Any]] = {
        "run": result.numbers.runs,
        "status": np.array([status for status, _ in result.outcomes.values()], dtype=np.str_),
        "reason": np.array([why for _, why in result.outcomes.values()], dtype=np.str_),
    }
    columns |= {name: values for name, _, values in _estimand_columns(result)}
    words = np.array([*STATUSES, ""])  # the index -1 of a run without the check is the last word
    for i, check in enumerate(result.numbers.checks):
        columns[f"check.{check}"] = words[result.numbers.statuses[:, i]]
    return columns


def _estimand_columns(result: MonteCarlo) -> Iterator[tuple[str, str, Array]]:
    """Yield name, unit and values, (R,), of each column of the estimands.

    A kind of interval has columns only if a run has such an interval.
    """
    by_estimand = result.numbers.numbers.transpose(1, 2, 0)
    for estimand, numbers in zip(result.estimands, by_estimand, strict=True):
        name, unit = column_name(estimand), estimand.unit
        yield name, unit, numbers[0]
        yield f"{name}.corrected", unit, numbers[1]
        # Standard error and both bounds, (3, R), of each kind of interval.
        intervals = numbers[2:].reshape(len(INTERVALS), 3, -1)
        for kind, of_kind in zip(INTERVALS, intervals, strict=True):
            if np.isfinite(of_kind[0]).any():
                for end, column in zip(("sd", "low", "high"), of_kind, strict=True):
                    yield f"{name}.{kind}.{end}", unit, column


def column_name(estimand: Estimand) -> str:
    """Return the first part of the names of an estimand's columns: ``idm-iv.M``.

    The kind of the estimand is in the middle if it is not an identified parameter.
    """
    if estimand.kind == PARAMETER:
        return f"{estimand.method}.{estimand.name}"
    return f"{estimand.method}.{estimand.kind}.{estimand.name}"


def write_runs(result: MonteCarlo, path: str | Path) -> Path:
    """Write the numbers of every run, whole or not at all.

    Parameters
    ----------
    result : MonteCarlo
    path : str or Path
        ``.npz`` (`numpy.load`) or ``.parquet``, which needs pyarrow; columns as in `run_columns`.

    Returns
    -------
    Path
        The written file.

    Raises
    ------
    UsageError
        The name has another suffix, or the file cannot be written.
    DataError
        pyarrow is not installed.
    """
    file = Path(path)
    check_output(file)
    units = {name: unit for name, unit, _ in _estimand_columns(result)}
    plan, columns = result.plan, run_columns(result)
    settings = {
        "axis": plan.axis.name,
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
        "units": units,
        "axisid": __version__,
    }
    about = {SETTINGS: json.dumps(settings)}
    if file.suffix == ".npz":
        content = npz_bytes({**columns, **about})
    else:
        content = parquet_bytes(columns, units, about, file)
    return write_file(file, content)


def check_output(file: Path) -> None:
    """Refuse a file that no study can be written to, before anything is computed.

    Raises
    ------
    UsageError
        The name has another suffix.
    DataError
        pyarrow is not installed.
    """
    if file.suffix not in OUTPUT_SUFFIXES:
        raise UsageError(
            f"{file}: the name must end with {' or '.join(OUTPUT_SUFFIXES)} for the numbers of a "
            "study. Give a name with one of these endings.",
            code="study",
        )
    if file.suffix == ".parquet":
        library("pyarrow.parquet", "parquet", file)
