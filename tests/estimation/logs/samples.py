"""Samples of a motion, and a writer of MDF files, for the tests of formats."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

N = 50
T = 1e-3 * np.arange(N)
Q = np.sin(T * 200)
U = np.cos(T * 300)
NAMED = {"position": "q", "control": "u"}
STAMPS = np.datetime64("2026-02-01T12:00:00") + np.round(1e6 * T).astype("timedelta64[us]")


def mdf(file: Path, *groups: list[tuple[np.ndarray, np.ndarray, str, str]], **more: Any) -> Path:
    """A file of groups, each of channels: samples, their times, a name and a unit."""
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF(version="4.10") as content:
        for group in groups:
            content.append(
                [asammdf.Signal(x, t, name=name, unit=u, **more) for x, t, name, u in group]
            )
        content.save(file, overwrite=True)
    return file
