"""Friction that remembers: against closed forms, an independent integrator, and at rest."""

import re
from collections.abc import Iterator, Sequence
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from axisid import build, simulate
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation.simulation import Simulation, simulate_batch
from axisid.support.arrays import Array
from tests.axes.remembering import (
    FORCED,
    LEVELS,
    STIFFNESS,
    Drive,
    dahl_axis,
    stack,
    virtual,
)
from tests.refusals import refuses

PERIOD = 1e-3
MASS = 10.0


@cache
def _swept(kind: str, **other: float) -> Simulation:
    """A motion of half a millimetre, once a second, far into sliding; some parameters other."""
    axis = virtual(kind)
    time = PERIOD * np.arange(2300)
    reference = 5e-4 * np.sin(2 * np.pi * time) * np.minimum(2 * time, 1.0)
    theta = [other.get(name, value) for name, value in zip(axis.names, axis.nominal, strict=True)]
    return simulate(axis, theta, reference, PERIOD)


def _friction(loop: Simulation, viscous: float = 60.0) -> Array:
    """The force of what remembers, by the balance of the others."""
    return np.asarray(loop.force - MASS * loop.acceleration - viscous * loop.velocity)


def _turns(loop: Simulation) -> dict[int, float]:
    """Where the motion turns, by the sample before; without a jump of the force it bends little."""
    q, v, a = loop.position, loop.velocity, loop.acceleration
    before = np.flatnonzero(v[:-1] * v[1:] < 0)
    return dict(zip(before.tolist(), q[before] - v[before] ** 2 / (2 * a[before]), strict=True))


def _pieces(loop: Simulation) -> Iterator[tuple[int, Array]]:
    """Each sample with the ways from the one before it, on either side of where it turned."""
    q, turns = loop.position, _turns(loop)
    for k in range(1, len(q)):
        there = [turns[k - 1]] if k - 1 in turns else []
        yield k, np.diff([q[k - 1], *there, q[k]])


@pytest.mark.slow
def test_a_stack_has_the_hysteresis_of_masing() -> None:
    loop, limits = _swept("stack"), LEVELS / STIFFNESS
    stretched, wanted = np.zeros(3), np.zeros(len(loop.position))
    for k, ways in _pieces(loop):
        for way in ways:
            stretched = np.clip(stretched + way, -limits, limits)
        wanted[k] = STIFFNESS @ stretched
    force = _friction(loop)
    np.testing.assert_allclose(force, wanted, rtol=0, atol=1e-6 * LEVELS.sum())
    # From the peak on, the virgin curve twice as large, upside down (Masing).
    peak, trough = list(_turns(loop))[2:4]
    assert loop.velocity[peak] > 0
    branch = slice(peak + 1, trough)
    half = (_turns(loop)[peak] - loop.position[branch]) / 2
    virgin = np.minimum(STIFFNESS[:, None] * half, LEVELS[:, None]).sum(axis=0)
    np.testing.assert_allclose(
        force[branch], LEVELS.sum() - 2 * virgin, rtol=0, atol=1e-6 * LEVELS.sum()
    )


@pytest.mark.slow
def test_dahls_friction_follows_its_exponential() -> None:
    loop, stiffness, level = _swept("dahl", s0=1e5), 1e5, 20.0
    force, wanted = 0.0, np.zeros(len(loop.position))
    for k, ways in _pieces(loop):
        for way in ways:
            end = level * np.sign(way)
            force = end - (end - force) * np.exp(-stiffness * abs(way) / level)
        wanted[k] = force
    np.testing.assert_allclose(_friction(loop), wanted, rtol=0, atol=1e-6 * level)


@pytest.mark.parametrize("kind", ["dahl", "stack"])
@pytest.mark.parametrize("share", [0.5, 0.95])
def test_below_breakaway_a_constant_load_does_not_creep(kind: str, share: float) -> None:
    declare, most = {"dahl": (dahl_axis, 20.0), "stack": (stack, LEVELS.sum())}[kind]
    axis = build(declare(control=FORCED, drive=Drive(gain=1.0)), native=False)
    theta = axis.nominal
    theta[axis.names.index("Fv")] = 500.0  # so that the swing dies out
    loop = simulate(axis, theta, np.full(1500, share * most), PERIOD, start=0.0)
    assert np.ptp(loop.position[1000:]) < 1e-11 * loop.position[-1]
    assert _friction(loop, 500.0)[-1] == pytest.approx(share * most, rel=1e-9)


