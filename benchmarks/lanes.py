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
BLOCK = 32  # twins that a study simulates and identifies together
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
    noise = np.random.default_rng(seed).standard_normal((len(ref), count))
    noise *= NOISE
    sets, wanted = np.tile(TRUTH, (count, 1)), ("position", "control")
    made = simulate_batch(axis, sets, ref, PERIOD, position_noise=noise, wanted=wanted, threads=1)
    noise += made["position"]
    return RecordLanes(reference=ref, position=noise, control=made["control"], period=PERIOD)


def measure(blocks: int = 4, times: int = 3) -> dict[str, float]:
    """The figures, by name."""
    axis = build(load_axis("emps2015"))
    record = twins(axis, 1, 1).record(0)
    figures: dict[str, float] = {}
    for name, prefilter in FILTERS.items():

        def alone(prefilter: Prefilter | None = prefilter) -> None:
            _ = identify(axis, record, prefilter, ["idm-iv"])["idm-iv"].parameters

        def study(prefilter: Prefilter | None = prefilter) -> float:
            """Block by block, as a study does."""
            together = 0
            for seed in range(blocks):
                how = identify_lanes(axis, twins(axis, BLOCK, seed), prefilter=prefilter).how
                together += how.count("side by side")
            return together / (blocks * BLOCK)

        end = "" if name == "published" else f"_{name}_filter"
        figures[f"identify_iv_ms{end}"] = cpu_ms(alone, 3 * times)
        figures[f"monte_carlo_ms_per_run{end}"] = cpu_ms(study, times) / (blocks * BLOCK)
        figures[f"side_by_side_share{end}"] = study()
    return figures


TARGETS = {
    "monte_carlo_ms_per_run": "at most 4",
    "monte_carlo_ms_per_run_default_filter": "at most 4",
}


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--blocks", type=int, default=4, help="of 32 twins (default 4)")
    options = parser.parse_args()
    figures = measure(options.blocks)
    lines = (f"{n:<40}{v:>10.4g}  {TARGETS.get(n, '')}".rstrip() for n, v in figures.items())
    give(figures, options.json, lines)


if __name__ == "__main__":
    main()
