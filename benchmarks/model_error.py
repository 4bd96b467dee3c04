"""How often intervals hold the truth where friction depends on the position and no model says so.

The friction of a machine (`machines`, a simulator of its own) is 3 % larger or smaller over the
position: as a sine of several lengths, or as a sawtooth; its phase differs from run to run. The
axis is declared with plain Coulomb and viscous friction. ``hac`` is the 95 % interval, ``band``
that of the jackknife, and ``shown`` what a user goes by: the band where it is shown, the interval
where it is not.

    python benchmarks/model_error.py                a table
    python benchmarks/model_error.py --json -       one JSON object
    python benchmarks/model_error.py --runs 100     of each case
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from field import Motion, declared_axis, reference_of
from figures import give, parser_of
from machines import Array, Machine, records, white

from axisid import Identification, identify, read_record
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import back_and_forth

VARIATION = 0.03


def _sawtooth(turns: Array) -> Array:
    return np.asarray(2 * (turns - np.floor(turns + 0.5)))


def _sine(turns: Array) -> Array:
    return np.asarray(np.sin(2 * math.pi * turns))


#: By name: what the friction does over the position, in turns, and how long one is, m.
SHAPES: dict[str, tuple[Callable[[Array], Array], float]] = {
    **{f"sine of {length:g} m": (_sine, length) for length in (0.02, 0.05, 0.1, 0.2, 0.35, 0.5)},
    "sawtooth of 0.1 m": (_sawtooth, 0.1),
    "sawtooth of 0.3 m": (_sawtooth, 0.3),
}


def strokes() -> Array:
    """Four speeds on the way, as the public record of EMPS has them, there and back, twice."""
    there = [(0.018, 0.042), (0.064, 0.083), (0.147, 0.125), (0.017, 0.042)]
    every = [
        move
        for sign in (1, -1)
        for length, speed in there
        for move in back_and_forth(speeds=(speed,), acceleration=0.84, seconds=length / speed)[
            (1 - sign) // 2 :: 2
        ]
    ]
    return np.asarray(trajectory(tuple(every) * 2, 1e-3))


MOTIONS: dict[str, Callable[[], Array]] = {
    "moves": lambda: reference_of(Motion("trapezoids"), 1e-3),
    "strokes": strokes,
}


def machine_of(shape: str, runs: int, seed: int) -> Machine:
    """A quiet machine whose friction depends on the position, from another phase in every run."""
    wave, length = SHAPES[shape]
    phase = np.random.default_rng(seed).uniform(size=runs)
    plain = Machine(resolution=5e-8, control_noise=white(2e-3))

    def resistance(_: float, position: Array, velocity: Array) -> Array:
        friction = plain.coulomb * np.sign(velocity) + plain.viscous * velocity
        return np.asarray(VARIATION * wave(position / length + phase) * friction)

    return replace(plain, resistance=resistance)


def coverage(shape: str, motion: str, *, runs: int, seed: int) -> dict[str, dict[str, float]]:
    """Share of runs whose interval holds the truth, by interval and parameter."""
    machine, axis = machine_of(shape, runs, seed), declared_axis()
    truth = {"M": machine.mass, "Fv": machine.viscous, "Fc": machine.coulomb}
    hits = {kind: dict.fromkeys(truth, 0) for kind in ("hac", "band", "shown")}
    for columns in records(machine, MOTIONS[motion](), runs, seed):
        result = identify(axis, read_record(columns, axis), methods=["idm-iv"])
        for name, value in truth.items():
            for kind, (low, high) in _intervals(result, name).items():
                hits[kind][name] += low <= value <= high
    return {kind: {n: k / runs for n, k in of.items()} for kind, of in hits.items()}


def _intervals(result: Identification, name: str) -> dict[str, tuple[float, float]]:
    own = result.preferred.parameters[name].interval
    band = result.diagnosis.bands["idm-iv"][name]
    return {
        "hac": own,
        "band": band.interval,
        "shown": band.interval if band.exceeds else own,
    }


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=60, help="of each case (default 60)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", metavar="SHAPE", help="one shape of friction")
    options = parser.parse_args()
    figures = {
        motion: {
            shape: coverage(shape, motion, runs=options.runs, seed=options.seed)
            for shape in SHAPES
            if options.only in (None, shape)
        }
        for motion in MOTIONS
    }
    lines = []
    for motion, of_motion in figures.items():
        for shape, kinds in of_motion.items():
            listed = "   ".join(
                f"{kind} " + " ".join(f"{n} {100 * share:.0f}" for n, share in of.items())
                for kind, of in kinds.items()
            )
            lines.append(f"{motion:<9}{shape:<20}{listed}")
    give({"runs": options.runs, **figures}, options.json, lines)


if __name__ == "__main__":
    main()
