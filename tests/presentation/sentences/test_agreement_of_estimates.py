"""Every finding on the agreement of estimates has a sentence with its numbers, names and units."""

from dataclasses import replace

import pytest

from axisid.estimation.diagnostics.agreement_findings import (
    AgreementOfEstimates,
    DirectAgainstInverse,
    EstimateComparison,
    InstrumentsAgainstOutputError,
    LeastSquaresAgainstInstruments,
    NoiseBias,
    ParameterBias,
    ParameterDifference,
    QuantisationBias,
    WeakestInstrument,
)
from axisid.estimation.findings import Finding
from axisid.support.settings import setting

MASS = ParameterDifference(
    name="M", difference=-0.45, unit="kg", percent=-0.47, standard_errors=2.7
)
NUMBERS = ["-0.45 kg for M", "-0.47 %", "2.7 standard errors of "]
APART = EstimateComparison(
    first="idm-iv", second="didim", differences=(MASS,), largest=MASS, p_value=1e-4, is_large=True
)
NEAR = replace(APART, differences=(), is_large=False)
LOW = ParameterBias(name="M", bias=-1.2, unit="kg", standard_errors=4.0)


def against_didim(
    reported: str, *, law_passed: bool | None, less_precise: tuple[str, ...] = ()
) -> InstrumentsAgainstOutputError:
    return InstrumentsAgainstOutputError(
        comparison=APART, reported=reported, law_passed=law_passed, less_precise=less_precise
    )


NOISE = NoiseBias(method="idm-ls", biases=(LOW,), largest=4.0, most=0.5, instruments="idm-iv")
STEPS = QuantisationBias(method="idm-ls", biases=(LOW,), largest=4.0, most=0.5, fewest_steps=None)
COLUMN = WeakestInstrument(column="J", conditional_f=3.2, least_f=10.0, is_strong=False)


@pytest.mark.parametrize(
    ("finding", "parts"),
    [
        (against_didim("didim", law_passed=True), [*NUMBERS, "DIDIM is reported", "prefilter"]),
        (
            against_didim("idm-iv", law_passed=True, less_precise=("M", "Fv")),
            [*NUMBERS, "IDM-IV is reported", "M and Fv", "unmodelled force"],
        ),
        (against_didim("idm-iv", law_passed=None), [*NUMBERS, "IDM-IV is reported", "checked"]),
        (
            against_didim("idm-iv", law_passed=False),
            [*NUMBERS, "IDM-IV is reported", "units", "columns"],
        ),
        (
            replace(against_didim("didim", law_passed=True), comparison=NEAR),
            ["IDM-IV and DIDIM agree", "2.7 standard errors (M; "],
        ),
        (LeastSquaresAgainstInstruments(comparison=APART), [*NUMBERS, "noise"]),
        (LeastSquaresAgainstInstruments(comparison=NEAR), ["agree", "2.7 standard errors (M; "]),
        (DirectAgainstInverse(comparison=APART), [*NUMBERS, setting("output", "open-loop")]),
        (DirectAgainstInverse(comparison=replace(APART, is_large=False)), [*NUMBERS, "inertia"]),
        (DirectAgainstInverse(comparison=NEAR), ["agree", "2.7 standard errors (M; "]),
        (NOISE, ["M by about -1.2 kg", "4 standard errors", setting("methods", "idm-iv")]),
        (replace(NOISE, instruments=""), ["M by about -1.2 kg", "by instruments"]),
        (replace(NOISE, biases=(), largest=0.2), ["IDM-LS", "0.2 standard errors", "0.5"]),
        (STEPS, ["M by about -1.2 kg", "4 standard errors", "cut-off", "reference"]),
        (
            replace(STEPS, biases=(), largest=None, fewest_steps=64),
            ["unknown", "fewer than 64 steps", "cut-off"],
        ),
        (replace(STEPS, biases=(), largest=0.2), ["IDM-LS", "0.2 standard errors", "0.5"]),
        (COLUMN, ["J", "F = 3.2", "10"]),
        (replace(COLUMN, conditional_f=40.0, is_strong=True), ["J", "F = 40", "10"]),
        (replace(COLUMN, conditional_f=None, is_strong=True), ["every column", "exactly"]),
        (
            AgreementOfEstimates(reported="didim", findings=(NOISE,), all_pass=True),
            ["DIDIM is reported", "Noise biases IDM-LS", "-1.2 kg"],
        ),
        (
            AgreementOfEstimates(reported="didim", findings=(STEPS, NOISE), all_pass=False),
            ["the steps", "Noise biases IDM-LS"],
        ),
    ],
)
def test_every_number_and_remedy_is_in_the_sentence(finding: Finding, parts: list[str]) -> None:
    assert [part for part in parts if part not in finding.sentence] == []


def test_only_large_differences_of_the_forms_ask_for_another_fit() -> None:
    small = DirectAgainstInverse(comparison=replace(APART, is_large=False))
    assert setting("output", "open-loop") not in small.sentence
