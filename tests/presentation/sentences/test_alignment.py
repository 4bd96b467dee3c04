"""Sentences of the delay of the force have every number, unit and remedy."""

from typing import Any

import pytest

from axisid.estimation.diagnostics.alignment_findings import (
    DeclaredTooLong,
    DelayBeyondRange,
    EffectOfDelay,
    ForceDelay,
    LoggedAtOtherTime,
    OtherHold,
    UndeclaredDelay,
)
from axisid.estimation.findings import Finding


def delay(*remedies: Finding, **others: Any) -> ForceDelay:
    values = {
        "delay": 1.48,
        "standard_error": 0.02,
        "is_at_end": False,
        "by_instruments": True,
        "hold": "zoh",
        "supposed": 0.5,
        "apart": 0.98,
        "is_aligned": False,
        "role": "control",
        "effects": (EffectOfDelay(parameter="Fv", per_sample=4.4, unit="N/(m/s)"),),
    }
    return ForceDelay(remedies=remedies, **{**values, **others})


@pytest.mark.parametrize(
    ("finding", "parts"),
    [
        (
            delay(delay=0.52, apart=0.02, is_aligned=True),
            ["0.52 +- 0.02 samples after", "hold zoh implies 0.5 samples after", "of 0.02"],
        ),
        (
            delay(by_instruments=False, delay=-0.5, apart=-1.0),
            ["0.50 +- 0.02 samples before", "least squares", "1 samples late"],
        ),
        (delay(delay=3.0, is_at_end=True, apart=2.5), ["3 samples or more", "2.5 samples early"]),
        (
            delay(UndeclaredDelay(seconds=1e-3, is_further=True)),
            ["0.98 samples early", "Declare 0.001 s more in all", "Fv by +4.4 N/(m/s)"],
        ),
        (
            delay(OtherHold(hold="raw", or_law_period=True)),
            ['Try hold="raw"', "control law with its period"],
        ),
        (
            delay(LoggedAtOtherTime(role="control", samples=1)),
            ["before the drive applies it", 'shift={"control": 1}'],
        ),
        (
            delay(LoggedAtOtherTime(role="force", samples=-1)),
            ["after it acted", 'shift={"force": -1}'],
        ),
        (
            delay(DelayBeyondRange(role="control", samples=3, seconds=3e-3)),
            ['shift={"control": 3}', "0.003 s or more"],
        ),
        (
            delay(DeclaredTooLong(declared=2e-2, excess=8e-3, is_at_least=True, remaining=0.012)),
            ["0.02 s in all", "at least 0.008 s too long", "Declare 0.012 s or less"],
        ),
        (
            delay(DeclaredTooLong(declared=1e-3, excess=1e-3, is_at_least=False, remaining=0.0)),
            ["0.001 s too long", "Declare no delay"],
        ),
    ],
)
def test_a_delay_is_told_with_its_numbers_and_its_remedy(
    finding: Finding, parts: list[str]
) -> None:
    for part in parts:
        assert part in finding.sentence
