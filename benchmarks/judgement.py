"""How often each check fails on right models, and how often a wrong model is named.

Machines with noises of several kinds (`machines`, a simulator of its own) and the library's twins
are identified with nothing asked for. On a right model no check should fail in more than 2 % of the
runs; those with a level of their own: that level. A wrong model is ``noticed`` where any check
fails, and ``named`` where one that fails says what is wrong. Where reversals are kept, the filter
moves estimates most, which its check may say; there it is the intervals that count. Of least
squares it is counted how often an interval is said to miss for noise, and how often it does.
The library's twins without noise are right to 0.003 %: nothing should fail there at all.

What misses its aim by more than chance would (5 %, one-sided, of so many runs) is listed at the
end, and is ``missed`` of the JSON object: checks that fail on right models, intervals that hold
less often than 93 % (85 % where reversals are kept), wrong models that are named in less than 95 %.

    python benchmarks/judgement.py                    a table
    python benchmarks/judgement.py --json -           one JSON object
    python benchmarks/judgement.py --only "sines"     the cases of a name
    python benchmarks/judgement.py --kind wrong       those of a kind
"""

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from figures import give, parser_of
from judged_cases import (
    ALONE,
    CASES,
    FIELD,
    FREE,
    KEPT,
    LOGGED,
    OUTPUT_ERROR,
    RIGHT,
    WRONG,
    Case,
    axis_of,
    reference_of,
)
from library import prefilter_of
from machines import Array, records
from scipy.stats import binom

from axisid import (
    AxisidError,
    Identification,
    Prefilter,
    Record,
    build,
    identify,
    load_axis,
    read_record,
    twin_record,
)
from axisid.modeling import LIBRARY
from axisid.support.missing import Missing

_AT_ONCE = 100  # runs that are simulated together
_CHANCE = 0.05
#: Shares of the runs: of right models in which a check fails, of 95 % intervals that hold, also
#: where reversals are kept, and of wrong models that are named.
MOST_FAILED, LEAST_HELD, LEAST_HELD_KEPT, LEAST_NAMED = 0.02, 0.93, 0.85, 0.95
#: Of checks with a level of their own.
LEVELS = {"residuals against the motion": 0.05}


@dataclass(kw_only=True)
class Figures:
    """What the runs of a case gave.

    Attributes
    ----------
    runs, identified : int
        All, and those that were not refused.
    failed : Counter
        Runs in which each check fails, and those that were refused.
    outside : Counter
        Identified runs in which the 95 % interval of each parameter misses the truth.
    rejected : int
        Identified runs in which Durbin-Wu-Hausman says at 1 % that least squares is biased.
    flagged, missed, unflagged : Counter
        Identified runs in which the interval of each parameter of idm-ls is said to miss, in which
        it does, and in which it does although it is not said to.
    noticed, named : int
        Runs in which any check fails, and in which one says what is wrong.
    """

    runs: int = 0
    identified: int = 0
    failed: Counter[str] = field(default_factory=Counter)
    outside: Counter[str] = field(default_factory=Counter)
    rejected: int = 0
    flagged: Counter[str] = field(default_factory=Counter)
    missed: Counter[str] = field(default_factory=Counter)
    unflagged: Counter[str] = field(default_factory=Counter)
    noticed: int = 0
    named: int = 0


def _count(figures: Figures, result: Identification, truth: dict[str, float], named: str) -> None:
    figures.runs += 1
    figures.identified += 1
    failed = [check for check in result.verdict if check.status == "fail"]
    figures.failed.update({check.name for check in failed})
    figures.noticed += bool(failed)
    figures.named += any(re.search(named, str(check.note)) for check in failed) if named else 0
    endogeneity = result.diagnosis.endogeneity
    figures.rejected += not isinstance(endogeneity, Missing) and endogeneity.p_value < 0.01
    for name, value in result.preferred.parameters.items():
        low, high = value.interval
        figures.outside[name] += not low <= truth[name] <= high
    biases = result.diagnosis.noise_biases.get("idm-ls", {})
    for name, bias in biases.items():
        low, high = result["idm-ls"].parameters[name].interval
        missed = not low <= truth[name] <= high
        figures.flagged[name] += bias.moved
        figures.missed[name] += missed
        figures.unflagged[name] += missed and not bias.moved


