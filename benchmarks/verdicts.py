"""What becomes of right machines and of wrong ones: coverage, false alarms, and what is named.

The machines are those of `field`, simulated apart from the program, half of the right ones drawn
from the seed. Each record is identified, and fitted by each output, with nothing asked for.

Of a right machine: ``hold``, how many of the 95 % intervals hold the truth, %; ``bias``, the mean
error in deviations of the parameter where it is largest (by chance up to 0.6 in 6 runs); ``fail``,
the runs in which a check fails; ``not``, those not to be believed; ``refused``. Of a fault:
``noticed``, the runs in which a check fails; ``named``, those in which the gravest check that fails
says what is wrong; ``silent``, those in which nothing fails and a value is more than four
deviations off; ``refused``.

    python benchmarks/verdicts.py --jobs 2                  6 records a machine, and a fault
    python benchmarks/verdicts.py --jobs 2 --runs 40        for a release
    python benchmarks/verdicts.py --seed 7                  other machines, other noise
    python benchmarks/verdicts.py --only Stribeck           cases by a word: "drawn", "; stage"
    python benchmarks/verdicts.py --by both                 another: a fit of both outputs
    python benchmarks/verdicts.py --json -                  one JSON object, with every run
"""

import re
from argparse import Namespace
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache, partial
from zlib import crc32

import numpy as np
from field import FIXED, Case, drawn, wrong
from figures import give, parser_of

from axisid import AxisidError, Record, fit, identify
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.verdict_checks import Check, belief, by_weight
from axisid.support.jobs import Failure, run_jobs

OUTPUTS = {
    "control": ["control"],
    "position": ["position"],
    "both": ["control", "position"],
    "open loop": ["open-loop"],
}
ESTIMATORS = ("identify", "control", "position", "open loop")
#: Beyond so many deviations a value that nothing speaks against is silently wrong.
SILENT = 4.0


@dataclass(frozen=True, kw_only=True)
class Run:
    """What an estimator made of a record.

    Attributes
    ----------
    belief : str
        Or ``refused``.
    failing : list of str
        Names of the checks that fail, the gravest first.
    said : str
        What the first of them says, or why it is refused.
    errors : dict of str to float
        Of each parameter, in its deviations.
    held : dict of str to bool
        Whether its 95 % interval holds the truth.
    """

    belief: str
    failing: list[str]
    said: str
    errors: dict[str, float]
    held: dict[str, bool]

    @property
    def is_far(self) -> bool:
        """Whether a value is beyond what its deviation explains."""
        return any(abs(error) > SILENT for error in self.errors.values())


def run_of(axis: GeneratedAxis, record: Record, by: str, truth: Mapping[str, float]) -> Run:
    """Identify or fit a record, and compare it with the truth."""
    try:
        if by == "identify":
            result = identify(axis, record)
            checks: Sequence[Check] = result.verdict
            values = {n: result.preferred.parameters[n] for n in truth}
            of = {n: (v.corrected, v.deviation, v.interval) for n, v in values.items()}
        else:
            fitted = fit(axis, record, output=OUTPUTS[by])
            checks = fitted.checks
            of = {n: (v.value, v.deviation, v.interval) for n in truth for v in [fitted[n]]}
    except AxisidError as error:
        return Run(belief="refused", failing=[], said=str(error), errors={}, held={})
    failing = by_weight([check for check in checks if check.status == "fail"])
    names = [check.name for check in failing]
    return Run(
        belief=belief(checks),
        failing=names,
        said=str(failing[0].meaning) if failing else "",
        errors={n: float((value - truth[n]) / sd) for n, (value, sd, _) in of.items()},
        held={n: bool(low <= truth[n] <= high) for n, (_, _, (low, high)) in of.items()},
    )


@cache
def cases(seed: int) -> dict[str, Case]:
    """All by name: the right ones, as many of them drawn as are fixed, and the wrong ones."""
    return FIXED | drawn(seed, len(FIXED)) | wrong(seed)


