"""Slopes by a time of the drive are those of the loops that have it."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from axisid.estimation.predictions import TimedPredictions
from axisid.estimation.predictions.added_slopes import Motion
from axisid.estimation.predictions.lanes import Lanes


def _motion(record: int, period: float, count: int = 200) -> Motion:
    time = period * np.arange(count)
    return Motion(
        record=record,
        time=time,
        velocity=9 * np.cos(9 * time),
        control=np.sin(20 * time),
    )


def _slopes(motions: tuple[Motion, ...], time: float, name: str) -> Any:
    """By the time, of outputs that are the command at the drive."""
    none = Lanes(errors=np.zeros((sum(len(m.time) for m in motions), 1)), failures={})

    class Direct(SimpleNamespace):
        def __call__(self, _: Any) -> Lanes:
            return none

    of_model = Direct(
        spans=(),
        samples=(),
        units=("N",),
        step=0.0,
        measured=none.errors[:, 0],
        counted=np.ones(len(none.errors)),
        settle=lambda _: None,
        motions=lambda _: motions,
        slopes_by_added=lambda _, added: np.concatenate(added),
    )
    timed = TimedPredictions(cast(Any, of_model), time, name)
    return timed(np.array([[0.0, time + 1.0]])).errors[:, 0]


def test_each_record_has_its_own_period() -> None:
    motions = _motion(0, 1e-3), _motion(1, 2e-3)
    found = np.split(_slopes(motions, 0.0, "delay"), 2)
    for motion, slopes in zip(motions, found, strict=True):
        np.testing.assert_allclose(slopes[1:], -20 * np.cos(20 * motion.time[1:]), atol=0.5)


def test_a_lag_takes_the_way_of_what_it_made_of_the_command() -> None:
    motion, lag = _motion(0, 1e-3, 2000), 0.02

    def behind(lag: float) -> Any:
        stays, force = np.exp(-1e-3 / lag), [0.0]
        for u in motion.control:
            force.append(stays * force[-1] + (1 - stays) * u)
        return np.array(force)

    expected = -np.diff(behind(lag)) / 1e-3
    np.testing.assert_allclose(_slopes((motion,), lag, "lag"), expected, atol=1e-9)
