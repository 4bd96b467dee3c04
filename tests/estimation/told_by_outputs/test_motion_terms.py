"""Forces along a motion have the shapes that they are named for."""

import numpy as np
import pytest

from axisid import load_axis
from axisid.estimation.predictions import Motion
from axisid.estimation.told_by_outputs.motion_terms import (
    TERMS,
    subject_of,
    terms_of,
)


def test_an_acceleration_is_that_within_each_window() -> None:
    """The velocity jumps where one window ends and the next begins, and grows alike in both."""
    time = 1e-3 * np.arange(100)
    motion = Motion(
        record=0,
        time=time,
        position=np.sin(time),
        velocity=2 * time + np.repeat([0.0, 0.3], 50),
        control=np.ones(100),
        windows=2,
    )
    said = [subject for subject, _ in TERMS]
    (found,) = terms_of([motion])[said.index("a force by the acceleration: another inertia")]
    np.testing.assert_allclose(found, 1.0)


def test_a_control_is_that_of_the_motion_at_which_it_acts() -> None:
    """Two samples later, in each of two windows: what is at their ends lasts."""
    time = 1e-3 * np.arange(100)
    velocity = np.tile(np.where(np.arange(50) < 20, -1.0, 1.0), 2)
    motion = Motion(
        record=0,
        time=time,
        position=np.cumsum(velocity),
        velocity=velocity,
        control=np.ones(100),
        windows=2,
        delay=2e-3,
    )
    said = [subject for subject, _ in TERMS]
    (found,) = terms_of([motion])[said.index("Coulomb friction: declare coulomb")]
    np.testing.assert_allclose(found, np.tile(np.where(np.arange(50) < 18, -1.0, 1.0), 2))
    (found,) = terms_of([motion])[said.index("another dead band of the drive")]
    np.testing.assert_allclose(found, 1.0)


def test_a_control_is_what_a_lag_makes_the_force_of() -> None:
    """Held commands, of which the lag leaves a share at each sample."""
    time, stays = 1e-3 * np.arange(100), np.exp(-1e-3 / 5e-3)
    velocity = np.where(np.arange(100) < 40, -1.0, 1.0)
    motion = Motion(
        record=0,
        time=time,
        position=np.cumsum(velocity),
        velocity=velocity,
        control=np.ones(100),
        lag=5e-3,
    )
    said = [subject for subject, _ in TERMS]
    (found,) = terms_of([motion])[said.index("Coulomb friction: declare coulomb")]
    force = [-1.0]
    for command in found[:-1]:
        force.append(stays * force[-1] + (1 - stays) * command)
    np.testing.assert_allclose(force, velocity)
    (found,) = terms_of([motion])[said.index("another dead band of the drive")]
    np.testing.assert_allclose(found, 1.0)


@pytest.mark.parametrize(("name", "declares"), [("valve", True), ("emps2015", False)])
def test_friction_that_is_declared_is_told_by_what_it_may_be_instead(
    name: str, declares: bool
) -> None:
    assert load_axis(name).has_stribeck is declares
    of_speed = [n for n, (subject, _) in enumerate(TERMS) if "low speed" in subject]
    said = {subject_of(n, has_stribeck=declares) for n in of_speed}
    assert any("declare stribeck" in each for each in said) != declares
