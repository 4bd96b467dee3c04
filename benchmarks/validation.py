"""How often frozen estimates are said to hold on records where they do, and where they do not.

Each machine of `field` is identified from one record and validated on another: with other
noise, another motion, and with something changed that has to be named.

    python benchmarks/validation.py                   a table
    python benchmarks/validation.py --runs 40 --only "P-PI, 1 um, dwells"
"""

import argparse
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from field import FIXED, Motion, reference_of
from library import prefilter_of
from machines import Array, Machine, records

from axisid import build, identify, load_axis, read_record, twin_record, validate
from axisid.estimation.diagnostics.control_law.law_findings import (
    LawOfSecondRecord,
    OtherGains,
    OtherTestSignal,
    RepairedLaw,
    UnexplainedControl,
)
from axisid.estimation.findings import Finding
from axisid.estimation.model_validation import Validation
from axisid.estimation.model_validation.validation_findings import ReestimatedParameters
from axisid.modeling import LIBRARY

_SECOND = 1000  # seeds apart
_FREQUENCIES = (2.0, 5.0, 9.0, 14.0, 20.0, 27.0)  # Hz

_MOVES = Motion("trapezoids")
#: Of `field`, at 1 kHz, whose second record may be of another motion.
MACHINES = ("PD, 2 um, dwells, force of 20 ms", "P-PI, 1 um, dwells", "PID, 20 um, joystick")


def names_mass(validation: Validation) -> bool:
    """Tell whether the mass is named as another one."""
    check = {each.name: each for each in validation.checks}["records alike"]
    if check.status != "fail" or not isinstance(check.finding, ReestimatedParameters):
        return False
    return "M" in [each.name for each in check.finding.changed]


def names_gain(validation: Validation) -> bool:
    """Tell whether the law is named as another one, with its gain."""
    law = law_of(validation)
    if not isinstance(law, OtherGains):
        return False
    return any(gain.name == "kp" for gains in law.alternatives for gain in gains)


def names_test_signal(validation: Validation) -> bool:
    """Tell whether the law is named as another one, by a test signal."""
    law = law_of(validation)
    if isinstance(law, RepairedLaw):
        return isinstance(law.repair, OtherTestSignal)
    return isinstance(law, UnexplainedControl) and law.may_be_injected


def law_of(validation: Validation) -> Finding | None:
    """Return the finding of a law that fails."""
    check = {each.name: each for each in validation.checks}["control law"]
    if check.status != "fail" or not isinstance(check.finding, LawOfSecondRecord):
        return None
    return check.finding.finding


#: Change for the second record, its motion, and the finding that is wanted; None if it holds.
CHANGES: dict[
    str, tuple[Callable[[Machine], Machine], Motion, Callable[[Validation], bool] | None]
] = {
    "other noise": (lambda m: m, _MOVES, None),
    "multisine": (lambda m: m, Motion("multisine"), None),
    "2 s": (lambda m: m, Motion("trapezoids", seconds=2), None),
    "test signal": (lambda m: replace(m, injected=multisine(0.3)), _MOVES, None),
    "mass +10 %": (lambda m: replace(m, mass=1.1 * m.mass), _MOVES, names_mass),
    "kp +10 %": (lambda m: replace(m, kp=1.1 * m.kp), _MOVES, names_gain),
    "test signal unnamed": (
        lambda m: replace(m, injected=multisine(0.3)),
        _MOVES,
        names_test_signal,
    ),
    "in the reference": (
        lambda m: replace(m, injected=multisine(2e-5), injected_at="reference"),
        _MOVES,
        names_test_signal,
    ),
}


def multisine(amplitude: float) -> Array:
    """A test signal of six sines that begins at zero."""
    time, rng = 1e-3 * np.arange(20_000), np.random.default_rng(7)
    waves = sum(np.sin(2 * math.pi * f * time + rng.uniform(0, 6)) for f in _FREQUENCIES)
    return np.asarray(np.minimum(1.0, time / 0.5) * amplitude * waves)


def shares(case_name: str, *, runs: int, seed: int) -> dict[str, tuple[float, str]]:
    """Share of the runs that hold, or are named, by what is changed; with what is said of one."""
    case = FIXED[case_name]
    axis = case.axis
    results = [identify(axis, record) for record in case.records(runs, seed)]
    found = {}
    for name, (change, motion, wanted) in CHANGES.items():
        machine = change(case.machine)
        second = records(machine, reference_of(motion, machine.period), runs, seed + _SECOND)
        place = machine.injected_at if machine.injected is not None and wanted is None else None
        right, said = 0, ""
        for result, columns in zip(results, second, strict=True):
            if place is None:
                columns.pop("injected", None)
            checked = validate(result, read_record(columns, axis, injected_at=place))
            notes = notes_of(checked)
            is_right = checked.holds if wanted is None else wanted(checked)
            right += is_right
            said = said if is_right else notes
        found[name] = right / runs, said
    return found


def twin_share(name: str, *, runs: int, seed: int) -> tuple[float, str]:
    """The same for twins of a library axis with other noise."""
    axis = build(load_axis(name))
    right, said = 0, ""
    for k in range(seed, seed + runs):
        result = identify(axis, twin_record(axis, seed=k), prefilter_of(name))
        checked = validate(result, twin_record(axis, seed=k + _SECOND))
        right += checked.holds
        said = said if checked.holds else notes_of(checked)
    return right / runs, said


def notes_of(validation: Validation) -> str:
    """Return all notes of a validation as text."""
    return " ".join(note.sentence for note in validation.notes)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--runs", type=int, default=40, help="of each case (default 40)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", metavar="NAME", help="one machine or twin")
    options = parser.parse_args()
    given = {"runs": options.runs, "seed": options.seed}
    for name in MACHINES:
        if options.only in (None, name):
            for change, (share, said) in shares(name, **given).items():
                print(f"{name:<24}{change:<22}{100 * share:4.0f} %  {said[:150]}", flush=True)
    for name in LIBRARY:
        if options.only in (None, name):
            share, said = twin_share(name, **given)
            print(f"{name:<24}{'other noise':<22}{100 * share:4.0f} %  {said[:150]}", flush=True)


if __name__ == "__main__":
    main()
