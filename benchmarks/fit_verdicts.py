"""How often the checks of a fit fail, on right models of several noises and on wrong ones.

The machines are those of `judged_cases`, simulated apart from the program; and twins of the
library's axes, and of a screw in slow moves, with noises of other seeds. Of each output there is
how often each check fails, and over all right machines up to which share that may be (95 %). The
runs are made in processes of one thread each: an algebra library that waits for a busy core with
several takes four times the CPU.

    python benchmarks/fit_verdicts.py                         a table
    python benchmarks/fit_verdicts.py --only "fine encoder"   one case
    python benchmarks/fit_verdicts.py --output open-loop      by another output
    python benchmarks/fit_verdicts.py --free all              with every gain of the law free
    python benchmarks/fit_verdicts.py --prior 0.01            with the first parameter known to 1 %
    python benchmarks/fit_verdicts.py --gain 0.03             drives declared 3 % too strong, free
    python benchmarks/fit_verdicts.py --json -                one JSON object
"""

import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypedDict

import numpy as np
from figures import give, parser_of
from judged_cases import FIELD, RIGHT, WRONG, Case, axis_of, reference_of
from machines import records
from scipy.stats import beta

from axisid import AxisidError, Record, build, fit, load_axis, read_record, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.joint import GAIN
from axisid.support.jobs.run import run_jobs

#: Friction that falls with the velocity, in slow moves: noise and an open loop drive it away.
SLOW = "slow screw"
FOLDER = Path(__file__).parent
LIBRARY = (SLOW, "emps2015", "pendulum", "vertical_screw", "rotary_table", "linear_motor", "valve")
#: A drive whose rate is limited is later the more noise there is, which no loop without noise has.
_LEFT_OUT = ("drive with a rate, steps and a dead band",)


class Counted(TypedDict):
    """What the runs of a case gave: how many, how many believed, and why not the others.

    Of twins, whose truth is known: the root mean square of the errors in claimed deviations by
    parameter, and how many of all their intervals held, %.
    """

    runs: int
    believed: int
    checks_failed: dict[str, int]
    named: dict[str, int]
    failed: dict[str, int]
    off: dict[str, float]
    held: float | None


def _cases() -> dict[str, Case]:
    """Those that a fit can be made of: with a reference, of all methods, the zero where it is."""
    wrong = {
        name: case
        for name, case in WRONG.items()
        if case.has_reference and not case.logged_zero and case.methods is None
    }
    return {name: case for name, case in (RIGHT | FIELD | wrong).items() if name not in _LEFT_OUT}


def _made(name: str, runs: int, seed: int) -> tuple[GeneratedAxis, Iterator[Record]]:
    if name in LIBRARY:
        axis = build(load_axis(FOLDER / "slow_screw.toml" if name == SLOW else name))
        return axis, (twin_record(axis, seed=seed + i) for i in range(runs))
    case = _cases()[name]
    axis = axis_of(case)
    reference = reference_of(case.motion, case.machine.period)
    columns = records(case.machine, reference, runs, seed)
    kept = ({n: v for n, v in each.items() if n != "injected"} for each in columns)
    return axis, (read_record(each, axis) for each in kept)


def figures_of(
    name: str,
    output: str,
    *,
    runs: int,
    seed: int,
    horizon: float | None = None,
    free: str = "",
    prior: float = 0.0,
    gain: float = 0.0,
) -> Counted:
    """Fit the runs of a case and count.

    With free gains by commas, or all of them; of a twin with a prior of its first parameter that is
    drawn about the truth, with that share of it as deviation; or with its drive declared by such a
    share too strong, its gain free, and the first parameter held at the truth.
    """
    random = np.random.default_rng(seed)
    axis, made = _made(name, runs, seed)
    law = axis.axis.control
    every = free == "all" and law is not None
    gains = [*law.gains] if every and law else [g for g in free.split(",") if g]
    checks, failed, believed, named = Counter[str](), Counter[str](), 0, Counter[str]()
    truth = axis.declared.experiment.truth if name in LIBRARY and axis.declared.experiment else {}
    off, held = list[list[float]](), list[bool]()
    fixed = dict[str, float]()
    if gain and truth:
        gains, fixed = [*gains, GAIN], dict([next(iter(truth.items()))])
        truth = {**{n: v for n, v in truth.items() if n not in fixed}, GAIN: axis.axis.drive.gain}
        axis = _declared(axis, 1 + gain)
    asked = partial(fit, axis, output=output.split("+"), horizon=horizon, free=gains, fixed=fixed)
    for record in made:
        try:
            result = asked(record, prior=_drawn(record, prior, random))
        except AxisidError as error:
            failed[str(error)[:80]] += 1
            continue
        checks.update(check.name for check in result.checks if check.status == "fail")
        believed += result.believed
        values = {n: result[n] for n in truth}
        off.append([(each.value - truth[n]) / each.deviation for n, each in values.items()])
        held += [v.interval[0] <= truth[n] <= v.interval[1] for n, v in values.items()]
        if isinstance(result.lacks, tuple):
            named.update(lack.subject for lack in result.lacks[:1] if lack.is_there)
    return {
        "runs": runs,
        "believed": believed,
        "checks_failed": dict(checks),
        "named": dict(named),
        "failed": dict(failed),
        "off": dict(zip(truth, np.sqrt(np.mean(np.square(off), axis=0)).tolist(), strict=True)),
        "held": 100 * float(np.mean(held)) if held else None,
    }


