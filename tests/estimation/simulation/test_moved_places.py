"""Kinks and jumps that recorded signals move are events: closed forms, and the virtual machine."""

from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy

from axisid import Parameter, Signal, build, newton, simulate
from axisid.codegen.artefacts import GeneratedAxis
from axisid.elements import Drive, coulomb
from axisid.support.arrays import Array
from tests.axes.bodies import force_law, x
from tests.estimation.simulation.agreement import LANES, agree

T = 1e-3
TIME = T * np.arange(400)
MASS, FRICTION, STIFFNESS = 2.0, 1.0, 3e6
m, c = Parameter("m", "kg", nominal=1.0), Parameter("c", "N", nominal=1.0)


@cache
def axis(*, native: bool = True) -> GeneratedAxis:
    """A mass with dry friction, and forces of several kinds whose places signals move."""
    names = {"stop": "N/m", "jump": "N", "slip": "N/(m/s)", "gate": "N/m"}
    sizes = {name: Parameter(name, unit, nominal=1.0) for name, unit in names.items()}
    place, belt = Signal("place", "m"), Signal("belt", "m/s", "held")
    forces = (
        sizes["stop"] * sympy.Max(0, x.symbol - place),
        sizes["jump"] * sympy.sign(x.symbol - place),
        sizes["slip"] * sympy.Max(0, x.velocity - belt),
        sizes["gate"] * sympy.Max(0, -place),
    )
    made = newton(
        "moved",
        coordinate=x,
        parameters=(m, c, *sizes.values()),
        signals=(place, belt),
        inertia=m,
        resistance=(coulomb(c, x), *forces),
        drive=Drive(gain=1.0),
        control=force_law(T),
    )
    return build(made, native=native)


def theta(*, friction: float = 0.0, **sizes: float) -> list[float]:
    return [MASS, friction, *(sizes.get(name, 0.0) for name in ("stop", "jump", "slip", "gate"))]


def moved(parameters: list[float], place: Array, push: Array, **others: Any) -> Array:
    signals = {"place": place, "belt": 0.03 * np.cos(17 * TIME)}
    native = others.pop("native", True)
    start = {"start": 0.0, **others}
    return simulate(axis(native=native), parameters, push, T, signals=signals, **start).position


@pytest.mark.parametrize("native", [pytest.param(True, marks=pytest.mark.slow), False])
def test_a_stop_that_comes_and_goes_within_a_sample_is_met(native: bool) -> None:
    """In its frame a push throws the mass back into it, on a parabola from a half wave to a third.

    Before and after the sample they are apart.
    """
    comes, push, stiffness, speed = 0.3, 2000.0, 3e8, 0.15
    away, w = push / MASS, np.sqrt(stiffness / MASS)
    first = (comes**2 - speed**2) / (2 * away)  # they meet at this speed
    place, forces = first + comes * (T - TIME), np.where(TIME == T, -push, 0.0)
    found = moved(theta(stop=stiffness), place, forces, native=native)
    contact = 2 / w * np.arctan(speed * stiffness / (w * push))
    left = T - (comes - speed) / away - contact
    assert 0 < left < T / 2 + T / 4
    apart, parting = speed * left + away * left**2 / 2, speed + away * left
    expected = place[2] - apart - (comes + parting) * (TIME[2:6] - TIME[2])
    assert found[2:6] == pytest.approx(expected, abs=1e-9)


#: What each kind of force is declared with.
KINDS = {"stop": 2e4, "slip": 50.0, "jump": 1.5, "gate": 200.0}


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_steps_lanes_and_the_virtual_machine_agree(kind: str) -> None:
    parameters, push = theta(friction=FRICTION, **{kind: KINDS[kind]}), 3.0 * np.sin(9 * TIME)
    place = 0.004 * np.cos(31 * TIME)
    one, fine = moved(parameters, place, push), moved(parameters, place, push, substeps=32)
    assert np.ptp(one) > 1e-4
    assert one == pytest.approx(fine, abs=1e-9)
    signals, start = {"place": place, "belt": 0.03 * np.cos(17 * TIME)}, np.zeros(LANES)
    given = np.tile(parameters, (LANES, 1)), push, T
    agree(axis(), *given, machine=axis(native=False), start=start, signals=signals)


def test_an_axis_rests_in_a_jump_while_it_stands_still_and_not_while_it_moves() -> None:
    push = np.where(TIME < 0.2, 1.0, 0.0)
    assert np.all(moved(theta(jump=5.0), 0 * TIME, push) == 0)
    leaps = moved(theta(jump=5.0), np.where(TIME < 0.1, 0.0, 0.01), push)
    assert np.all(leaps[TIME < 0.0995] == 0)
    assert leaps[150] > 1e-3
    carried = moved(theta(friction=0.5, jump=5.0), 1e-3 * TIME, push)
    assert carried == pytest.approx(1e-3 * TIME, abs=1e-6)  # the jump takes it along
