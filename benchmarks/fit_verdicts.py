"""How often the checks of a fit fail, on right models of several noises and on wrong ones.

The machines are those of `judged_cases`, simulated apart from the program; and twins of the
library's axes with noises of other seeds. Of each output there is how often each check fails.

    python benchmarks/fit_verdicts.py                         a table
    python benchmarks/fit_verdicts.py --only "fine encoder"   one case
    python benchmarks/fit_verdicts.py --output open-loop      by another output
    python benchmarks/fit_verdicts.py --json -                one JSON object
"""

from collections import Counter
from collections.abc import Iterator

from figures import give, parser_of
from judged_cases import OF_DRIVE, RIGHT, WRONG, Case, declared, reference_of
from machines import records

from axisid import AxisidError, Record, build, fit, load_axis, read_record, twin_record
from axisid.codegen.artefacts import GeneratedAxis

LIBRARY = ("emps2015", "pendulum", "vertical_screw", "rotary_table", "linear_motor", "valve")
#: A drive whose rate is limited is later the more noise there is, which no loop without noise has.
_LEFT_OUT = ("drive with a rate, steps and a dead band",)


def _cases() -> dict[str, Case]:
    """Those that a fit can be made of: with a reference, of all methods, the zero where it is."""
    wrong = {
        name: case
        for name, case in WRONG.items()
        if case.has_reference and not case.logged_zero and case.methods is None
    }
    return {name: case for name, case in (RIGHT | wrong).items() if name not in _LEFT_OUT}


def _made(name: str, runs: int, seed: int) -> tuple[GeneratedAxis, Iterator[Record]]:
    if name in LIBRARY:
        axis = build(load_axis(name))
        return axis, (twin_record(axis, seed=seed + i) for i in range(runs))
    case = _cases()[name]
    machine = case.machine
    drive = {} if case.is_late else {of: getattr(machine, of) for of in OF_DRIVE}
    axis = declared(has_offset=case.has_offset, **drive)
    columns = records(machine, reference_of(case.motion), runs, seed)
    kept = ({n: v for n, v in each.items() if n != "injected"} for each in columns)
    return axis, (read_record(each, axis) for each in kept)


def figures_of(name: str, output: str, *, runs: int, seed: int) -> dict[str, object]:
    """Fit the runs of a case and count."""
    axis, made = _made(name, runs, seed)
    checks, failed, believed, named = Counter[str](), Counter[str](), 0, Counter[str]()
    for record in made:
        try:
            result = fit(axis, record, output)
        except AxisidError as error:
            failed[str(error)[:80]] += 1
            continue
        checks.update(check.name for check in result.checks if check.status == "fail")
        believed += result.believed
        if isinstance(result.lacks, tuple):
            named.update(lack.subject for lack in result.lacks[:1] if lack.is_there)
    return {
        "runs": runs,
        "believed": believed,
        "checks_failed": dict(checks),
        "named": dict(named),
        "failed": dict(failed),
    }


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=50, help="of each case (default 50)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", default="control", help="what is followed (default control)")
    parser.add_argument("--only", metavar="NAME", help="one case")
    options = parser.parse_args()
    names = [n for n in (*_cases(), *LIBRARY) if options.only in (None, n)]
    done = {n: figures_of(n, options.output, runs=options.runs, seed=options.seed) for n in names}
    lines = [
        f"{name:<30} {of['believed']:>4} of {of['runs']} believed; fail: "
        f"{of['checks_failed'] or 'none'} {of['named'] or ''} {of['failed'] or ''}"
        for name, of in done.items()
    ]
    give({"output": options.output, "cases": done}, options.json, lines)


if __name__ == "__main__":
    main()
