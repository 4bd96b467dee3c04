"""Contact with an end stop: closed forms, and SciPy with events."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from axisid import (
    Parameter,
    build,
    simulate,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.elements import end_stop
from tests.axes.bodies import body, force_law, x

m = Parameter("m", "kg", nominal=2.0)
MASS, STIFFNESS, STOP, PERIOD = 2.0, 8e4, 0.05, 1e-3
TIME = PERIOD * np.arange(200)


def bouncing(dissipation: float, *, native: bool = True) -> GeneratedAxis:
    """A mass under a constant force: the law gives the reference as force, whatever it measures."""
    stops = end_stop(x, lower=-1.0, upper=STOP, stiffness=STIFFNESS, dissipation=dissipation)
    made = body(stops, coordinate=x, inertia=m, name="bouncing", control=force_law(PERIOD))
    return build(made, native=native)


FORCE = np.where(TIME < 0.02, 30.0, 0.0)  # a push, then free flight into the stop
SPEED = 30.0 * 0.02 / MASS


@pytest.mark.slow
@pytest.mark.parametrize("dissipation", [0.5, 4.0])
def test_impact_with_dissipation_is_that_of_scipy_with_events(dissipation: float) -> None:
    loop = simulate(bouncing(dissipation), [MASS], FORCE, PERIOD, start=0.0)

    def contact(_: float, state: np.ndarray) -> list[float]:
        depth = state[0] - STOP
        push = STIFFNESS * depth * max(0.0, 1 + dissipation * state[1])
        return [state[1], -push / MASS]

    def leaves(_: float, state: np.ndarray) -> float:
        return float(state[0] - STOP)

    leaves.terminal, leaves.direction = True, -1.0  # type: ignore[attr-defined]
    begins = 0.02 + (STOP - 30.0 / MASS * 0.02**2 / 2) / SPEED
    inside = solve_ivp(
        contact, (0, 1), [STOP, SPEED], "DOP853", events=leaves, rtol=1e-11, atol=1e-14
    )
    ends, speed = begins + inside.t[-1], inside.y[1, -1]
    after = ends < TIME
    assert loop.position[after] == pytest.approx(STOP + speed * (TIME[after] - ends), abs=2e-5)
    assert loop.velocity[-1] == pytest.approx(speed, rel=2e-3)
    assert 0 < -speed < SPEED


@pytest.mark.slow
def test_restitution_is_what_the_docstring_says_for_small_dissipation() -> None:
    loop = simulate(bouncing(0.05), [MASS], FORCE, PERIOD, start=0.0, substeps=64)
    lost = 1 + loop.velocity[-1] / SPEED  # 1 - e
    assert 1.5 * lost / SPEED == pytest.approx(0.05, rel=0.05)
