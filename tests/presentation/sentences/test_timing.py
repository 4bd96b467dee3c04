"""Sentences of sudden steps, outliers and recorded signals have their numbers and settings."""

from dataclasses import replace
from typing import get_args

import pytest

from axisid.estimation.diagnostics.model_error_checks import Outliers, RecordedSignals
from axisid.estimation.diagnostics.sudden_steps import Cause, SuddenSteps
from axisid.estimation.misspecification import (
    LateSignal,
    OutlyingSample,
    ScaledSignal,
    ShareOfForce,
)
from axisid.estimation.records import AdvisedShift
from axisid.presentation.sentences import sentence
from axisid.support.settings import setting

SHARE = ShareOfForce(percent=6.9, beyond_percent=3.2)
LATE = LateSignal(
    signal="pressure",
    samples=100.4,
    standard_error=0.2,
    seconds=0.1004,
    share=SHARE,
    at_the_end=False,
    shift=AdvisedShift(role="pressure", samples=-100.0, is_whole=True),
)
SCALED = ScaledSignal(
    signal="pressure",
    factor=1e5,
    standard_error=300.0,
    share=SHARE,
    column="p",
    likely_unit="bar",
)
SAMPLE = OutlyingSample(
    role="velocity",
    size=-0.02,
    standard_error=1e-3,
    unit="m/s",
    sample=3001,
    seconds=3.0,
    share=SHARE,
)


@pytest.mark.parametrize("cause", get_args(Cause))
@pytest.mark.parametrize("number", [1, 6])
@pytest.mark.parametrize("is_in_reference", [False, True])
def test_a_sudden_step_has_its_size_time_and_cause(
    cause: Cause, number: int, is_in_reference: bool
) -> None:
    text = sentence(
        SuddenSteps(
            number=number,
            unit="m",
            size=0.0123,
            seconds=2.5,
            cause=cause,
            held=9,
            is_in_reference=is_in_reference,
        )
    )
    assert "0.0123 m in one sample period, 2.5 s into the log" in text
    assert ("6" in text.partition("unlike")[0]) is (number == 6)
    assert ("9 periods" in text) is (cause == "stuck encoder")
    assert (setting("wrap", "360:deg") in text) is (cause == "new turn")
    assert ("windows" in text) is (cause != "new turn")


def test_a_position_without_sudden_steps_has_a_sentence() -> None:
    assert sentence(SuddenSteps(number=0, unit="m"))


def test_outliers_have_their_samples_and_settings() -> None:
    found = (SAMPLE, replace(SAMPLE, sample=4001, seconds=4.0))
    text = sentence(Outliers(found=found, is_bounded=False))
    parts = ["-0.02 +- 0.001 m/s", "sample 3001, 3 s", "sample 4001, 4 s", "6.9 % of the force"]
    parts += [setting("loss", "huber"), setting("resample", "auto")]
    assert [part for part in parts if part not in text] == []
    assert setting("loss", "huber") not in sentence(Outliers(found=found, is_bounded=True))
    assert sentence(Outliers(found=(), is_bounded=False))


@pytest.mark.parametrize(
    ("finding", "parts"),
    [
        (LATE, ["100.4 +- 0.2 samples (100.4 ms) late", "6.9 % of the force"]),
        (LATE, [setting("shift", {"pressure": "-100"})]),
        (replace(LATE, samples=-100.4, seconds=-0.1004), ["(100.4 ms) early"]),
        (replace(LATE, at_the_end=True, shift=None), ["100.4 samples earlier", "column"]),
        (SCALED, ["1e+05 +- 3e+02 times", setting("columns", {"pressure": "p:bar"})]),
        (
            replace(SCALED, factor=0.95, likely_unit=None, column=None),
            ["pressure", "NAME:UNIT*0.95"],
        ),
    ],
)
def test_a_recorded_signal_has_its_numbers_and_the_remedy(
    finding: LateSignal | ScaledSignal, parts: list[str]
) -> None:
    for text in (sentence(finding), sentence(RecordedSignals(found=(finding,)))):
        assert [part for part in parts if part not in text] == []


def test_several_signals_have_the_remedy_of_the_first() -> None:
    text = sentence(RecordedSignals(found=(LATE, SCALED)))
    assert "The model needs 1e+05" in text
    assert setting("columns", {"pressure": "p:bar"}) not in text
    assert sentence(RecordedSignals(found=()))


@pytest.mark.parametrize(
    ("samples", "is_whole", "parts"),
    [
        (1.0, True, ["1 sample later", setting("shift", {"force": "1"})]),
        (-3.0, True, ["3 samples earlier", setting("shift", {"force": "-3"})]),
        (
            -0.5,
            False,
            ["0.50 samples", setting("shift", {"force": "-0.50"}), setting("resample", "auto")],
        ),
    ],
)
def test_a_shift_has_its_setting(samples: float, is_whole: bool, parts: list[str]) -> None:
    text = sentence(AdvisedShift(role="force", samples=samples, is_whole=is_whole))
    assert [part for part in parts if part not in text] == []
    assert (setting("resample", "auto") in text) is not is_whole
