"""Logs of a fleet: short twins of one axis, each with parameters of its own."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from axisid import build, load_axis, simulate
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling.declaration.experiment import back_and_forth

AXIS, PERIOD = "emps2015", 1e-3
TRUTH = {"M": 95.1089, "Fv": 203.5034, "Fc": 20.3935}
#: Scatter of the true values between machines of one kind, relative.
SPREAD = 0.01
NOISE = 2e-6  # m, on the position that the loop measures


def reference(cycles: int = 2) -> NDArray[np.float64]:
    """Some seconds to and fro at three speeds, each cycle 3 s."""
    moves = back_and_forth(speeds=(0.04, 0.08, 0.12), acceleration=0.8, seconds=0.4, repeat=cycles)
    return trajectory(moves, PERIOD)


def write_logs(
    folder: Path,
    count: int,
    *,
    seed: int = 1,
    cycles: int = 2,
    wrong: Mapping[int, Mapping[str, float]] | None = None,
) -> list[Path]:
    """Write a log of each machine as NumPy's arrays.

    Parameters
    ----------
    folder : Path
    count, seed, cycles : int
    wrong : mapping of int to mapping
        Of machines by their number, what a parameter is multiplied by.
    """
    axis = build(load_axis(AXIS))
    rng = np.random.default_rng(seed)
    motion = reference(cycles)
    time = PERIOD * np.arange(len(motion))
    files = []
    for number in range(count):
        truth = {name: value * (1 + SPREAD * rng.normal()) for name, value in TRUTH.items()}
        for name, factor in ((wrong or {}).get(number, {})).items():
            truth[name] *= factor
        noise = rng.normal(0.0, NOISE, len(motion))
        made = simulate(axis, [*truth.values()], motion, PERIOD, position_noise=noise)
        file = folder / f"axis{number:05}.npz"
        columns = {"position": made.measured_position, "reference": motion, "control": made.control}
        np.savez(file, time=time, **columns)
        files.append(file)
    return files
