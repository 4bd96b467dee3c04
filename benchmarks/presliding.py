"""Friction that remembers on twins: LuGre's parameters and their intervals, loops, accuracy, time.

The axis has a mass of 10 kg and LuGre friction. Its reference swings with 0.1 to 3 Hz and dwells
between, where it wiggles by micrometres, within presliding. Each run has another noise of the
position, which the law sees, and starts from nominal values that are 10 to 30 % off. Of each
parameter there is the bias of the mean, the scatter over the runs, the mean of the claimed
deviation, and the share of 95 % intervals that hold the truth; and how often each check fails.

    python benchmarks/presliding.py                 a table
    python benchmarks/presliding.py --json -        one JSON object
    python benchmarks/presliding.py --runs 100 --free-mass
"""

import time
from collections import Counter
from collections.abc import Iterator, Mapping

import numpy as np
from figures import give, parser_of

from axisid import Coordinate, Parameter, Record, build, fit, newton, simulate
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.control import cascade_pd_difference
from axisid.elements import Drive, lugre, viscous
from axisid.estimation.output_error import OutputFit
from axisid.support.arrays import Array

TRUTH = {"M": 10.0, "s0": 1e6, "s1": 3e3, "Fv": 60.0, "Fc": 20.0, "Fs": 30.0, "vs": 0.01}
_OFF = {"M": 1.1, "s0": 0.8, "s1": 1.2, "Fv": 0.9, "Fc": 1.1, "Fs": 0.85, "vs": 1.3}
PERIOD = 1e-3
_SWING, _WIGGLE, _DWELL = 5e-3, 1e-5, 0.4  # m, m, s
_FREQUENCIES = (0.1, 0.3, 1.0, 3.0, 2.0, 0.5)


def axis_of() -> GeneratedAxis:
    """The axis, its nominal values those that a fit starts from."""
    x = Coordinate("x")
    units = {"M": "kg", "s0": "N/m", "s1": "N/(m/s)", "Fv": "N/(m/s)", "vs": "m/s"}
    p = {
        name: Parameter(name, units.get(name, "N"), nominal=value * _OFF[name], lower=0.0)
        for name, value in TRUTH.items()
    }
    friction = lugre(p["s0"], p["s1"], x, coulomb=p["Fc"], static=p["Fs"], velocity=p["vs"])
    return build(
        newton(
            "bristle",
            coordinate=x,
            parameters=p.values(),
            inertia=p["M"],
            resistance=(friction, viscous(p["Fv"], x)),
            drive=Drive(gain=30.0),
            control=cascade_pd_difference(kp=100.0, kv=60.0, period=PERIOD),
        )
    )


def reference() -> Array:
    """Half swings from rest to rest, a dwell after each."""
    parts, side = [np.full(100, -_SWING)], -1.0
    for frequency in _FREQUENCIES:
        time_ = np.arange(round(0.5 / frequency / PERIOD)) * PERIOD
        parts.append(side * _SWING * np.cos(2 * np.pi * frequency * time_))
        side = -side
        dwell = np.arange(round(_DWELL / PERIOD)) * PERIOD
        wiggle = np.sin(np.pi * dwell / _DWELL) ** 2 * np.sin(2 * np.pi * 5 * dwell)
        parts.append(side * _SWING + _WIGGLE * wiggle)
    return np.concatenate(parts)


def record(axis: GeneratedAxis, seed: int, noise: float) -> Record:
    """A twin with white noise of the position."""
    commanded = reference()
    white = noise * np.random.default_rng(seed).normal(size=len(commanded))
    theta = [TRUTH[name] for name in axis.names]
    loop = simulate(axis, theta, commanded, PERIOD, position_noise=white)
    return Record(
        time=loop.time,
        position=loop.measured_position,
        reference=commanded,
        control=loop.control,
    )


def run(count: int, noise: float, *, free_mass: bool) -> dict[str, object]:
    """The figures of so many runs."""
    axis, results, took = axis_of(), list[OutputFit](), list[float]()
    fixed = {} if free_mass else {"M": TRUTH["M"]}
    for seed in range(1, count + 1):
        began = time.process_time()
        twin = record(axis, seed, noise)
        results.append(fit(axis, twin, fixed=fixed, seed=seed))
        took.append(time.process_time() - began)
    names = [name for name in axis.names if free_mass or name != "M"]
    values = np.array([[r.parameters[n].value for n in names] for r in results])
    claimed = np.array([[r.parameters[n].deviation for n in names] for r in results])
    inside = np.array([[_holds(r, n) for n in names] for r in results])
    truth = np.array([TRUTH[n] for n in names])
    percent = 100 / truth
    checks = Counter(c.name for r in results for c in r.checks if c.status == "fail")
    return {
        "runs": count,
        "noise": noise,
        "bias_percent": dict(zip(names, percent * (values.mean(axis=0) - truth), strict=True)),
        "scatter_percent": dict(zip(names, percent * values.std(axis=0, ddof=1), strict=True)),
        "claimed_percent": dict(zip(names, percent * claimed.mean(axis=0), strict=True)),
        "coverage": dict(zip(names, inside.mean(axis=0), strict=True)),
        "checks_failed": dict(checks),
        "steps": max(len(r.best.steps) for r in results),
        "seconds": float(np.median(took)),
    }


def _holds(result: OutputFit, name: str) -> bool:
    low, high = result.parameters[name].interval
    return low <= TRUTH[name] <= high


def main() -> None:
    """Write the figures as a table or as JSON."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--noise", type=float, default=2e-9, help="of the position, m")
    parser.add_argument("--free-mass", action="store_true")
    given = parser.parse_args()
    figures = run(given.runs, given.noise, free_mass=given.free_mass)
    give(figures, given.json, lines(figures))


def lines(figures: Mapping[str, object]) -> Iterator[str]:
    """A table of the figures by parameter, and what is of all."""
    parts = {name: part for name, part in figures.items() if isinstance(part, dict)}
    checks = parts.pop("checks_failed")
    yield f"{'':10}" + "".join(f"{name:>18}" for name in parts)
    for name in parts["coverage"]:
        yield f"{name:10}" + "".join(f"{part[name]:18.4f}" for part in parts.values())
    rest = {name: part for name, part in figures.items() if name not in parts}
    yield ", ".join(f"{name} {part}" for name, part in {**rest, "checks_failed": checks}.items())


if __name__ == "__main__":
    main()
