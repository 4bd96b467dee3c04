"""Axes with recorded signals: a counter-balance pressure, a supply voltage, a feed-forward."""

import numpy as np
import sympy

from axisid import Axis, Coordinate, Parameter, Signal, load_axis, newton
from axisid.control import (
    MEASURED_POSITION,
    PERIOD,
    REFERENCE,
    ControlLaw,
    Memory,
    cascade_pd_difference,
    gain,
)
from axisid.elements import Drive
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import LIBRARY, Experiment, back_and_forth
from axisid.support.arrays import Array

#: Axes of the library that need nothing but their own motion.
UNRECORDED = tuple(name for name in LIBRARY if not load_axis(name).signals)
PERIOD_S = 1e-3
TRUTH = {"M": 90.0, "Fv": 200.0, "Fc": 20.0, "off": -600.0, "A": 1e-3}

q = Coordinate("q", "m")
M = Parameter("M", "kg", nominal=70.0, lower=0.0)
FV = Parameter("Fv", "N/(m/s)", nominal=100.0, lower=0.0)
FC = Parameter("Fc", "N", nominal=10.0, lower=0.0)
OFF = Parameter("off", "N")
AREA = Parameter("A", "m^2", nominal=5e-4)
FRICTION = (FV * q.velocity, FC * sympy.sign(q.velocity), OFF)
MOVES = back_and_forth(speeds=(0.1, 0.3, 0.5), acceleration=5.0, seconds=0.6, repeat=2)


def fed_law() -> ControlLaw:
    """A cascade with a feed-forward that another controller gives."""
    last = Memory("last", following=MEASURED_POSITION, start=MEASURED_POSITION)
    speed = (MEASURED_POSITION - last.symbol) / PERIOD
    position = gain("kp") * (REFERENCE - MEASURED_POSITION)
    return ControlLaw(
        name="cascade with a feed-forward",
        period=PERIOD_S,
        gains={"kp": 30.0, "kv": 300.0},
        output=gain("kv") * (position - speed) + Signal("feed", "V", "held"),
        memory=(last,),
    )


def recorded_axis(kind: str, between: str = "linear", noise: float = 2e-6) -> Axis:
    """A vertical axis with one recorded signal: its ``pressure``, ``supply`` or ``feed``."""
    unit = {"pressure": "Pa", "supply": "V", "feed": "V"}[kind]
    signal = Signal(kind, unit, "held" if kind == "feed" else between)
    balanced = kind == "pressure"
    parameters = (M, FV, FC, OFF, *((AREA,) if balanced else ()))
    return newton(
        f"recorded_{kind}",
        coordinate=q,
        parameters=parameters,
        signals=(signal,),
        inertia=M,
        resistance=(*FRICTION, *((AREA * signal,) if balanced else ())),
        drive=Drive(gain=35.0, scaled_by=signal / 24 if kind == "supply" else sympy.S.One),
        control=fed_law()
        if kind == "feed"
        else cascade_pd_difference(kp=30.0, kv=300.0, period=PERIOD_S),
        experiment=Experiment(
            moves=MOVES,
            truth={p.name: TRUTH[p.name] for p in parameters},
            position_noise=noise,
        ),
    )


def recorded_values(kind: str, seed: int = 0) -> dict[str, Array]:
    """A signal along the experiment of `recorded_axis`, waves and steps."""
    reference = trajectory(MOVES, PERIOD_S)
    rng, time = np.random.default_rng(seed), PERIOD_S * np.arange(len(reference))
    steps = np.repeat(rng.normal(size=len(time) // 250 + 1), 250)[: len(time)]
    wave = np.sin(2 * np.pi * 0.7 * time + rng.uniform(0, 6))
    if kind == "pressure":
        return {kind: 6e5 + 1e5 * wave + 2e4 * steps}
    if kind == "supply":
        return {kind: 24.0 + 2.0 * wave + 0.5 * steps}
    velocity = np.gradient(reference, PERIOD_S)
    return {kind: (80.0 * np.gradient(velocity, PERIOD_S) + 150.0 * velocity) / 35.0}
