"""How often 95 % intervals hold the truth: classical and autocorrelation-consistent ones.

The motion is three times that of the paper's twin, without position noise; the recorded control has
either white noise or a ripple whose correlation dies out over 50 ms (first-order autoregressive).
Every run is a whole IDM-LS identification, with one row for ten samples; both intervals are of
Student's distribution. Decimation colours white noise a little. The seed is fixed.

    python benchmarks/calibration.py            a table
    python benchmarks/calibration.py --json -   one JSON object
"""

from figures import give, parser_of

from axisid import Prefilter, build, load_axis, monte_carlo
from axisid.estimation import Chain

NOISE, CORRELATION_TIME = 5.0, 0.05  # N, s
REPEATED = 3  # times the motion of the twin: as long as the EMPS record
FILTER = Prefilter(cutoff=60.0, decimate=10, drop=(50, 50))
INTERVALS = ("iid", "hac")
COLOURS = {"white": 0.0, "coloured": CORRELATION_TIME}


def coverage(runs: int, seed: int = 1, jobs: int = 1) -> dict[str, dict[str, float]]:
    """Share of runs whose interval holds the truth, by noise and interval, then by parameter."""
    axis = build(load_axis("emps2015"))
    if axis.axis.experiment is None:
        raise SystemExit("the axis has no experiment")
    shares: dict[str, dict[str, float]] = {}
    for colour, time in COLOURS.items():
        found = monte_carlo(
            axis,
            runs,
            "idm-ls",
            noise=Chain(control=((time, NOISE / axis.axis.drive.gain),)),
            moves=REPEATED * axis.axis.experiment.moves,
            prefilter=FILTER,
            seed=seed,
            jobs=jobs,
        )
        for of in INTERVALS:
            shares[f"{colour}_{of}"] = {
                each.name: each.coverage[of].value for each in found.figures
            }
    return shares


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=2000, help="repetitions (default 2000)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    options = parser.parse_args()
    figures = coverage(options.runs, jobs=options.jobs)
    lines = [f"share of {options.runs} 95 % intervals that hold the truth"]
    for name, shares in figures.items():
        listed = "  ".join(f"{p} {100 * share:5.1f} %" for p, share in shares.items())
        lines.append(f"{name:<14}{listed}")
    give({**figures, "runs": options.runs}, options.json, lines)


if __name__ == "__main__":
    main()
