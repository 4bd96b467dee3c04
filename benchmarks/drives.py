"""Whether drives that limit, round, swallow, delay and lag are identified, and what it does untold.

Machines of a simulator of their own (`machines`), each with a drive that does one thing to its
commands, and one that does all. Declared, the 95 % intervals of the parameters should hold the
truth, and no check should fail; undeclared, it is told by how much the parameters are off, and
which check fails most often. That loops are simulated as by an event integrator is a test.

    python benchmarks/drives.py                     a table
    python benchmarks/drives.py --json -            one JSON object
    python benchmarks/drives.py --only "dead band"  one drive
"""

from collections import Counter
from collections.abc import Mapping

import numpy as np
from figures import give, parser_of
from judged_cases import OF_DRIVE, declared, reference_of
from machines import Machine, records, white

from axisid import AxisidError, Identification, identify, read_record

#: The drives; an encoder of 50 nm and a noise of the control are in all of them.
DRIVES: dict[str, dict[str, float]] = {
    "plain": {},
    "dead band": {"deadband": 0.1},
    "wide dead band": {"deadband": 0.5},
    "rate": {"rate_limit": 300.0},
    "steps": {"quantisation": 0.05},
    "coarse steps": {"quantisation": 0.5},
    "rate, steps, dead band": {"rate_limit": 300.0, "quantisation": 0.05, "deadband": 0.1},
    "all": {
        "rate_limit": 300.0,
        "quantisation": 0.05,
        "deadband": 0.1,
        "delay": 4e-4,
        "lag": 8e-4,
    },
}
_NOISE = 1e-6  # m, of the position


def figures_of(name: str, *, runs: int, seed: int) -> dict[str, object]:
    """Of a drive: shares of intervals that hold, of checks that fail, and errors untold."""
    does = DRIVES[name]
    machine = Machine(
        resolution=5e-8, control_noise=white(2e-3), position_noise=white(_NOISE), **does
    )
    truth = {"M": machine.mass, "Fv": machine.viscous, "Fc": machine.coulomb}
    right = declared(has_offset=False, **{key: getattr(machine, key) for key in OF_DRIVE})
    wrong = declared(has_offset=False)
    held, failing, noticed = Counter[str](), Counter[str](), Counter[str]()
    errors: list[list[float]] = []
    for columns in records(machine, reference_of("moves"), runs, seed):
        result = identify(right, read_record(columns, right))
        failing.update(_failing(result))
        for parameter, value in result.preferred.parameters.items():
            low, high = value.interval
            held[parameter] += low <= truth[parameter] <= high
        try:
            untold = identify(wrong, read_record(columns, wrong))
        except AxisidError as error:
            noticed[f"refused: {type(error).__name__}"] += 1
            continue
        noticed.update(_failing(untold))
        off = untold.preferred.parameters
        errors.append([off[n].corrected / truth[n] - 1 for n in truth])
    return {
        "held_percent": _shares(held, runs, [*truth]),
        "failing_percent": _shares(failing, runs),
        "untold_error_percent": dict(
            zip(truth, (100 * np.mean(errors, axis=0)).tolist(), strict=True)
        )
        if errors
        else {},
        "untold_failing_percent": _shares(noticed, runs),
    }


def _failing(result: Identification) -> list[str]:
    return [check.name for check in result.verdict if check.status == "fail"]


def _shares(
    counted: Mapping[str, int], runs: int, names: list[str] | None = None
) -> dict[str, float]:
    return {name: 100 * counted.get(name, 0) / runs for name in names or sorted(counted)}


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=40, help="repetitions (default 40)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", metavar="NAME", help="one drive")
    options = parser.parse_args()
    chosen = [name for name in DRIVES if options.only in ("", name)]
    figures = {name: figures_of(name, runs=options.runs, seed=options.seed) for name in chosen}
    lines = [
        f"{options.runs} runs: intervals that hold and checks that fail, declared; then untold"
    ]
    for name, found in figures.items():
        told = "; ".join(f"{key.partition('_percent')[0]} {_listed(found[key])}" for key in found)
        lines.append(f"{name:<24}{told}")
    give({**figures, "runs": options.runs}, options.json, lines)


def _listed(values: object) -> str:
    assert isinstance(values, dict)  # of `figures_of`
    return ", ".join(f"{name} {value:.3g}" for name, value in values.items()) or "none"


if __name__ == "__main__":
    main()
