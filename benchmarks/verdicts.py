"""What becomes of right machines and of wrong ones: coverage, false alarms, and what is named.

The machines are those of `field`, simulated apart from the program, half of the right ones drawn
from the seed. Each record is identified, and fitted by each output, with nothing asked for.

Of a right machine: ``hold``, how many of the 95 % intervals hold the truth, %; ``bias``, the mean
of the largest parameter's error in deviations; ``fail``, the runs in which a check fails, or which
are refused; ``not``, those that are not to be believed. Of a wrong one: ``noticed``, the runs in
which a check fails; ``named``, those in which the gravest check that fails says what is wrong;
``silent``, those in which nothing fails and a value is more than four deviations off, though a
record can show what is wrong.

    python benchmarks/verdicts.py --jobs 2                  the table, 6 records a case
    python benchmarks/verdicts.py --jobs 2 --runs 40        for a release
    python benchmarks/verdicts.py --seed 7                  other machines, other noise
    python benchmarks/verdicts.py --only Stribeck           the cases whose name holds a word
    python benchmarks/verdicts.py --by identify,both        other estimators: control and position
    python benchmarks/verdicts.py --json -                  one JSON object, with every run
"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache, partial

import numpy as np
from field import FIXED, Case, drawn, wrong
from figures import give, parser_of

from axisid import AxisidError, Record, fit, identify
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import belief, by_weight
from axisid.support.jobs.run import run_jobs

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
        What the first of them says, or why there is no result.
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
            checks: Iterable[Check] = result.verdict
            values = {n: result.preferred.parameters[n] for n in truth}
            of = {n: (v.corrected, v.deviation, v.interval) for n, v in values.items()}
        else:
            fitted = fit(axis, record, output=OUTPUTS[by])
            checks = fitted.checks
            of = {n: (v.value, v.deviation, v.interval) for n in truth for v in [fitted[n]]}
    except AxisidError as error:
        return Run(belief="refused", failing=["refused"], said=str(error), errors={}, held={})
    failing = by_weight([check for check in checks if check.status == "fail"])
    names = [check.name for check in failing]
    return Run(
        belief=belief(names),
        failing=names,
        said=str(failing[0].note) if failing else "",
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
    for record in case.records(number, seed):
        for each, listed in made.items():
            listed.append(run_of(case.axis, record, each, case.truth))
    return made


def right_figures(runs: Sequence[Run]) -> dict[str, float]:
    """Of a right machine."""
    held = [each for run in runs for each in run.held.values()]
    errors = [list(run.errors.values()) for run in runs if run.errors]
    return {
        "runs": len(runs),
        "hold": 100 * float(np.mean(held)) if held else np.nan,
        "bias": float(np.abs(np.mean(errors, axis=0)).max()) if errors else np.nan,
        "fail": sum(bool(run.failing) for run in runs),
        "not": sum(run.belief == "not believed" for run in runs),
    }


def wrong_figures(runs: Sequence[Run], case: Case) -> dict[str, float]:
    """Of a wrong machine."""
    return {
        "runs": len(runs),
        "noticed": sum(bool(run.failing) for run in runs),
        "named": sum(bool(run.failing and re.search(case.named, run.said)) for run in runs),
        "silent": sum(case.is_knowable and not run.failing and run.is_far for run in runs),
    }


def _summed(figures: Iterable[Mapping[str, float]], names: Sequence[str]) -> dict[str, float]:
    listed = list(figures)
    return {name: sum(each[name] for each in listed) for name in names}


def table(done: Mapping[str, Mapping[str, list[Run]]], seed: int) -> Iterator[str]:
    """The lines of both tables."""
    every = cases(seed)
    by = list(next(iter(done.values())))
    right = [name for name in done if not every[name].fault]
    yield from _block(
        "right machines: hold % / bias / fail / not believed",
        by,
        {n: {b: right_figures(done[n][b]) for b in by} for n in right},
        "{hold:3.0f} {bias:4.1f} {fail:2.0f} {not:2.0f}",
    )
    faults: dict[str, dict[str, dict[str, float]]] = {}
    for fault in dict.fromkeys(every[n].fault for n in done if n not in right):
        of_fault = [n for n in done if every[n].fault == fault]
        faults[fault] = {
            b: _summed(
                (wrong_figures(done[n][b], every[n]) for n in of_fault),
                ("runs", "noticed", "named", "silent"),
            )
            for b in by
        }
    yield from _block(
        "wrong machines: noticed / named / silent",
        by,
        faults,
        "{noticed:3.0f} {named:3.0f} {silent:3.0f} of {runs:2.0f}",
    )
    failing = Counter(f"{b}: {c}" for n in right for b in by for r in done[n][b] for c in r.failing)
    yield f"checks that fail on right machines: {dict(failing.most_common())}"


def _block(
    title: str, by: Sequence[str], rows: Mapping[str, Mapping[str, Mapping[str, float]]], form: str
) -> Iterator[str]:
    if not rows:
        return
    yield f"{title:<60}" + "".join(f"{each:>19}" for each in by)
    for name, figures in rows.items():
        yield f"{name:<60}" + "".join(f"{form.format(**figures[each]):>19}" for each in by)
    total = {each: _total([figures[each] for figures in rows.values()]) for each in by}
    yield f"{'all':<60}" + "".join(f"{form.format(**total[each]):>19}" for each in by) + "\n"


def _total(rows: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Counts added, shares and biases as their means."""
    return {
        name: float((np.nanmean if name in ("hold", "bias") else np.sum)([r[name] for r in rows]))
        for name in rows[0]
    }


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
    done: dict[str, dict[str, list[Run]]] = {}
    for outcome in run_jobs(work, names, total=len(names), jobs=options.jobs):
        if outcome.value is None:
            raise SystemExit(f"{names[outcome.place]}: {outcome.failure}")
        done[names[outcome.place]] = outcome.value
    done = {name: done[name] for name in names}
    tree = {n: {b: [asdict(r) for r in each] for b, each in of.items()} for n, of in done.items()}
    give(tree, options.json, table(done, options.seed))


if __name__ == "__main__":
    main()
