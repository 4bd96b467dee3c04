"""Sentences of the checks of a validation have every number and name of their findings."""

from dataclasses import replace

import pytest

from axisid.estimation.diagnostics.pooling_findings import DifferingParameter
from axisid.estimation.findings import Finding, Said
from axisid.estimation.model_validation.validation_findings import (
    DoubtfulTimeBase,
    EquationErrorOnRecord,
    EstimatesDoNotHold,
    EstimatesHold,
    KnownSamples,
    NoSimulation,
    OutputOnRecord,
    ReestimatedParameters,
    SamplePeriods,
    SimulationOnRecord,
)
from axisid.presentation.sentences import sentence

EQUATION = EquationErrorOnRecord(
    failed=("idm-iv", "didim"), largest_percent=21.0, max_percent=10.0, max_ratio=2.0
)
LOOP = SimulationOnRecord(
    failed=("idm-iv",),
    by_position=True,
    tracking_error_percent=12.0,
    own_tracking_error_percent=2.0,
    simulation_error_percent=31.0,
    own_simulation_error_percent=4.0,
)
MASS = DifferingParameter(
    name="M", own=110.0, common=100.0, standard_error=0.5, unit="kg", is_load=True
)
CHANGED = ReestimatedParameters(failed=("didim",), changed=(MASS,), largest_percent=6.5)
HELD = EstimatesHold(passed=(Said(text="one"), Said(text="two")), is_reestimated=True)
OUTPUT = OutputOnRecord(output="control", percent=11.0, own_percent=3.5, holds=False)


@pytest.mark.parametrize(
    ("finding", "parts"),
    [
        (DoubtfulTimeBase(reason="it is slow"), ["it is slow"]),
        (KnownSamples(percent=100.0, is_same_record=True), ["100 %", "another record"]),
        (KnownSamples(percent=42.0, is_same_record=False), ["42 %", "other samples"]),
        (EQUATION, ["IDM-IV and DIDIM do not", "21 %", "10 %", "2 times", "units and signs"]),
        (replace(EQUATION, failed=(), largest_percent=3.0), ["3 %", "10 %", "2 times"]),
        (LOOP, ["IDM-IV does not", "12 %", "injected", "injected_at", "run.toml"]),
        (replace(LOOP, failed=()), ["12 %"]),
        (CHANGED, ["DIDIM does not", "M is 110 kg", "100 kg", "+10 +- 0.5 kg", "load", "6.5 %"]),
        (replace(CHANGED, failed=(), changed=()), ["6.5 %"]),
        (HELD, ["hold", "one", "two"]),
        (replace(HELD, is_reestimated=False), ["one", "two", "could not be estimated"]),
        (EstimatesDoNotHold(failed=("law", "loop")), ["law and loop"]),
        (NoSimulation(reason="no reference"), ["no simulation", "no reference"]),
        (SamplePeriods(of_record=0.002, of_fit=0.001, are_equal=False), ["0.002 s", "0.001 s"]),
        (SamplePeriods(of_record=0.001, of_fit=0.001, are_equal=True), ["0.001 s"]),
        (OUTPUT, ["control", "11 %", "3.5 %", "load"]),
        (replace(OUTPUT, holds=True), ["11 %", "3.5 %"]),
    ],
)
def test_every_branch_has_its_numbers_and_names(finding: Finding, parts: list[str]) -> None:
    text = sentence(finding)
    assert [part for part in parts if part not in text] == []


def test_a_loop_that_fails_by_its_force_alone_tells_the_force() -> None:
    text = sentence(replace(LOOP, by_position=False))
    assert "31 % of the force" in text
    assert "tracking error" not in text
