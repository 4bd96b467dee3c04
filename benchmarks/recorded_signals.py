"""Twins with a recorded signal: how often the check fails on right ones, and tells wrong ones.

The library's slide with a counterbalance pressure, whose area is estimated or known, with its own
noise of the position and with ten times as much. Wrong ones have the pressure 20 or 100 ms late or
early, and, of a known area, in bar for Pa or 5 % too large. Counted is how often `recorded signals`
fails, of wrong ones for its cause; a factor of an estimated area cannot be told.

    python benchmarks/recorded_signals.py            a table
    python benchmarks/recorded_signals.py --json -   one JSON object
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
from figures import give, parser_of

from axisid import Record, build, identify, load_axis, twin_record
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.diagnostics.model_error_checks import RecordedSignals
from axisid.estimation.misspecification import ScaledSignal
from axisid.estimation.verdict_checks import Check
from axisid.modeling.quantities import Constant

NAME, SIGNAL, AREA = "balanced_slide", "pressure", "area"
NOISES = (1.0, 10.0)  # times the experiment's


@cache
def slide(*, known: bool) -> GeneratedAxis:
    """The axis; with the area as a constant where it is known."""
    axis = load_axis(NAME)
    experiment = axis.experiment
    if not known or experiment is None:
        return build(axis)
    (area,) = (p for p in axis.parameters if p.name == AREA)
    truth = {name: value for name, value in experiment.truth.items() if name != AREA}
    constant = Constant(experiment.truth[AREA], "m^2", AREA)
    return build(
        replace(
            axis,
            parameters=tuple(p for p in axis.parameters if p.name != AREA),
            force=axis.force.subs(area.symbol, constant.symbol),
            experiment=replace(experiment, truth=truth),
        )
    )


def _late(seconds: float) -> Callable[[Record], Record]:
    def moved(record: Record) -> Record:
        samples = round(seconds / record.period)
        rows = np.clip(np.arange(len(record)) - samples, 0, len(record) - 1)
        return replace(record, signals={SIGNAL: record.signals[SIGNAL][rows]})

    return moved


def _scaled(factor: float) -> Callable[[Record], Record]:
    return lambda record: replace(record, signals={SIGNAL: factor * record.signals[SIGNAL]})


#: What is done to a record, whether the area is known, and the fault that has to be found; any
#: for an empty text.
CASES: dict[str, tuple[Callable[[Record], Record], bool, str]] = {
    "right": (lambda record: record, False, ""),
    "right, known area": (lambda record: record, True, ""),
    "20 ms late": (_late(0.02), False, "late"),
    "100 ms late": (_late(0.1), False, "late"),
    "100 ms early": (_late(-0.1), False, "early"),
    "in bar, known area": (_scaled(1e-5), True, "scaled"),
    "5 % large, known area": (_scaled(1.05), True, "scaled"),
}


def _faults(check: Check) -> set[str]:
    """Return the faults of signals that a check found: late, early, scaled."""
    found = set[str]()
    if not isinstance(check.finding, RecordedSignals):
        return found
    for each in check.finding.found:
        if isinstance(each, ScaledSignal):
            found.add("scaled")
        elif not each.at_the_end:
            found.add("late" if each.samples > 0 else "early")
    return found


def share(case: str, noise: float, runs: int) -> float:
    """Share of twins on which the check fails, and says the cause."""
    change, known, fault = CASES[case]
    axis, failed = slide(known=known), 0
    experiment = axis.axis.experiment
    deviation = noise * (experiment.position_noise if experiment else 0.0)
    for seed in range(1, runs + 1):
        record = change(twin_record(axis, seed=seed, position_noise=deviation))
        result = identify(axis, record, methods=("idm-iv",))
        (check,) = (c for c in result.verdict if c.name == "recorded signals")
        failed += check.status == "fail" and (not fault or fault in _faults(check))
    return failed / runs


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=20, help="of each case (default 20)")
    options = parser.parse_args()
    found = {
        f"{case}, noise x {noise:g}": share(case, noise, options.runs)
        for case in CASES
        for noise in NOISES
    }
    lines = [f"share of {options.runs} twins on which the check fails, %"]
    lines += [f"{label:<40}{100 * value:.0f}" for label, value in found.items()]
    give(found | {"runs": options.runs}, options.json, lines)


if __name__ == "__main__":
    main()
