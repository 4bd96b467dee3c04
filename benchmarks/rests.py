"""Whether axes that rest for seconds are simulated, and how far that is from an own integrator.

A drive at rest is the commonest state of an axis. Random axes (friction, loads, laws, encoders)
move a few times, by micrometres to centimetres, and rest for seconds in between; some have an end
stop and a force that jumps with the position. None may be refused. The yardstick is an integrator
of its own (`event_integrator.py`), with plant and laws written by hand.

    python benchmarks/rests.py            a table
    python benchmarks/rests.py --json -   one JSON object
"""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import sympy
from event_integrator import Acceleration, EventIntegrator
from figures import give, parser_of
from numpy.typing import NDArray

from axisid import Coordinate, EstimationError, Parameter, build, newton, simulate
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.control import (
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    REFERENCE,
    ControlLaw,
    Memory,
    cascade_pd,
    cascade_pd_averaged,
    cascade_pd_difference,
    gain,
)
from axisid.elements import (
    Drive,
    cogging,
    coulomb,
    offset,
    periodic_coulomb,
    spring,
    stribeck,
    viscous,
)
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import Move

Array = NDArray[np.float64]
Row = dict[str, float]

STEP, KP, KV, KI = 1e-3, 60.0, 30.0, 1e-5  # s, 1/s, A/(m/s), 1/s
GAIN, LIMIT = 35.0, 10.0  # N/A, A
STRIBECK, PITCH = 5e-3, 0.016  # m/s, m
STOP, JUMP = 0.06, 0.01  # m
MOST_SAMPLES = 6_000
PARAMETERS = {
    "M": ("kg", 0.7, 1.7),  # decades from, to
    "Fv": ("N/(m/s)", 0.0, 2.0),
    "Fc": ("N", -1.0, 1.5),
    "Fs": ("N", -1.5, 0.5),
    "F0": ("N", -1.0, 1.3),
    "k": ("N/m", 1.0, 3.0),
    "A": ("N", -1.0, 1.0),
    "B": ("N", -2.0, -1.2),
    "J": ("N", -1.0, 1.0),
    "kc": ("N/m", 4.0, 7.5),
}
ALWAYS = ("M", "Fc")
LAWS = ("cascade", "averaged", "difference", "integral", "delayed", "continuous")


def law(name: str) -> ControlLaw:
    """A law as the program has it."""
    gains = {"kp": KP, "kv": KV, "period": STEP}
    if name == "averaged":
        return cascade_pd_averaged(**gains)
    if name == "difference":
        return cascade_pd_difference(**gains)
    if name == "integral":
        total = Memory("total", gain("total") + REFERENCE - MEASURED_POSITION, sympy.Integer(0))
        error = REFERENCE - MEASURED_POSITION + gain("ki") * total.symbol / PERIOD
        return ControlLaw(
            name="PID",
            period=STEP,
            gains={"kp": KP, "kv": KV, "ki": KI},
            output=gain("kv") * (gain("kp") * error - MEASURED_VELOCITY),
            memory=(total,),
        )
    if name == "delayed":
        output = gain("kv") * (gain("kp") * (REFERENCE - MEASURED_POSITION) - MEASURED_VELOCITY)
        return ControlLaw(
            name="delayed", period=STEP, gains={"kp": KP, "kv": KV}, output=output, delay=2
        )
    return cascade_pd(**gains, continuous=name == "continuous")


def program_axis(name: str, *, sided: bool) -> GeneratedAxis:
    """The axis of a law, with every kind of friction and load; some have an end stop and a jump."""
    x = Coordinate("x")
    p = {key: Parameter(key, unit, nominal=1.0) for key, (unit, _, _) in PARAMETERS.items()}
    resistance = [
        viscous(p["Fv"], x),
        coulomb(p["Fc"], x),
        stribeck(p["Fs"], x, velocity=STRIBECK),
        offset(p["F0"]),
        spring(p["k"], x),
        cogging(p["A"], 0, x, period=PITCH),
        periodic_coulomb(p["B"], 0, x, period=PITCH),
    ]
    kept = [key for key in p if sided or key not in ("J", "kc")]
    if sided:
        resistance.append(p["J"] * sympy.sign(x.symbol - JUMP))
        resistance.append(p["kc"] * sympy.Max(0, x.symbol - STOP))
    return build(
        newton(
            "random",
            coordinate=x,
            parameters=tuple(p[key] for key in kept),
            inertia=p["M"],
            resistance=tuple(resistance),
            drive=Drive(gain=GAIN, limit=LIMIT),
            control=law(name),
        )
    )


def acceleration(p: Row) -> Acceleration:
    """The same axis by hand."""

    def of(q: float, v: float, tau: float, s: float, sides: Sequence[float]) -> float:
        wave = math.cos(2 * math.pi * q / PITCH)
        friction = p["Fc"] + p["B"] * wave + p["Fs"] * math.exp(-((v / STRIBECK) ** 2))
        load = p["F0"] + p["k"] * q + p["A"] * wave
        if sides:
            load += p["J"] * sides[0] + p["kc"] * (q - STOP) * (sides[1] > 0)
        return (tau - p["Fv"] * v - friction * s - load) / p["M"]

    return of


