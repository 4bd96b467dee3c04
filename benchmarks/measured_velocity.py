"""Twins with a measured velocity: what the check makes of it, and how often intervals hold.

Right ones have a tachometer with white noise, with ripple that goes with the position, with coarse
steps, and beside a noisy encoder; wrong ones are scaled by 1.05, three samples late, or off zero
by 3 % of the velocity's root mean square. Counted is how often `measured velocity` fails; with
`--judged`, how often any check of a right one does. Coverage is of instruments under the default
filter; of the twins of `ALONE` the position is left out too, and there the check is by the loop.

    python benchmarks/measured_velocity.py            tables
    python benchmarks/measured_velocity.py --json -   one JSON object
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from axisid import Record, build, identify, load_axis, twin_record
from axisid.estimation.diagnostics import ColumnComparison, compared_motion

Array = NDArray[np.float64]

#: Noise of the tachometer by the velocity's root mean square; ripple and steps likewise.
NOISE, RIPPLE, STEP = 0.01, 0.01, 0.02
WAVES = 40  # of the ripple over the way
AXES = ("emps", "pendulum", "vertical_screw", "belt_axis", "rotary_table", "linear_motor")
ALONE = ("emps", "belt_axis")


def _twin(name: str, seed: int, noise: float = NOISE, encoder: float = 1.0) -> Record:
    axis = build(load_axis(name))
    exact = _SIZES.get(name)
    if exact is None:
        velocity = np.asarray(twin_record(axis, velocity_noise=0.0).velocity)
        exact = _SIZES[name] = float(np.sqrt(np.mean(velocity**2)))
    experiment = axis.axis.experiment
    position_noise = encoder * (experiment.position_noise if experiment else 0.0)
    return twin_record(axis, seed=seed, position_noise=position_noise, velocity_noise=noise * exact)


_SIZES: dict[str, float] = {}


def _rms(record: Record) -> float:
    return float(np.sqrt(np.mean(np.asarray(record.velocity) ** 2)))


def _rippled(name: str, seed: int) -> Record:
    record = _twin(name, seed, 0.1 * NOISE)
    velocity, phase = np.asarray(record.velocity), np.random.default_rng(seed).uniform(0, 2 * np.pi)
    turns = WAVES * record.position / float(np.ptp(record.position))
    ripple = RIPPLE * np.sin(2 * np.pi * turns + phase)
    return replace(record, velocity=velocity * (1 + ripple))


def _coarse(name: str, seed: int) -> Record:
    record = _twin(name, seed, 0.0)
    step = STEP * _rms(record)
    return replace(record, velocity=step * np.round(np.asarray(record.velocity) / step))


RIGHT: dict[str, Callable[[str, int], Record]] = {
    "white noise": _twin,
    "ripple": _rippled,
    "coarse steps": _coarse,
    "noisy encoder": lambda name, seed: _twin(name, seed, encoder=5.0),
}


def _scaled(name: str, seed: int) -> Record:
    record = _twin(name, seed)
    return replace(record, velocity=1.05 * np.asarray(record.velocity))


def _moved(name: str, seed: int) -> Record:
    record = _twin(name, seed)
    return replace(record, velocity=np.asarray(record.velocity) + 0.03 * _rms(record))


#: With what has to be found beyond what it may be.
WRONG: dict[str, tuple[Callable[[str, int], Record], str]] = {
    "gain 1.05": (_scaled, "factor"),
    "3 samples late": (lambda name, seed: _twin(name, seed).shifted(velocity=3), "delay"),
    "offset 3 %": (_moved, "offset"),
}


def alarms(runs: int) -> dict[str, dict[str, float]]:
    """Share of twins on which the check fails, or of wrong ones fails for its cause, by axis."""
    found: dict[str, dict[str, float]] = {}
    for kind, make in RIGHT.items():
        found[kind] = {
            n: _share([_compared(make(n, s)).worst > 1 for s in _seeds(runs)]) for n in AXES
        }
    for kind, (make, cause) in WRONG.items():
        found[kind] = {
            n: _share([_compared(make(n, s)).distances[cause] > 1 for s in _seeds(runs)])
            for n in AXES
        }
    return found


def alone(name: str, kind: str, factor: float, runs: int) -> float:
    """Share of twins without a position whose velocity, times a factor, fails beside the loop."""
    axis, failed = build(load_axis(name)), []
    for seed in _seeds(runs):
        record = RIGHT[kind](name, seed)
        velocity = factor * np.asarray(record.velocity)
        record = replace(record, position=np.empty(0), velocity=velocity)
        result = identify(axis, record, methods=("idm-iv",))
        failed += [c.status == "fail" for c in result.verdict if c.name == "measured velocity"]
    return _share(failed)


def judged(kind: str, name: str, runs: int) -> dict[str, float]:
    """Share of right twins on which each check fails, by instruments."""
    axis, failed = build(load_axis(name)), Counter[str]()
    for seed in _seeds(runs):
        result = identify(axis, RIGHT[kind](name, seed), methods=("idm-iv",))
        failed.update(check.name for check in result.verdict if check.status == "fail")
    return {check: count / runs for check, count in failed.items()}


def _seeds(runs: int) -> range:
    return range(1, runs + 1)


def _share(failed: list[bool]) -> float:
    return sum(failed) / len(failed)


def _compared(record: Record) -> ColumnComparison:
    found = compared_motion(record, "velocity")
    if not isinstance(found, ColumnComparison):
        raise SystemExit(found.reason)
    return found


def coverage(
    name: str, kind: str, runs: int, *, alone: bool = False, method: str = "idm-iv"
) -> dict[str, float]:
    """Share of 95 % intervals that hold the truth, by parameter."""
    axis = build(load_axis(name))
    held = dict.fromkeys(axis.names, 0)
    for seed in _seeds(runs):
        record = RIGHT[kind](name, seed)
        truth = record.provenance.truth or {}
        if alone:
            record = replace(record, position=np.empty(0))
        result = identify(axis, record, methods=(method,))
        for parameter, value in result.estimates[method].parameters.items():
            held[parameter] += value.interval[0] <= truth[parameter] <= value.interval[1]
    return {parameter: count / runs for parameter, count in held.items()}


def _coverages(runs: int) -> dict[str, dict[str, float]]:
    return {
        f"{name}, {kind}{', velocity alone' * is_alone}": coverage(name, kind, runs, alone=is_alone)
        for kind in RIGHT
        for name in AXES
        for is_alone in (False, True)[: 1 + (name in ALONE)]
    }


def _by_loop(runs: int) -> dict[str, float]:
    return {
        f"{name}, {kind}, times {factor:g}": alone(name, kind, factor, runs)
        for kind in RIGHT
        for name in ALONE
        for factor in (1.0, 1.05)
    }


def _verdicts(runs: int) -> dict[str, dict[str, float]]:
    return {f"{name}, {kind}": judged(kind, name, runs) for kind in RIGHT for name in AXES}


def _listed(share: float | dict[str, float]) -> str:
    """A share, or those by name, in percent."""
    if isinstance(share, float):
        return f"{100 * share:.0f}"
    return "  ".join(f"{name} {100 * each:3.0f}" for name, each in share.items()) or "none"


def main() -> None:
    """Print the tables, or write the JSON object."""
    from figures import give, parser_of  # the documentation imports this file from elsewhere

    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=40, help="of each kind and axis (default 40)")
    parser.add_argument("--covered", type=int, default=0, help="of coverage (default none)")
    parser.add_argument("--judged", type=int, default=0, help="of whole verdicts (default none)")
    parser.add_argument("--alone", type=int, default=0, help="of velocity alone (default none)")
    options = parser.parse_args()
    checked = alarms(options.runs)
    lines = [
        f"share of {options.runs} twins on which the check fails (wrong ones: for their cause), %"
    ]
    lines += [f"{'':<16}" + "".join(f"{name:>16}" for name in AXES)]
    for kind, shares in checked.items():
        lines.append(f"{kind:<16}" + "".join(f"{100 * shares[n]:>16.0f}" for n in AXES))
    tree: dict[str, object] = {"alarms": checked, "runs": options.runs}
    studies: tuple[tuple[str, int, Callable[[int], dict[str, Any]], str], ...] = (
        ("coverage", options.covered, _coverages, "95 % intervals that hold the truth"),
        ("alone", options.alone, _by_loop, "twins of velocity alone on which the check fails"),
        ("verdicts", options.judged, _verdicts, "right twins on which a check fails"),
    )
    for key, runs, study, what in studies:
        found = tree[key] = study(runs) if runs else {}
        lines += [f"share of {runs} {what}, %"] * bool(runs)
        lines += [f"{label:<50}{_listed(share)}" for label, share in found.items()]
    give(tree, options.json, lines)


if __name__ == "__main__":
    main()
