"""Rows of a fleet that was never identified, and what a test's processes do."""

import os
import signal
import time
from pathlib import Path

import numpy as np

from axisid.fleets import FleetItem, FleetRow
from axisid.fleets.ledger import FleetValue
from axisid.fleets.one_log import Settings, identify_log
from axisid.support.arrays import Array

CENTRE = np.array([100.0, 200.0, 20.0])
BETWEEN = np.array([[1.0, 0.6, 0.0], [0.6, 4.0, 0.0], [0.0, 0.0, 0.04]])
WITHIN = np.diag([0.05, 0.5, 0.04]) ** 2


def rows_of(count: int, seed: int, apart: Array | None = None) -> list[FleetRow]:
    """Rows of machines of one kind; the first is apart from the others by some deviations."""
    rng = np.random.default_rng(seed)
    values = rng.multivariate_normal(CENTRE, BETWEEN + WITHIN, count)
    if apart is not None:
        values[0] = CENTRE + apart * np.sqrt(np.diag(BETWEEN + WITHIN))
    return [row_of(f"axis{i}", value) for i, value in enumerate(values)]


def row_of(name: str, value: Array, within: Array = WITHIN) -> FleetRow:
    deviations = np.sqrt(np.diag(within))
    return FleetRow(
        name=name,
        log=f"{name}.csv",
        axis="stage",
        status="ok",
        parameters={
            parameter: FleetValue(
                value=float(v), sd=float(sd), interval_95=(float(v - sd), float(v + sd)), unit="1"
            )
            for parameter, v, sd in zip(("M", "Fv", "Fc"), value, deviations, strict=True)
        },
        covariance=tuple(map(tuple, within.tolist())),
    )


def identify_or_harm(settings: Settings, item: FleetItem) -> FleetRow:
    """As a worker does, but for logs that hang or kill it."""
    if "hanging" in item.name:
        time.sleep(60)
    once = Path(settings.folder, ".killed")
    if "killing" in item.name or ("unlucky" in item.name and not once.exists()):
        once.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return identify_log(settings, item)
