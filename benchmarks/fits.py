"""Fits of the loop's output on twins with known truth: bias, scatter, coverage, verdict, time.

The machine, its records and the laws are those of `output_error`. Of each output, and of both
together, there is the bias of the mean, the scatter over the runs, the mean of the claimed
deviation, the share of 95 % intervals that hold the truth, and how often each check fails. With a
log of the EMPS record there are its numbers and the time of a fit, and how far slopes by
differences are from the derivative of a loop in closed form, in complex numbers, through reversals
and rests.

    python benchmarks/fits.py                              a table
    python benchmarks/fits.py --json -                     one JSON object
    python benchmarks/fits.py --only "kp +1 %"             the cases of a name
    python benchmarks/fits.py --emps DATA_EMPS.mat         the record too
"""

import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from figures import give, parser_of
from machines import records
from output_error import CASES, TRUTH, declared, named, reference

from axisid import AxisidError, build, fit, load_axis, read_record, twin_record
from axisid.estimation.output_error import OutputFit
from axisid.estimation.output_residuals import ClosedLoopResiduals, jacobian_at
from axisid.estimation.regression import InverseForm

ROOT = Path(__file__).resolve().parents[1]
OUTPUTS = {
    "control": "control",
    "position": "position",
    "both": ("control", "position"),
}
_AT_ONCE, _TIMED = 50, 7
_NAMES = (
    "white noise",
    "coarse encoder",
    "at its limit",
    "kp +1 %",
    "limit +0.7 %",
    "plain difference",
    "one sample late",
)


@dataclass(kw_only=True)
class Figures:
    """What the runs of a case gave, by one output."""

    failed: Counter[str] = field(default_factory=Counter)
    values: list[list[float]] = field(default_factory=list)
    deviations: list[list[float]] = field(default_factory=list)
    held: list[list[bool]] = field(default_factory=list)
    checks: Counter[str] = field(default_factory=Counter)
    steps: list[int] = field(default_factory=list)

    def count(self, result: OutputFit) -> None:
        """Add a run."""
        values = result.parameters.values()
        self.values.append([v.value for v in values])
        self.deviations.append([v.deviation for v in values])
        pairs = zip(values, TRUTH.values(), strict=True)
        self.held.append([v.interval[0] <= truth <= v.interval[1] for v, truth in pairs])
        self.checks.update(c.name for c in result.checks if c.status == "fail")
        self.steps.append(len(result.best.steps))

    def written(self) -> dict[str, object]:
        """Percent of the truth, and shares of the runs."""
        truth = np.array([*TRUTH.values()])
        off = 100 * (np.array(self.values) / truth - 1)
        claimed = 100 * np.array(self.deviations) / truth
        scatter = off.std(axis=0, ddof=1) if len(off) > 1 else 0 * off[0]
        return {
            "runs": len(off),
            "bias_percent": named(off.mean(axis=0)),
            "sd_percent": named(scatter),
            "claimed_sd_percent": named(claimed.mean(axis=0)),
            "held": named(np.mean(self.held, axis=0)),
            "checks_failed": dict(self.checks),
            "most_jacobians": max(self.steps),
            "failed": dict(self.failed),
        }


def figures_of(name: str, *, runs: int, seed: int) -> dict[str, dict[str, object]]:
    """Fit the runs of a case to each output."""
    case, axis = CASES[name], declared(name)
    found = {output: Figures() for output in OUTPUTS}
    for begin in range(0, runs, _AT_ONCE):
        batch = min(_AT_ONCE, runs - begin)
        for columns in records(case.machine, reference(), batch, seed + begin):
            record = read_record(columns, axis)
            for output, figures in found.items():
                try:
                    figures.count(fit(axis, record, OUTPUTS[output]))
                except AxisidError as error:
                    figures.failed[str(error)[:80]] += 1
    return {output: figures.written() for output, figures in found.items()}


def slopes_off() -> dict[str, float]:
    """Slopes by differences beside those of the loop in closed form, relative, by parameter."""
    sys.path.insert(0, str(ROOT))
    from tests.axes.complex_loop import derivative_of

    axis, theta = build(load_axis("emps2015")), np.array([*TRUTH.values()])
    record = twin_record(axis)
    predictions = ClosedLoopResiduals(InverseForm(axis), [axis], [record], "control")
    predictions.settle(theta)
    _, found = jacobian_at(predictions, theta, theta, np.zeros(3), np.full(3, np.inf))
    start = predictions.stretches[0].inputs.start.position
    exact = derivative_of(theta, np.asarray(record.reference), start)
    return named(np.linalg.norm(found - exact, axis=0) / np.linalg.norm(exact, axis=0))


def on_record(file: str) -> dict[str, dict[str, object]]:
    """The EMPS record: parameters, deviations, steps, and CPU seconds of a fit."""
    axis = build(load_axis("emps"))
    record = read_record(file, axis)
    found: dict[str, dict[str, object]] = {}
    for output, followed in OUTPUTS.items():
        seconds = []
        for _ in range(_TIMED):
            begin = time.process_time()
            result = fit(axis, record, followed)
            seconds.append(time.process_time() - begin)
        begin = time.process_time()
        _ = result.checks
        found[output] = {
            "values": {n: v.value for n, v in result.parameters.items()},
            "deviations": {n: v.deviation for n, v in result.parameters.items()},
            "error": result.error,
            "jacobians": len(result.best.steps),
            "seconds": min(seconds),
            "seconds_of_checks": time.process_time() - begin,
        }
    return found


def _lines(name: str, output: str, of: dict[str, object]) -> Iterator[str]:
    cells = [
        f"{p} {of['bias_percent'][p]:+8.3f} +- {of['sd_percent'][p]:.3f} "  # type: ignore[index]
        f"({of['claimed_sd_percent'][p]:.3f}) {100 * of['held'][p]:5.1f} %"  # type: ignore[index]
        for p in TRUTH
    ]
    yield f"{name:<17} {output:<9}" + "   ".join(cells)
    yield (
        f"{'':27}{of['runs']} runs, {of['most_jacobians']} Jacobians at most, checks that fail "
        f"{of['checks_failed'] or 'none'}"
    )


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=100, help="of each case (default 100)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", metavar="NAME", help="one case")
    parser.add_argument("--emps", metavar="FILE", help="the EMPS record")
    options = parser.parse_args()
    names = [name for name in _NAMES if options.only in (None, name)]
    done = {n: figures_of(n, runs=options.runs, seed=options.seed) for n in names}
    lines = [line for n, by in done.items() for o, of in by.items() for line in _lines(n, o, of)]
    lines += ["bias +- scatter (claimed deviation) in percent of the truth, intervals that hold it"]
    off = slopes_off()
    lines += [
        f"slopes from those in closed form: {', '.join(f'{n} {v:.1e}' for n, v in off.items())}"
    ]
    measured = on_record(options.emps) if options.emps else {}
    lines += [f"EMPS, {output}: {of}" for output, of in measured.items()]
    give({"cases": done, "slopes_off": off, "emps": measured}, options.json, lines)


if __name__ == "__main__":
    main()