def _swung(theta: Sequence[float], forces: Array, count: int = 1000) -> tuple[Array, list[int]]:
    """The stack under held forces by many small leaps of Verlet's; reversals in each sample."""
    mass, stiffness, limits = theta[0], np.array(theta[2::2]), np.array(theta[3::2])
    limits, h = limits / stiffness, PERIOD / count
    q, v, stretched, found, reversals = 0.0, 0.0, np.zeros(3), [], []
    for force in forces:
        found.append(q)
        turned, rate = 0, (force - stiffness @ stretched) / mass
        for _ in range(count):
            before, v = v, v + h / 2 * rate
            q += h * v
            stretched = np.minimum(np.maximum(stretched + h * v, -limits), limits)
            rate = (force - stiffness @ stretched) / mass
            v += h / 2 * rate
            turned += before * v < 0
        reversals.append(turned)
    return np.array(found), reversals


@pytest.mark.parametrize("native", [pytest.param(True, marks=pytest.mark.slow), False])
def test_a_light_stack_swings_within_a_sample_as_small_leaps_have_it(native: bool) -> None:
    axis = build(stack(control=FORCED, drive=Drive(gain=1.0)), native=native)
    light = {"M": 0.005, "Fv": 0.0}
    theta = [light.get(name, value) for name, value in zip(axis.names, axis.nominal, strict=True)]
    forces = np.array([15.0, -8.0, 3.0, 3.0, 17.0, -19.0, -5.0, 6.0])
    loop = simulate(axis, theta, forces, PERIOD, start=0.0)
    position, reversals = _swung(theta, forces)
    assert max(reversals) > 1
    assert np.abs(loop.position - position).max() < 2e-5 * np.ptp(position)


def _exact(axis: GeneratedAxis, reference: Array) -> Array:
    """Position and velocity of the LuGre axis by another integrator, sample by sample."""
    mass, s0, s1, viscous, slides, sticks, speed = axis.nominal
    last, motion, found = 0.0, np.zeros(3), []

    def rates(_: float, motion: Array, tau: float) -> list[float]:
        _, v, z = motion
        level = slides + (sticks - slides) * np.exp(-((v / speed) ** 2))
        dz = v - s0 * abs(v) / level * z
        return [v, (tau - viscous * v - s0 * z - s1 * dz) / mass, dz]

    for command in reference:
        found.append(motion)
        tau = 30.0 * 40.0 * (60.0 * (command - motion[0]) - (motion[0] - last) / PERIOD)
        last = motion[0]
        step = solve_ivp(rates, (0, PERIOD), motion, "DOP853", args=(tau,), rtol=1e-11, atol=1e-16)
        motion = step.y[:, -1]
    return np.array(found)[:, :2]


@pytest.mark.slow
def test_a_bristle_moves_as_an_independent_integrator_has_it() -> None:
    axis = virtual("bristle")
    reference = 1e-3 * np.sin(2 * np.pi * 5 * PERIOD * np.arange(120))
    loop = simulate(axis, axis.nominal, reference, PERIOD)
    position, velocity = _exact(axis, reference).T
    assert np.abs(loop.position - position).max() < 1e-7 * np.ptp(position)
    assert np.abs(loop.velocity - velocity).max() < 1e-5 * np.ptp(velocity)


@pytest.mark.parametrize(
    ("kind", "wrong", "says"),
    [
        ("bristle", {"vs": 0.0}, "the Stribeck velocity of LuGre friction, vs, is 0 m/s"),
        ("bristle", {"Fc": 0.0, "Fs": 0.0}, "the Coulomb level of LuGre friction, Fc, is 0 N"),
        ("bristle", {"Fs": -1.0}, "the static level of LuGre friction, Fs, is -1 N"),
        ("dahl", {"s0": -1e6}, "the stiffness of Dahl friction, s0, is -1e"),
        ("stack", {"k2": 0.0}, "the stiffness of a Maxwell slider, k2, is 0 N/m"),
    ],
)
def test_what_no_friction_is_made_of_is_named(
    kind: str, wrong: dict[str, float], says: str
) -> None:
    """Not as a loop that diverges; of lanes, those that have it."""
    axis = virtual(kind)
    theta = np.array([wrong.get(n, v) for n, v in zip(axis.names, axis.nominal, strict=True)])
    reference = 1e-4 * np.sin(np.arange(20) / 3)
    with refuses("simulation", says):
        simulate(axis, theta, reference, 1e-3)
    batch = simulate_batch(axis, [theta, axis.nominal], reference, 1e-3, wanted=["position"])
    assert [*batch.failures] == [0]
    assert re.match(says, batch.failures[0])