class LawByHand:
    """The laws once more: a control from reference, measured position and true velocity."""

    def __init__(self, name: str, start: float) -> None:
        self.name = name
        self.before, self.total, self.line = [start, start], 0.0, [0.0, 0.0]

    def control(self, reference: float, measured: float, velocity: float) -> float:
        """The control of a sample."""
        error = KP * (reference - measured)
        if self.name == "averaged":
            velocity = (measured - self.before[1]) / (2 * STEP)
        elif self.name == "difference":
            velocity = (measured - self.before[0]) / STEP
        elif self.name == "integral":
            error += KP * KI * self.total / STEP
        self.total += reference - measured
        self.before = [measured, self.before[0]]
        control = min(max(KV * (error - velocity), -LIMIT), LIMIT)
        self.line = [*self.line, control]
        return self.line.pop(0) if self.name == "delayed" else control


def by_hand(name: str, p: Row, sided: bool, reference: Array, resolution: float) -> Array:
    """Positions of the yardstick."""
    places = (JUMP, STOP) if sided else ()
    axis = EventIntegrator(acceleration(p), float(reference[0]), places)
    control, positions = LawByHand(name, axis.q).control, np.empty(len(reference))
    for k, r in enumerate(reference):
        positions[k] = axis.q
        if name == "continuous":
            rate = (reference[min(k + 1, len(reference) - 1)] - r) / STEP

            def force(t: float, q: float, v: float, r: float = r, rate: float = rate) -> float:
                return GAIN * control(r + rate * t, q, v)

            axis.advance(force, STEP, held=False)
            continue
        measured = axis.q
        if resolution:
            measured = math.floor(axis.q / resolution + 0.5) * resolution
        tau = GAIN * control(r, measured, axis.v)
        axis.advance(lambda *_, tau=tau: tau, STEP, held=True)
    return positions


def draw_parameters(rng: np.random.Generator) -> Row:
    """Each present in half of the axes, but for the mass and the friction."""
    values = {name: 10 ** rng.uniform(*decades) for name, (_, *decades) in PARAMETERS.items()}
    return {n: v if n in ALWAYS or rng.random() < 0.5 else 0.0 for n, v in values.items()}


def draw_reference(rng: np.random.Generator) -> Array:
    """Moves of micrometres to centimetres, with rests of 1 to 3 s."""
    pieces = [np.zeros(1)]
    for _ in range(3):
        move = Move(
            float(rng.choice([-1, 1]) * 10 ** rng.uniform(-6, -1.2)),
            float(10 ** rng.uniform(-2.5, -0.5)),
            float(10 ** rng.uniform(-1, 0.7)),
        )
        moved = pieces[-1][-1] + trajectory((move,), STEP)
        pieces += [moved, np.full(int(rng.uniform(1, 3) / STEP), moved[-1])]
    return np.concatenate(pieces)[:MOST_SAMPLES]


@dataclass(frozen=True)
class Outcome:
    """What came of one axis."""

    law: str
    refusal: str
    seconds: float
    resting: float  # share of the samples at rest
    off: float  # m, from the yardstick


def outcomes(count: int, seed: int) -> list[Outcome]:
    """Draw and simulate so many axes; what speaks of them."""
    rng = np.random.default_rng(seed)
    kinds = [(name, sided) for name in LAWS for sided in (False, True)]
    axes = {kind: program_axis(kind[0], sided=kind[1]) for kind in kinds}
    done = []
    for i in range(count):
        name, sided = kinds[i % len(kinds)]
        p, reference = draw_parameters(rng), draw_reference(rng)
        resolution = 10 ** rng.uniform(-7, -5) if rng.random() < 0.3 else 0.0
        resolution *= name != "continuous"
        axis = axes[name, sided]
        theta = [p[parameter] for parameter in axis.names]
        begin = time.perf_counter()
        try:
            loop = simulate(axis, theta, reference, STEP, resolution=resolution)
        except EstimationError as error:
            done.append(Outcome(name, str(error), time.perf_counter() - begin, 0.0, math.inf))
            continue
        taken = time.perf_counter() - begin
        off = np.abs(loop.position - by_hand(name, p, sided, reference, resolution)).max()
        done.append(Outcome(name, "", taken, float((loop.velocity == 0).mean()), float(off)))
    return done


def measure(count: int, seed: int) -> dict[str, float]:
    """The figures."""
    done = outcomes(count, seed)
    off = np.array([each.off for each in done])
    return {
        "axes": len(done),
        "refusals": sum(bool(each.refusal) for each in done),
        "resting_share": float(np.mean([each.resting for each in done])),
        "off_median_m": float(np.median(off)),
        "off_largest_m": float(off.max()),
        "off_beyond_1_nm": int((off > 1e-9).sum()),
        "off_beyond_1_um": int((off > 1e-6).sum()),
        "slowest_ms": 1e3 * max((each.seconds for each in done[len(LAWS) * 2 :]), default=0.0),
    }


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--axes", type=int, default=1000, help="random axes (default 1000)")
    parser.add_argument("--seed", type=int, default=1, help="of the axes (default 1)")
    options = parser.parse_args()
    figures = measure(options.axes, options.seed)
    give(figures, options.json, (f"{name:<20}{v:>12.4g}" for name, v in figures.items()))


if __name__ == "__main__":
    main()
