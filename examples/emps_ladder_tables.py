"""The tables of docs/emps_ladder.md and emps_ladder_tables.md, from scores."""

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

Rows = list[list[str]]
#: What tables call the lengths of the windows.
LENGTHS = ("1 s", "5 s", "half", "whole")


class Scored(Protocol):
    """A `emps_ladder.Score`."""

    fitted: list[float]
    held: list[float]
    values: list[dict[str, float]]
    deviations: list[dict[str, float]]

    @property
    def error(self) -> float:
        """Of what was held out, m."""


def table(title: str, header: str, rows: Rows) -> str:
    """One table as Markdown; the columns' names are separated by bars."""
    names = [name.strip() for name in header.split("|")]
    lines = [names, ["---"] * len(names), *rows]
    return "\n".join([f"{title}\n", *(f"| {' | '.join(line)} |" for line in lines), ""])


def ladder_table(
    scores: Mapping[str, Mapping[str, Scored]], drifts: Mapping[str, Mapping[str, float]]
) -> Rows:
    """Errors of every rung, um, and the constant force that would make as much, N."""
    rows = []
    for words, of in scores.items():
        row = [words, f"{len(of['1 s'].values[0])}"]
        for name in LENGTHS:
            error = of[name].error
            row += [f"{1e6 * error:.0f}", f"{error / drifts[name]['offset']:.3f}"]
        rows.append(row)
    return rows


def splits_table(scores: Mapping[str, Mapping[str, Scored]]) -> Rows:
    """What is left of each cycle where it is held out, and of what was fitted, um."""
    rows = []
    for words, of in scores.items():
        row = [words]
        for name in LENGTHS[:2]:
            fitted = float(np.sqrt(np.mean(np.square(of[name].fitted))))
            row += [f"{1e6 * fitted:.0f}", *(f"{1e6 * each:.0f}" for each in of[name].held)]
        rows.append(row)
    return rows


def drifts_table(drifts: Mapping[str, Mapping[str, float]], push: float) -> Rows:
    """What so large a force leaves of windows, um."""
    return [
        [name, *(f"{1e6 * push * drifts[name][kind]:.0f}" for kind in ("offset", "friction"))]
        for name in LENGTHS
    ]


def parameters_table(
    of: Mapping[str, Scored], names: Sequence[str], lengths: Sequence[str] = LENGTHS
) -> Rows:
    """Each parameter by the length of the windows: mean over the splits and spread of it."""
    rows = []
    for name in names:
        row = [name]
        for length in lengths:
            values = np.array([each[name] for each in of[length].values])
            claimed = np.sqrt(np.mean([each[name] ** 2 for each in of[length].deviations]))
            spread = f", {np.ptp(values):.2g}" if len(values) > 1 else ""
            row.append(f"{values.mean():.4g} +- {claimed:.2g}{spread}")
        rows.append(row)
    return rows


def numbers_table(found: Mapping[str, Mapping[str, Mapping[str, Sequence[float]]]]) -> Rows:
    """What two numbers of a neighbouring cycle buy, um."""
    return [
        [words, length, *(f"{1e6 * np.sqrt(np.mean(np.square(e))):.0f}" for e in errors.values())]
        for words, lengths in found.items()
        for length, errors in lengths.items()
    ]