def _declared(axis: GeneratedAxis, factor: float) -> GeneratedAxis:
    """The axis with a drive of so many times its gain."""
    drive = axis.declared.drive
    return build(replace(axis.declared, drive=replace(drive, gain=factor * float(drive.gain))))


def _drawn(
    record: Record, share: float, random: np.random.Generator
) -> dict[str, tuple[float, float]]:
    """A prior of the first parameter of a twin; none of other records."""
    if not (share and record.provenance.truth):
        return {}
    name, truth = next(iter(record.provenance.truth.items()))
    return {name: (truth + share * truth * random.normal(), share * truth)}


def counted_of(
    name: str,
    output: str,
    *,
    runs: int,
    wrong: int,
    seed: int,
    horizon: float | None,
    free: str,
    prior: float,
    gain: float,
) -> Counted:
    """The figures of a case, of a wrong machine from fewer runs."""
    made = wrong if name in WRONG else runs
    work = partial(figures_of, name, output, horizon=horizon, prior=prior, gain=gain)
    return work(runs=made, seed=seed, free=free)


def most_believable(failed: int, runs: int) -> float:
    """Share of failures up to which so many of so many runs are no surprise (95 %)."""
    return float(beta.ppf(0.95, failed + 1, runs - failed)) if failed < runs else 1.0


def right_of(done: Mapping[str, Counted]) -> dict[str, float]:
    """How often a right machine is not believed, over all of them."""
    right = [each for name, each in done.items() if name not in WRONG]
    runs = sum(each["runs"] for each in right)
    failed = runs - sum(each["believed"] for each in right)
    return {"runs": runs, "failed": failed, "at_most": most_believable(failed, runs)}


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=40, help="of each right machine (default 40)")
    parser.add_argument("--wrong", type=int, default=10, help="of each wrong one (default 10)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--output", default="control", help="control, position, control+position ..."
    )
    parser.add_argument("--horizon", type=float, help="of an open loop, s (default its own)")
    parser.add_argument("--free", default="", help="gains by commas, or all (default none)")
    parser.add_argument("--prior", type=float, default=0.0, help="deviation, of the value")
    parser.add_argument("--gain", type=float, default=0.0, help="by which drives are too strong")
    parser.add_argument("--only", metavar="NAMES", help="cases, by commas")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    options = parser.parse_args()
    wanted = options.only.split(",") if options.only else [*_cases(), *LIBRARY]
    names = [n for n in (*_cases(), *LIBRARY) if n in wanted]
    asked = ("output", "runs", "wrong", "seed", "horizon", "free", "prior", "gain")
    how = {name: getattr(options, name) for name in asked}
    work = partial(counted_of, **how)
    done = dict[str, Counted]()
    for outcome in run_jobs(work, names, total=len(names), jobs=options.jobs):
        name = names[outcome.place]
        if outcome.value is None:
            raise SystemExit(f"{name}: {outcome.failure}")
        done[name] = outcome.value
        print(_line(name, outcome.value), file=sys.stderr, flush=True)
    right = right_of(done)
    lines = [_line(name, done[name]) for name in names]
    lines.append(
        f"right machines: {right['failed']} of {right['runs']} fail, "
        f"at most {100 * right['at_most']:.2g} % (95 %)"
    )
    give({"output": options.output, "cases": done, "right": right}, options.json, lines)


def _line(name: str, of: Counted) -> str:
    off = " ".join(f"{n} {size:.2f}" for n, size in of["off"].items())
    known = "" if of["held"] is None else f"; z {off}; {of['held']:.0f} % of intervals hold"
    return (
        f"{name:<30} {of['believed']:>4} of {of['runs']} believed; fail: "
        f"{of['checks_failed'] or 'none'} {of['named'] or ''} {of['failed'] or ''}{known}"
    )


if __name__ == "__main__":
    main()