def _recorded(columns: dict[str, Array], case: Case) -> dict[str, Array]:
    lost = {"injected"} if case.has_reference else {"injected", "reference"}
    kept = {name: each for name, each in columns.items() if name not in lost}
    if case.logged_step:
        kept["position"] = case.logged_step * np.round(kept["position"] / case.logged_step)
    kept["position"] = kept["position"] + case.logged_zero
    kept["control"] = case.logged_control * np.roll(kept["control"], -case.logged_early)
    if case.jitter:
        # Each record has its own, and the same one each time.
        off = np.random.default_rng(int(1e9 * np.abs(kept["control"]).sum()) % 2**32)
        stamps = kept["time"] + 1e-3 * case.jitter * off.normal(size=len(kept["time"]))
        kept["time"] = np.maximum.accumulate(stamps + 1e-9 * np.arange(len(stamps)))
    return kept


def _prefilter(record: Record, case: Case) -> Prefilter | None:
    suited = Prefilter.suited(record.period)
    return replace(suited, reversals="keep") if case.kept else None


def figures_of(name: str, *, runs: int, seed: int, together: int = 1) -> Figures:
    """Identify the runs of a case, each from one record or from several together."""
    case = CASES[name]
    machine = case.machine
    axis = axis_of(case)
    truth = {"M": machine.mass, "Fv": machine.viscous, "Fc": machine.coulomb, "F0": machine.offset}
    figures = Figures()
    for begin in range(0, runs, _AT_ONCE):
        batch = together * min(_AT_ONCE, runs - begin)
        made = [*records(machine, reference_of(case.motion, machine.period), batch, seed + begin)]
        for first in range(0, batch, together):
            columns = made[first : first + together]
            try:
                given = [read_record(_recorded(each, case), axis) for each in columns]
                result = identify(axis, given, _prefilter(given[0], case), case.methods)
            except AxisidError as error:
                figures.runs += 1
                figures.failed[f"refused: {type(error).__name__}"] += 1
                continue
            _count(figures, result, truth, case.named)
    return figures


def twin_figures(name: str, *, runs: int, seed: int, clean: bool = False) -> Figures:
    """Identify the twins of a library axis, those of an exact encoder where they are clean."""
    axis = build(load_axis(name))
    figures = Figures()
    for k in range(runs):
        record = twin_record(axis, seed=seed + k, **({"position_noise": 0.0} if clean else {}))
        result = identify(axis, record, prefilter_of(name))
        _count(figures, result, dict(record.provenance.truth), "")
    return figures


def written(figures: Figures, case: Case | None) -> dict[str, object]:
    """Shares of the runs."""
    shares: dict[str, object] = {
        "runs": figures.runs,
        "failed": {name: n / figures.runs for name, n in figures.failed.most_common()},
    }
    if case is not None and case.rightly:
        shares["rightly"] = list(case.rightly)
    if case is None or not case.named:
        shares["held"] = {name: 1 - n / figures.identified for name, n in figures.outside.items()}
        shares["least_squares"] = {
            name: {
                "flagged": flagged / figures.identified,
                "held": 1 - figures.missed[name] / figures.identified,
                "held_unflagged": None
                if flagged == figures.identified
                else 1 - figures.unflagged[name] / (figures.identified - flagged),
            }
            for name, flagged in figures.flagged.items()
        }
        shares["rejected"] = figures.rejected / max(figures.identified, 1)
        shares["believed"] = 1 - figures.noticed / max(figures.identified, 1)
    else:
        shares |= {"noticed": figures.noticed / figures.runs, "named": figures.named / figures.runs}
    return shares


@dataclass(frozen=True, kw_only=True)
class Miss:
    """A share that is further from its aim than chance explains."""

    kind: str
    case: str
    what: str
    share: float
    aim: float

    def __str__(self) -> str:
        return (
            f"{self.kind}, {self.case}: {self.what} {100 * self.share:.0f} %, {100 * self.aim:g} %"
        )


