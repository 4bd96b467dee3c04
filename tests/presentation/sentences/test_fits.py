"""Sentences of the checks of a fit have every number, name and setting of their findings."""

from dataclasses import replace

import pytest

from axisid.estimation.diagnostics import RelativeError
from axisid.estimation.diagnostics.control_law import CONSTANT, DRIFT, GAINS, SCALE
from axisid.estimation.findings import Finding
from axisid.estimation.output_error import UnseenDirection
from axisid.estimation.output_error.fit_findings import (
    EndOfSearch,
    EndsOfSearches,
    FitPrecision,
    LawCorrection,
    LawSensitivity,
    MovedByLaw,
    NoParameterAtBound,
    OpenLoopWindows,
    OtherCauseOfMissingTerms,
    PriorAndRecord,
    SamplesNearRests,
    ShownParameters,
    SimulatedOutput,
)
from axisid.presentation.sentences import sentence

MOVED = MovedByLaw(differences=(GAINS,), parameter="Fv", percent=3.5, distance=4.5)
GAIN = LawCorrection(term="kp", factor=0.95, follows_position_alone=True)
SCALED = LawCorrection(term=None, factor=None, follows_position_alone=False)
SENSITIVITY = LawSensitivity(term="kp", parameter="Fv", percent=43.0, is_large=True)
WINDOWS = OpenLoopWindows(
    horizon=0.5,
    steady_horizon=0.0625,
    max_growth=10.0,
    windows=1,
    advised_windows=25,
    state="growing",
)
OUTPUT = SimulatedOutput(output="control", percent=21.0, percent_beyond_noise=19.0, follows=False)
PRIOR = PriorAndRecord(
    parameter="M",
    unit="kg",
    prior=95.0,
    standard_error=0.1,
    of_record=100.5,
    standard_error_of_record=0.25,
    distance=20.0,
    agree=False,
)
APART = UnseenDirection(parameters=("M", "m"), changes=(1.0, -0.5))
SHOWN = ShownParameters(outputs=("control", "position"), unseen=(APART,))
ERRORS = (RelativeError(name="Fv", percent=41.0), RelativeError(name="Fc", percent=None))


@pytest.mark.parametrize(
    ("finding", "parts"),
    [
        (MOVED, ["Fv", "3.5 %", "4.5 standard errors"]),
        (replace(MOVED, percent=None), ["by 4.5 standard errors"]),
        (
            replace(MOVED, correction=GAIN),
            ["kp", "0.95 times", "free=", 'output="control"', "instruments"],
        ),
        (
            replace(MOVED, differences=(SCALE, CONSTANT, DRIFT), correction=SCALED),
            ["unit and the scaling", "offset", "zero of the position", "drift"],
        ),
        (SENSITIVITY, ["1 %", "kp", "Fv", "43 %", 'output="control"']),
        (replace(SENSITIVITY, percent=0.5, is_large=False), ["0.5 %"]),
        (EndOfSearch(steps=1, state="converged"), ["1 step"]),
        (EndOfSearch(steps=7, state="interrupted"), ["7 steps"]),
        (EndOfSearch(steps=50, state="not converged"), ["50 steps", "leave_out"]),
        (EndsOfSearches(at_best=2, searches=8), ["2 of 8"]),
        (WINDOWS, ["factor of 10", "0.5 s", "horizon=0.0625"]),
        (replace(WINDOWS, state="few"), ["1 window is", "25", "0.5 s", "horizon=SECONDS"]),
        (replace(WINDOWS, state="good"), ["0.5 s"]),
        (OUTPUT, ["control", "21 %", "19 %", "units and signs"]),
        (replace(OUTPUT, follows=True), ["21 %", "19 %"]),
        (replace(OUTPUT, percent=None), ["zero"]),
        (OtherCauseOfMissingTerms(), ["declared law"]),
        (OtherCauseOfMissingTerms(bounds=("Fc", "Fv")), ["bounds of Fc and Fv"]),
        (SamplesNearRests(percent_left_out=12.0), ["12 %"]),
        (SamplesNearRests(percent_left_out=0.0), ["encoder"]),
        (PRIOR, ["M", "95 +- 0.1 kg", "100.5 +- 0.25 kg", "20 standard errors", "contradict"]),
        (replace(PRIOR, of_record=None, agree=True), ["the record", "20 standard errors"]),
        (SHOWN, ["control and position", "M and m", "+1 of M, -0.5 of m", "fix(axis, M=VALUE)"]),
        (
            ShownParameters(outputs=("control",), unseen=(UnseenDirection(parameters=("Fb",)),)),
            ["Fb at all"],
        ),
        (ShownParameters(outputs=("control",), unseen=()), ["control determines every"]),
        (
            FitPrecision(
                largest_percent=2.5, has_others=True, negligible=ERRORS[:1], unidentified=ERRORS[1:]
            ),
            ["Fc is not", "infinite", "Fv cannot", "41 %", "1 %", "fix(axis, Fc=VALUE)"],
        ),
        (
            FitPrecision(largest_percent=2.5, has_others=True, negligible=(), unidentified=ERRORS),
            ["Fv and Fc are not", "41 % and infinite"],
        ),
        (
            FitPrecision(largest_percent=2.5, has_others=True, negligible=(), unidentified=()),
            ["2.5 %"],
        ),
        (NoParameterAtBound(), ["bound"]),
    ],
)
def test_every_branch_has_its_numbers_names_and_settings(
    finding: Finding, parts: list[str]
) -> None:
    text = sentence(finding)
    assert [part for part in parts if part not in text] == []
