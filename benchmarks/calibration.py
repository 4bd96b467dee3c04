"""How often 95 % intervals hold the truth: classical and autocorrelation-consistent ones.

The motion is three times that of the paper's twin, without position noise; the record has either
white noise on its force or a ripple whose correlation dies out over 50 ms (first-order
autoregressive). Every run is a whole IDM-LS fit: the force is decimated with the regressor, 1 of
10, and both intervals are formed with Student's distribution. Decimation colours white noise a
little. The seed is fixed.

    python benchmarks/calibration.py            a table
    python benchmarks/calibration.py --json -   one JSON object
"""

from figures import give, parser_of

from axisid import Prefilter, TwinNoise, build, load_axis, monte_carlo

NOISE = 5.0  # N
COLOURS = {"white": 0.0, "coloured": 0.05}  # correlation time, s
REPEATED = 3  # times the motion of the twin: as long as the EMPS record
FILTER = Prefilter(cutoff=60.0, decimate=10, drop=(50, 50), reversals="keep")
INTERVALS = ("iid", "hac")


def coverage(runs: int, seed: int = 1, jobs: int = 1) -> dict[str, dict[str, float]]:
    """Share of runs whose interval holds the truth, by noise and interval, then by parameter."""
    axis = build(load_axis("emps2015"))
    if axis.axis.experiment is None:
        raise SystemExit("the axis has no experiment")
    shares: dict[str, dict[str, float]] = {}
    for colour, time in COLOURS.items():
        control = NOISE / axis.axis.drive.gain
        found = monte_carlo(
            axis,
            runs,
            "idm-ls",
            prefilter=FILTER,
            noise=TwinNoise(position=0.0, control=control, correlation_time=time),
            moves=REPEATED * axis.axis.experiment.moves,
            seed=seed,
            jobs=jobs,
        )
        for of in INTERVALS:
            named = {each.estimand.name: each.coverage[of].value for each in found}
            shares[f"{colour}_{of}"] = named
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