def misses(kind: str, case: str, shares: Mapping[str, Any]) -> Iterator[Miss]:
    """What of a case misses its aim."""
    named, runs = shares.get("named"), int(shares["runs"])
    if named is not None:
        if _is_beyond(1 - named, runs, 1 - LEAST_NAMED):
            yield Miss(kind=kind, case=case, what="named", share=named, aim=LEAST_NAMED)
        return
    for check, share in shares["failed"].items():
        aim = LEVELS.get(check, MOST_FAILED)
        if check not in shares.get("rightly", ()) and _is_beyond(share, runs, aim):
            yield Miss(kind=kind, case=case, what=check, share=share, aim=aim)
    least = LEAST_HELD_KEPT if kind == "kept" else LEAST_HELD
    for name, share in shares["held"].items():
        if _is_beyond(1 - share, runs, 1 - least):
            yield Miss(kind=kind, case=case, what=f"interval of {name}", share=share, aim=least)


def _is_beyond(share: float, runs: int, aim: float) -> bool:
    """Whether so many of the runs are seldom reached where the aim is met."""
    return bool(binom.sf(round(share * runs) - 1, runs, aim) < _CHANCE)


def _lines(kind: str, name: str, shares: dict[str, object]) -> Iterator[str]:
    said = {k: shares[k] for k in ("noticed", "named") if k in shares}
    head = "  ".join(f"{k} {100 * float(str(v)):.0f} %" for k, v in said.items())
    held = shares.get("held")
    if isinstance(held, dict):
        head = "held " + "  ".join(f"{n} {100 * v:.0f}" for n, v in held.items())
        head += f"  believed {100 * float(str(shares['believed'])):.0f} %"
        head += f"  endogeneity rejected {100 * float(str(shares['rejected'])):.0f} %"
    yield f"{kind:<13}{name:<44}{head}"
    yield from _of_least_squares(shares.get("least_squares"))
    failed = shares["failed"]
    assert isinstance(failed, dict)
    right = shares.get("rightly", ())
    assert isinstance(right, list | tuple)
    for check, share in failed.items():
        yield f"{'':<8}{100 * share:5.1f} %  {check}{', rightly' * (check in right)}"


def _of_least_squares(shares: object) -> Iterator[str]:
    """What intervals of least squares are said to do, and do; only where something is said."""
    told = shares if isinstance(shares, dict) else {}
    for name, of_one in told.items():
        if of_one["flagged"]:
            flagged, held = (100 * of_one[k] for k in ("flagged", "held"))
            yield f"{'':<8}idm-ls {name}: said to miss {flagged:.0f} %, held {held:.0f} %"


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=40, help="of each case (default 40)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", metavar="NAME", help="the cases of a name")
    parser.add_argument("--kind", metavar="KIND", help="the cases of a kind, such as right")
    parser.add_argument("--together", type=int, default=1, help="records of each run (default 1)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    options = parser.parse_args()
    tables = {
        "right": RIGHT,
        "field": FIELD,
        "kept": KEPT,
        "alone": ALONE,
        "free": FREE,
        "logged": LOGGED,
        "output error": OUTPUT_ERROR,
        "wrong": WRONG,
        "twin": LIBRARY,
        "clean": LIBRARY,
    }
    kinds = {kind: list(table) for kind, table in tables.items()}
    chosen = [
        (kind, name)
        for kind, names in kinds.items()
        for name in names
        if options.only in (None, name) and options.kind in (None, kind)
    ]
    work = partial(_of_kind, runs=options.runs, seed=options.seed, together=options.together)
    with ProcessPoolExecutor(options.jobs) as pool:
        done = list(pool.map(work, *zip(*chosen, strict=True)))
    figures = [(k, n, shares) for (k, n), shares in zip(chosen, done, strict=True)]
    missed = [miss for one in figures for miss in misses(*one)]
    tree: dict[str, object] = {k: {n: s for of, n, s in figures if of == k} for k in kinds}
    tree["missed"] = [asdict(miss) for miss in missed]
    lines = [line for one in figures for line in _lines(*one)]
    give(tree, options.json, [*lines, f"{len(missed)} out of aim", *map(str, missed)])


def _of_kind(kind: str, name: str, *, runs: int, seed: int, together: int = 1) -> dict[str, object]:
    if kind == "clean":  # which are all alike
        return written(twin_figures(name, runs=1, seed=seed, clean=True), None)
    if kind == "twin":
        return written(twin_figures(name, runs=runs, seed=seed), None)
    found = figures_of(name, runs=runs, seed=seed, together=together)
    return written(found, CASES[name])


if __name__ == "__main__":
    main()
