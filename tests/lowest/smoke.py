"""Identify, fit, save and plot the built-in twin, with the required libraries alone.

A program, not a test of pytest: `make lowest` runs it with the lowest versions of the required
libraries, where a warning is an error.

    python -W error tests/lowest/smoke.py
"""

import tempfile
import warnings
from pathlib import Path

from axisid import build, fit, identify, load_axis, load_result, twin_record


def main() -> None:
    """Run every stage once.

    Raises
    ------
    SystemExit
        A value is far from the truth, a check fails, or a saved result is not read as written.
    """
    axis = build(load_axis("emps2015"))
    record = twin_record(axis, seed=1)
    result = identify(axis, record)
    fitted = fit(axis, record, output=["position"])
    truth = record.provenance.truth or {}
    for name, value in truth.items():
        for found in (result.preferred.parameters[name], fitted[name]):
            if not abs(found.corrected - value) < 6 * found.deviation:
                raise SystemExit(f"{name} is {found.corrected:.6g}, {value:.6g} in truth")
    for each in (result, fitted):
        if each.belief != "believed":
            raise SystemExit(f"a correct record is {each.belief}:\n{each.summary()}")
    # An old matplotlib calls what a new pyparsing deprecates.
    warnings.filterwarnings("ignore", module=r"(matplotlib|pyparsing)\.")
    with tempfile.TemporaryDirectory() as folder:
        if load_result(result.save(Path(folder, "result.json"))).belief != result.belief:
            raise SystemExit("a saved result is not read as it was written")
        result.plot("force").savefig(Path(folder, "force.png"))


if __name__ == "__main__":
    main()
