"""How often the 95 % intervals of the library's twins hold their true parameters.

Every axis is identified as it ships, by every method it allows, with new noise each time.

    python benchmarks/library.py            a table
    python benchmarks/library.py --json -   one JSON object
"""

from axisid import Identification, Prefilter, build, identify, load_axis, monte_carlo, twin_record
from axisid.modeling import LIBRARY

#: Where the default does not suit: noise biases the least squares of emps2015 from 40 Hz on.
PREFILTERS = {"emps2015": Prefilter(cutoff=40.0, decimate=20)}


def prefilter_of(name: str) -> Prefilter | None:
    """The filter for the twin of a library axis, where the default does not suit."""
    return PREFILTERS.get(name)


def outside(result: Identification) -> list[tuple[str, str]]:
    """Methods and parameters whose 95 % interval misses the twin's truth."""
    truth = result.record.provenance.truth or {}
    return [
        (method, name)
        for method, estimate in result.estimates.items()
        for name, value in estimate.parameters.items()
        if not value.interval[0] <= truth[name] <= value.interval[1]
    ]


def coverage(name: str, runs: int, jobs: int = 1) -> dict[str, dict[str, float]]:
    """Share of intervals that hold the truth, by method, then by parameter."""
    axis = build(load_axis(name))
    allowed = tuple(identify(axis, twin_record(axis), prefilter_of(name), judge=False).estimates)
    found = monte_carlo(axis, runs, allowed, prefilter=prefilter_of(name), jobs=jobs)
    shares: dict[str, dict[str, float]] = {method: {} for method in allowed}
    for each in found:
        if each.kind == "parameter":
            held = each.coverage[found.plan.chosen].value
            shares[each.method][each.name] = held
    return shares


def main() -> None:
    """Print the table, or write the JSON object."""
    from figures import give, parser_of  # the documentation imports this file from elsewhere

    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=40, help="repetitions (default 40)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    options = parser.parse_args()
    figures = {name: coverage(name, options.runs, options.jobs) for name in LIBRARY}
    lines = [f"share of {options.runs} 95 % intervals that hold the truth, %"]
    for name, methods in figures.items():
        for method, shares in methods.items():
            listed = "  ".join(f"{p} {100 * share:3.0f}" for p, share in shares.items())
            lines.append(f"{name:<16}{method:<8}{listed}")
    give({**figures, "runs": options.runs}, options.json, lines)


if __name__ == "__main__":
    main()