def runs_of(
    name: str, *, runs: int, seed: int, by: Sequence[str] = ESTIMATORS
) -> dict[str, list[Run]]:
    """What each estimator makes of so many records of a case; of a wrong one a third as many."""
    case = cases(seed)[name]
    number = -(-runs // 3) if case.fault else runs
    made: dict[str, list[Run]] = {each: [] for each in by}
    # Each case has noise of its own.
    for record in case.records(number, crc32(f"{seed} {name}".encode())):
        for each, listed in made.items():
            listed.append(run_of(case.axis, record, each, case.truth))
    return made


def right_figures(runs: Sequence[Run]) -> dict[str, float]:
    """Of right machines."""
    held = [each for run in runs for each in run.held.values()]
    names = {name for run in runs for name in run.errors}
    biases = [np.mean([r.errors[name] for r in runs if name in r.errors]) for name in names]
    return {
        "runs": len(runs),
        "hold": 100 * float(np.mean(held)) if held else np.nan,
        "bias": float(np.abs(biases).max()) if biases else np.nan,
        "fail": sum(bool(run.failing) for run in runs),
        "not": sum(run.belief == "not believed" for run in runs),
        "refused": sum(run.belief == "refused" for run in runs),
    }


def wrong_figures(runs: Sequence[Run], named: str) -> dict[str, float]:
    """Of wrong machines, of which something has to be said."""
    return {
        "runs": len(runs),
        "noticed": sum(bool(run.failing) for run in runs),
        "named": sum(bool(run.failing and re.search(named, run.said, re.DOTALL)) for run in runs),
        "silent": sum(not run.failing and run.is_far for run in runs),
        "refused": sum(run.belief == "refused" for run in runs),
    }


def table(done: Mapping[str, Mapping[str, list[Run]]], every: Mapping[str, Case]) -> Iterator[str]:
    """The lines of both tables, of cases by name."""
    by = list(next(iter(done.values())))
    right = [name for name in done if not every[name].fault]
    faults: dict[str, list[str]] = {}
    for name in done:
        if every[name].fault:
            faults.setdefault(every[name].fault, []).append(name)

    def all_of(names: Iterable[str], each: str) -> list[Run]:
        return [run for name in names for run in done[name][each]]

    def line(what: str, form: str, figures: Iterable[Mapping[str, float]]) -> str:
        return f"{what:<60}" + "".join(f"{form.format(**one):>23}" for one in figures)

    head = "".join(f"{each:>23}" for each in by)
    if right:
        form = "{hold:3.0f} {bias:4.1f} {fail:3.0f} {not:3.0f} {refused:2.0f}"
        yield f"{'right machines: hold % bias fail not refused':<60}{head}"
        for name in right:
            yield line(name, form, (right_figures(done[name][each]) for each in by))
        yield line("all", form, (right_figures(all_of(right, each)) for each in by))
        failing = Counter(f"{e}: {c}" for e in by for r in all_of(right, e) for c in r.failing)
        yield f"checks that fail on right machines: {dict(failing.most_common())}"
    if faults:
        form = "{noticed:3.0f} {named:3.0f} {silent:3.0f} {refused:2.0f} of {runs:3.0f}"
        yield f"{'faults: noticed named silent refused':<60}{head}"
        counted = {
            fault: [wrong_figures(all_of(names, each), every[names[0]].named) for each in by]
            for fault, names in faults.items()
        }
        for fault, figures in counted.items():
            yield line(fault, form, figures)
        totals = (
            {n: sum(f[k][n] for f in counted.values()) for n in figures[k]} for k in range(len(by))
        )
        yield line("all", form, totals)


def tell(
    work: Callable[[str], dict[str, list[Run]]],
    names: Sequence[str],
    every: Mapping[str, Case],
    options: Namespace,
) -> None:
    """Work on cases by their names, and print the tables, or write the JSON object."""
    found: dict[str, dict[str, list[Run]]] = {}
    for place, made in run_jobs(work, names, total=len(names), jobs=options.jobs):
        if isinstance(made, Failure):
            raise SystemExit(f"{names[place]}: {made}")
        found[names[place]] = made
    done = {name: found[name] for name in names}
    tree = {n: {b: [asdict(r) for r in each] for b, each in of.items()} for n, of in done.items()}
    give(tree, options.json, table(done, every))


def main() -> None:
    """Print the tables, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=6, help="of each right machine (default 6)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", metavar="WORD", default="", help="cases whose name holds it")
    parser.add_argument("--by", default=",".join(ESTIMATORS), help="estimators, by commas")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    options = parser.parse_args()
    names = [name for name in cases(options.seed) if options.only in name]
    work = partial(runs_of, runs=options.runs, seed=options.seed, by=tuple(options.by.split(",")))
    tell(work, names, cases(options.seed), options)


if __name__ == "__main__":
    main()
