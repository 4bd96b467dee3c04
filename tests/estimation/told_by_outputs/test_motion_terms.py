"""Forces along simulated motions are controls of their time, where errors ask for them."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from axisid import load_axis
from axisid.estimation.predictions import Motion, Predictions
from axisid.estimation.told_by_outputs.missing import Left
from axisid.estimation.told_by_outputs.motion_terms import Force, forces_of
from axisid.support.arrays import Array
from axisid.support.missing import Missing

_AXIS = load_axis("emps2015")
_TIME = 1e-3 * np.arange(100)


def _left(errors: Array) -> Left:
    n = len(errors)
    return Left(
        errors=errors,
        weights=np.ones(n),
        curvature=np.ones(n),
        jacobian=np.zeros((n, 1)),
        inverse=np.eye(1),
        known=np.zeros((0, 1)),
        counted=np.ones(n, dtype=bool),
        spans=((slice(0, n),),),
        periods=(1e-3,),
    )


def _added_as_they_are(_physical: Array, added: Sequence[Array]) -> Array:
    return np.concatenate(added)


def _forces(*motions: Motion, errors: Array | None = None) -> dict[str, Force]:
    """Of outputs that are the added controls themselves."""
    samples = sum(len(m.time) for m in motions)
    predictions = SimpleNamespace(motions=lambda _: motions, slopes_by_added=_added_as_they_are)
    left = _left(np.ones(samples) if errors is None else errors)
    found = forces_of(_AXIS, cast(Predictions, predictions), np.zeros(1), left)
    assert not isinstance(found, Missing)
    return {force.term.kind: force for force in found if force.term.kind != "drift"}


def _motion(velocity: Array, **others: object) -> Motion:
    whole = {"record": 0, "time": _TIME, "control": np.ones(100), "position": np.cumsum(velocity)}
    return Motion(velocity=velocity, **{**whole, **others})  # type: ignore[arg-type]


def test_an_acceleration_is_that_within_each_window() -> None:
    """The velocity jumps where one window ends and the next begins, and grows alike in both."""
    motion = _motion(2 * _TIME + np.repeat([0.0, 0.3], 50), windows=2)
    np.testing.assert_allclose(_forces(motion)["inertia"].slopes, -1.0)


def test_a_control_is_that_of_the_motion_at_which_it_acts() -> None:
    """Two samples later, in each of two windows: what is at their ends lasts."""
    velocity = np.tile(np.where(np.arange(50) < 20, -1.0, 1.0), 2)
    found = _forces(_motion(velocity, windows=2, delay=2e-3))
    expected = np.tile(np.where(np.arange(50) < 18, 1.0, -1.0), 2)
    np.testing.assert_allclose(found["coulomb"].slopes, expected)
    np.testing.assert_allclose(found["dead band"].slopes, -1.0)


def test_a_control_is_what_a_lag_makes_the_force_of() -> None:
    """Held commands, of which the lag leaves a share at each sample."""
    stays = np.exp(-1e-3 / 5e-3)
    velocity = np.where(np.arange(100) < 40, -1.0, 1.0)
    found = _forces(_motion(velocity, lag=5e-3))
    commands = found["coulomb"].slopes / found["coulomb"].scale
    force = [1.0]
    for command in commands[:-1]:
        force.append(stays * force[-1] + (1 - stays) * command)
    np.testing.assert_allclose(force, -velocity)
    np.testing.assert_allclose(found["dead band"].slopes, -1.0)


@pytest.mark.parametrize("period", [0.005, 0.0123])
def test_a_wave_is_of_the_period_and_phase_that_errors_ask_for(period: float) -> None:
    time = 1e-3 * np.arange(4000)
    position = 0.04 * np.sin(2 * np.pi * 0.25 * time)
    velocity = np.gradient(position, time)
    motion = _motion(velocity, time=time, position=position, control=np.ones(4000))
    wave = np.cos(2 * np.pi * position / period + 1.0)
    forces = _forces(motion, errors=-wave)  # what is predicted is less than what was recorded
    strongest = max(forces.values(), key=lambda force: force.gain)
    assert strongest.term.kind == "place"
    assert strongest.at == pytest.approx(period, rel=0.02)
    assert strongest.gain == pytest.approx(wave @ wave, rel=0.1)
    assert strongest.asking.width == 2
    assert strongest.asking.tried > 10
    assert strongest.slopes @ wave / np.sqrt(wave @ wave * 4000) > 0.95


def test_a_load_behind_a_spring_takes_force_and_gives_none() -> None:
    """Errors of the other sign ask for none at any frequency."""
    time = 1e-3 * np.arange(3000)
    velocity = np.sin(2 * np.pi * 1.5 * time)
    motion = _motion(velocity, time=time, position=np.cumsum(velocity), control=np.ones(3000))
    seen = _forces(motion)["resonance"].slopes
    asked = partial(_forces, motion)
    assert asked(errors=-seen)["resonance"].gain > 0
    assert asked(errors=seen)["resonance"].gain == 0


def test_a_motion_that_cannot_be_simulated_is_asked_for_nothing() -> None:
    predictions = cast(Predictions, SimpleNamespace(motions=lambda _: None))
    assert isinstance(forces_of(_AXIS, predictions, np.zeros(1), _left(np.ones(9))), Missing)
    lost = replace(_motion(np.ones(100)), windows=1)
    without = SimpleNamespace(motions=lambda _: (lost,), slopes_by_added=lambda *_: None)
    found = forces_of(_AXIS, cast(Predictions, without), np.zeros(1), _left(np.ones(100)))
    assert isinstance(found, Missing)
