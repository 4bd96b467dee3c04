"""What it costs to leave samples near reversals out, and what the default does.

Errors with the reversals kept, left out, and as chosen: of machines (`machines`) the mean size of
each parameter's error in percent, of the DFKI pendulum the equation error of least squares, in
percent, on the motions that it was not estimated from.

    python benchmarks/reversals.py            a table
    python benchmarks/reversals.py --json -   one JSON object

The pendulum's files are looked for in ``$AXISID_DATA/dfki_pendulum``, and left out without them.
"""

import argparse
import json
import os
import sys
import tempfile
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
from judged_cases import RIGHT, Case, declared, reference_of
from machines import Array, records

from axisid import Prefilter, Record, build, identify, read_record

_EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
_CHOICES = ("keep", "leave-out", None)
_THINNED = 40  # samples

Errors = dict[str, list[float]]


def _dwells() -> Array:
    """Moves with a rest of a second after each."""
    moves = reference_of("moves")
    rest = np.full(1000, np.nan)
    still = np.flatnonzero(np.diff(np.sign(np.diff(moves)))) + 1
    padded = np.insert(moves, np.repeat(still, len(rest)), np.tile(rest, len(still)))
    kept = np.maximum.accumulate(np.where(np.isnan(padded), 0, np.arange(len(padded))))
    return np.asarray(padded[kept], dtype=float)


def machine_errors(case: Case, prefilter: Prefilter, runs: int, kind: str) -> Errors:
    """Mean size of each parameter's error, in percent, by choice; and the choice of the default."""
    axis, machine = declared(has_offset=case.has_offset), case.machine
    truth = np.array([machine.mass, machine.viscous, machine.coulomb])
    motion = _dwells() if kind == "dwells" else reference_of(case.motion)
    every = [read_record(columns, axis) for columns in records(machine, motion, runs, 1)]
    if kind == "thinned":
        every = [_thinned(record) for record in every]
    found: Errors = {}
    for choice in _CHOICES:
        settings = replace(prefilter, reversals=choice)
        results = [identify(axis, record, settings, case_methods(kind)) for record in every]
        errors = [np.abs(r.preferred.corrected / truth - 1) for r in results]
        chosen = results[0].prefilter.reversals
        name = str(choice) if choice else f"default: {chosen}"
        found[name] = [round(100 * float(e), 3) for e in np.mean(errors, axis=0)]
    return found


def case_methods(kind: str) -> list[str]:
    """A thinned log has no loop; in rests that are kept, instruments come to no end."""
    return ["idm-ls"] if kind else ["idm-iv"]


def _thinned(record: Record) -> Record:
    """Every so many samples of motion and control, without a reference."""
    assert record.control is not None
    return Record(
        time=record.time[::_THINNED],
        position=record.position[::_THINNED],
        control=record.control[::_THINNED],
    )


def pendulum_errors(folder: Path) -> dict[str, Errors]:
    """Equation errors of least squares on the other motions, by motion and cut-off."""
    sys.path.insert(0, str(_EXAMPLES))
    from dfki_pendulum import axis
    from dfki_pendulum_data import prefilter, read_data
    from dfki_pendulum_study import frozen_error

    found: dict[str, Errors] = {}
    with tempfile.TemporaryDirectory() as scratch:
        motions = read_data(folder, Path(scratch)).records
    for cutoff in (5.0, 8.0, 15.0):
        for name, record in motions.items():
            errors: Errors = {}
            for choice in _CHOICES:
                settings = replace(prefilter(record, cutoff), reversals=choice)
                result = identify(build(axis), record, settings, ["idm-ls"])
                chosen = str(choice) if choice else f"default: {result.prefilter.reversals}"
                errors[chosen] = [
                    round(
                        frozen_error(
                            other,
                            result["idm-ls"].physical,
                            prefilter(record, cutoff).at_period(record.period, other.period),
                        ),
                        1,
                    )
                    for held, other in motions.items()
                    if held != name
                ]
            found[f"DFKI {name}, {cutoff:g} Hz"] = errors
    return found


def figures(runs: int) -> dict[str, Errors]:
    """Every case."""
    usual = Prefilter()
    slow = Prefilter.suited(1e-3 * _THINNED, cutoff=4.5)
    cases = {
        "encoder of 5 um": (RIGHT["encoder of 5 um"], usual, ""),
        "100 counts/rev": (RIGHT["coarse encoder"], usual, ""),
        "sines": (RIGHT["sines"], usual, ""),
        "dwells": (RIGHT["fine encoder"], usual, "dwells"),
        "thinned log, 4.5 Hz": (RIGHT["force of 50 ms"], slow, "thinned"),
    }
    found = {name: machine_errors(c, f, runs, kind) for name, (c, f, kind) in cases.items()}
    folder = Path(os.environ.get("AXISID_DATA", "../shared/data")) / "dfki_pendulum"
    return found | (pendulum_errors(folder) if folder.is_dir() else {})


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--json", metavar="FILE", help="write one JSON object; - for stdout")
    parser.add_argument("--runs", type=int, default=10, help="of each machine (default 10)")
    options = parser.parse_args()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = figures(options.runs)
    text = json.dumps(found, indent=2)
    if options.json == "-":
        print(text)
    elif options.json:
        Path(options.json).write_text(text + "\n")
    else:
        for name, errors in found.items():
            listed = "  ".join(
                f"{choice} {' '.join(f'{e:g}' for e in each)}" for choice, each in errors.items()
            )
            print(f"{name:<32}{listed}")


if __name__ == "__main__":
    main()
