"""A servo joint under a proportional law at 200 Hz, and its logs in JSON."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from axisid import Axis, Coordinate, Parameter, Record, build, newton, read_record, simulate
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.control import pid
from axisid.elements import Drive, coulomb, gravity_moment, offset, viscous
from axisid.support.arrays import Array

PERIOD, COUNT = 5e-3, 2 * np.pi / 4096
TRUTH = {"J": 0.028, "mgl": 0.98, "fv": 1.2, "fc": 0.15, "o": 0.1}


def servo(*, with_offset: bool = False) -> Axis:
    """The joint; a constant force is told from friction by motion in both directions alone."""
    q = Coordinate("q", "rad")
    J = Parameter("J", "kg m^2", nominal=0.02, lower=0.0)
    mgl, o = Parameter("mgl", "N m"), Parameter("o", "N m")
    fv = Parameter("fv", "N m/(rad/s)", lower=0.0)
    fc = Parameter("fc", "N m", lower=0.0)
    return newton(
        "servo",
        coordinate=q,
        parameters=(J, mgl, fv, fc, *([o] if with_offset else [])),
        inertia=J,
        resistance=(
            gravity_moment(0, mgl, q),
            viscous(fv, q),
            coulomb(fc, q),
            *([offset(o)] if with_offset else []),
        ),
        drive=Drive(gain=0.75, unit="V", limit=12.0),
        control=pid(kp=20.0, period=PERIOD),
    )


def servo_log(
    axis: Axis | GeneratedAxis,
    file: Path,
    reference: Callable[[Array], Array],
    seconds: float,
    *,
    late: int = 0,
) -> Path:
    """Write what such a joint logs, its control so many samples late."""
    time = np.arange(round(seconds / PERIOD)) * PERIOD
    wanted = reference(time)
    generated = axis if isinstance(axis, GeneratedAxis) else build(axis)
    truth = {p.name: TRUTH[p.name] for p in generated.axis.parameters}
    loop = simulate(generated, truth, wanted, PERIOD, resolution=COUNT)
    columns = {
        "timestamp": time,
        "goal_position": wanted,
        "position": loop.measured_position,
        "volts": np.concatenate([np.full(late, loop.control[0]), loop.control])[: len(time)],
    }
    rows = [
        dict(zip(columns, map(float, row), strict=True))
        for row in np.column_stack([*columns.values()])
    ]
    file.write_text(json.dumps(rows))
    return file


def servo_record(axis: GeneratedAxis, file: Path) -> Record:
    """A log as it is read."""
    roles = {"time": "timestamp", "reference": "goal_position", "control": "volts"}
    return read_record(file, axis, columns={**roles, "position": "position"})
