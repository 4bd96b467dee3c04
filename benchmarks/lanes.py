"""What one identification costs, alone and among lanes: figures of `scale.py`.

Twins of emps2015 over a motion of the EMPS record's length (24 841 samples at 1 kHz), instruments
with the published filter and with the default one, intervals and the filter's bias included; the
simulation of the twins is in the figure by run. CPU time of this process.

    python benchmarks/lanes.py            a table
    python benchmarks/lanes.py --json -   one JSON object
"""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from figures import give, parser_of
from simulation import PERIOD, reference

from axisid import Prefilter, build, identify, load_axis
from axisid.codegen import GeneratedAxis
from axisid.estimation import RecordLanes, identify_lanes, simulate_batch

TRUTH = np.array([100.2, 236.9, 24.8])
NOISE = 3.8e-6
PUBLISHED = Prefilter(cutoff=60.0, decimate=10, drop=(49, 0), hold="raw", reversals="keep")
FILTERS = {"published": PUBLISHED, "default": None}


def cpu_ms(run: Callable[[], Any], times: int) -> float:
    """Median CPU time of a run, ms, after one that is not counted."""
    run()
    taken = []
    for _ in range(times):
        begin = time.process_time()
        run()
        taken.append(1e3 * (time.process_time() - begin))
    return float(np.median(taken))


def twins(axis: GeneratedAxis, count: int, seed: int) -> RecordLanes:
    """Records of twins that differ in their noise."""
    ref = reference()
    noise = NOISE * np.random.default_rng(seed).standard_normal((len(ref), count))
    sets, wanted = np.tile(TRUTH, (count, 1)), ("position", "control")
    made = simulate_batch(axis, sets, ref, PERIOD, position_noise=noise, wanted=wanted, threads=1)
    position = made["position"] + noise
    return RecordLanes(reference=ref, position=position, control=made["control"], period=PERIOD)


def measure(runs: int = 64, times: int = 3) -> dict[str, float]:
    """The figures, by name."""
    axis = build(load_axis("emps2015"))
    record = twins(axis, 1, 1).record(0)
    figures: dict[str, float] = {}
    for name, prefilter in FILTERS.items():

        def alone(prefilter: Prefilter | None = prefilter) -> None:
            _ = identify(axis, record, prefilter, ["idm-iv"])["idm-iv"].parameters

        def study(prefilter: Prefilter | None = prefilter) -> float:
            how = identify_lanes(axis, twins(axis, runs, 2), prefilter=prefilter).how
            return how.count("side by side") / runs

        end = "" if name == "published" else f"_{name}_filter"
        figures[f"identify_iv_ms{end}"] = cpu_ms(alone, 3 * times)
        figures[f"monte_carlo_ms_per_run{end}"] = cpu_ms(study, times) / runs
        figures[f"side_by_side_share{end}"] = study()
    return figures


TARGETS = {"monte_carlo_ms_per_run": "at most 4"}


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=64, help="twins (default 64)")
    options = parser.parse_args()
    figures = measure(options.runs)
    lines = (f"{n:<40}{v:>10.4g}  {TARGETS.get(n, '')}".rstrip() for n, v in figures.items())
    give(figures, options.json, lines)


if __name__ == "__main__":
    main()
