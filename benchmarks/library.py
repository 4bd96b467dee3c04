"""How often the 95 % intervals of the library's twins hold their true parameters.

Every axis is identified by every method it allows, with new noise each time. The low-pass lets all
of the motion through, and the decimation, which treats force and motion alike, takes out the noise:
what a low-pass rounds at each reversal of Coulomb friction would bias the inertia by more than its
deviation. The ends, where the axis is at rest, are dropped. The EMPS twins are sampled at 4 kHz for
the same reason, with the noise of a fine encoder.

    python benchmarks/library.py            a table
    python benchmarks/library.py --json -   one JSON object
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path

from axisid import (
    LIBRARY,
    Identification,
    Prefilter,
    build,
    cascade_pd,
    cascade_pd_averaged,
    identify,
    load_axis,
    twin_record,
)
from axisid.modeling import Axis

PREFILTER = Prefilter(cutoff=800.0, decimate=40, hold="zoh", drop=(200, 200))
PREFILTERS = {
    "emps2015": Prefilter(cutoff=600.0, decimate=80, hold="zoh", drop=(200, 200)),
    "emps": Prefilter(cutoff=600.0, decimate=80, hold="zoh", drop=(200, 200)),
    "valve": Prefilter(cutoff=2000.0, decimate=200, hold="zoh", drop=(200, 200)),
}
LAWS = {"emps2015": cascade_pd, "emps": cascade_pd_averaged}
NOISE = {"emps2015": 2e-7, "emps": 2e-7}  # m


def case(name: str) -> Axis:
    """A library axis as it is identified here."""
    axis = load_axis(name)
    if name not in LAWS or axis.experiment is None:
        return axis
    return replace(
        axis,
        control=LAWS[name](kp=160.18, kv=243.45, period=2.5e-4),
        experiment=replace(axis.experiment, position_noise=NOISE[name]),
    )


def outside(result: Identification) -> list[tuple[str, str]]:
    """Methods and parameters whose 95 % interval misses the twin's truth."""
    truth = result.record.provenance.truth or {}
    return [
        (method, name)
        for method, estimate in result.estimates.items()
        for name, value in estimate.parameters.items()
        if not value.interval[0] <= truth[name] <= value.interval[1]
    ]


def coverage(name: str, seeds: range) -> dict[str, dict[str, float]]:
    """Share of intervals that hold the truth, by method, then by parameter."""
    axis = build(case(name))
    misses: dict[tuple[str, str], int] = {}
    for seed in seeds:
        record = twin_record(axis, seed=seed)
        result = identify(axis, record, PREFILTERS.get(name, PREFILTER))
        for miss in outside(result):
            misses[miss] = misses.get(miss, 0) + 1
    return {
        method: {p: 1 - misses.get((method, p), 0) / len(seeds) for p in axis.names}
        for method in result.estimates
    }


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--json", metavar="FILE", help="write one JSON object; - for stdout")
    parser.add_argument("--runs", type=int, default=40, help="repetitions (default 40)")
    options = parser.parse_args()
    figures = {name: coverage(name, range(1, options.runs + 1)) for name in LIBRARY}
    text = json.dumps({**figures, "runs": options.runs}, indent=2)
    if options.json == "-":
        print(text)
    elif options.json:
        Path(options.json).write_text(text + "\n")
    else:
        print(f"share of {options.runs} 95 % intervals that hold the truth, %")
        for name, methods in figures.items():
            for method, shares in methods.items():
                listed = "  ".join(f"{p} {100 * share:3.0f}" for p, share in shares.items())
                print(f"{name:<16}{method:<8}{listed}")


if __name__ == "__main__":
    main()
