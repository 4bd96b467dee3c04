"""Forces along a motion have the shapes that they are named for."""

import numpy as np

from axisid.estimation.predictions import Motion
from axisid.estimation.told_by_outputs.motion_terms import TERMS, terms_of


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
