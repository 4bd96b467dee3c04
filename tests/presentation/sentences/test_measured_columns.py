"""Every finding on a measured column has a sentence with its numbers, units and corrections."""

from dataclasses import replace

import pytest

from axisid.estimation.diagnostics.column_findings import (
    ColumnCorrections,
    ControlAgainstLimit,
    ForceAgainstControl,
    GainOfForce,
    MeasuredMotion,
)
from axisid.estimation.findings import Finding
from axisid.estimation.records import AdvisedShift
from axisid.support.settings import setting

FORCE = ForceAgainstControl(
    fault="scale",
    difference_percent=10.5,
    factor=1.104,
    factor_uncertainty=2e-3,
    offset=-3.25,
    offset_uncertainty=0.02,
    lag=-7e-3,
    force_unit="N",
    drive="35.15 N/V times the control",
    gain=GainOfForce(declared=35.15, fitting=38.81, unit="N/V"),
)
LIMIT = ControlAgainstLimit(
    is_beyond=True,
    share_percent=12.3,
    excess_percent=2.0,
    limit=10.0,
    largest=14.2,
    unit="V",
    has_force=False,
)
CORRECTIONS = ColumnCorrections(
    column="vel",
    faults=("delay", "factor", "offset"),
    shift=AdvisedShift(role="velocity", samples=-3.0, is_whole=True),
    likely_unit="mm/s",
    is_reversed=False,
    scale_reference="position",
)
MOTION = MeasuredMotion(
    role="velocity",
    reference="derivative of the position",
    is_other_signal=False,
    is_wrong=True,
    worst=6.4,
    worst_of="delay",
    unexplained_percent=44.0,
    factor=1.05,
    factor_uncertainty=2e-3,
    delay=3.0,
    delay_uncertainty=0.02,
    offset=0.005,
    offset_uncertainty=3e-4,
    unit="m/s",
    corrections=CORRECTIONS,
)
FIGURES = ["1.05 +- 0.002", "3.00 +- 0.02 samples late", "+0.005 +- 0.0003 m/s", "6.4 times"]


def corrected(**changes: object) -> MeasuredMotion:
    return replace(MOTION, corrections=replace(CORRECTIONS, **changes))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("finding", "parts"),
    [
        (
            FORCE,
            ["1.104 +- 0.002", "10.5 %", "35.15 N/V", "38.81 N/V", "relative_sd", "parameter"],
        ),
        (replace(FORCE, gain=None, drive="the formula"), ["1.104 +- 0.002", "the formula"]),
        (replace(FORCE, fault="offset"), ["-3.25 +- 0.02 N", "10.5 %", "zero", "friction"]),
        (replace(FORCE, fault="other"), ["1.1 times", "7 ms early", "10.5 %", "unit", "gain"]),
        (replace(FORCE, fault="other", lag=7e-3), ["7 ms late"]),
        (replace(FORCE, fault=None), ["agrees", "10.5 %"]),
        (LIMIT, ["10 V", "12 % of the samples", "2 %", "14.2 V", "Record"]),
        (replace(LIMIT, has_force=True), ["10 V", "12 % of the samples", "14.2 V", "force"]),
        (replace(LIMIT, is_beyond=False, share_percent=0.0), ["10 V", "0 %"]),
        (
            MOTION,
            [
                *FIGURES,
                "derivative of the position",
                CORRECTIONS.shift.sentence if CORRECTIONS.shift else "",
                setting("columns", {"velocity": "vel:mm/s"}),
                setting("columns", {"velocity": "vel:UNIT-0.005m/s"}),
            ],
        ),
        (corrected(faults=("delay",), shift=None), [*FIGURES, "nterpolate", "velocity"]),
        (
            corrected(faults=("factor",), likely_unit=None, is_reversed=True),
            [*FIGURES, setting("columns", {"velocity": "vel:UNIT*-1"})],
        ),
        (
            corrected(faults=("factor",), likely_unit=None, scale_reference="reference"),
            [*FIGURES, "unit", "scale", "and those of the reference"],
        ),
        (
            replace(MOTION, is_other_signal=True),
            [*FIGURES, "44 %", setting("columns", {"velocity": "NAME:UNIT"})],
        ),
        (
            replace(MOTION, is_wrong=False, reference="velocity of the simulated loop", delay=-3.0),
            ["agrees", "simulated loop, which follows the reference", "samples early"],
        ),
    ],
)
def test_every_number_and_correction_is_in_the_sentence(finding: Finding, parts: list[str]) -> None:
    words = finding.sentence.lower()
    assert [part for part in parts if part.lower() not in words] == []
