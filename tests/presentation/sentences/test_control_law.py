"""Sentences of a control law compared with a record have every number, unit and remedy."""

from typing import Any

import pytest

from axisid.estimation.diagnostics.control_law import (
    ConstantOrDrift,
    ControlScale,
    ExchangedColumns,
    FoundByReading,
    FoundGainsAgree,
    FoundGainsDiffer,
    LateControl,
    LawOfSecondRecord,
    LawReproduced,
    MovedColumn,
    MovedZero,
    NoiseGain,
    OtherGain,
    OtherGains,
    OtherInjectedSize,
    OtherScale,
    OtherTestSignal,
    OtherVelocity,
    ReferenceClock,
    RepairedLaw,
    ScaledColumn,
    UndeclaredLimit,
    UnexplainedControl,
)
from axisid.estimation.diagnostics.scale_of_control import ControlScaleMoves
from axisid.estimation.findings import Finding
from axisid.estimation.records import OtherPeriod

FITS = LawReproduced(residual_percent=0.24)
KP = OtherGain(name="kp", value=160.0, declared=200.0, times=0.8)
KV = OtherGain(name="kv", value=243.0, declared=270.0, times=0.9)


def late(samples: int, **others: Any) -> LateControl:
    values = {
        "residual_percent": 12.0,
        "samples": samples,
        "is_at_least": False,
        "is_before_law": False,
        "blame": "law or log",
        "delay": None,
        "shift": -samples,
    }
    return LateControl(**{**values, **others})


def gains(*alternatives: tuple[OtherGain, ...], **others: Any) -> OtherGains:
    values = {"residual_percent": 12.0, "is_large": True, "has_right_gains": True}
    return OtherGains(alternatives=alternatives, **{**values, **others})


def moved_zero(control: float | None, *, exceeds_limit: bool = False) -> MovedZero:
    return MovedZero(
        position=1e-3,
        unit="m",
        column="qm",
        control=control,
        control_unit="V",
        exceeds_limit=exceeds_limit,
    )


@pytest.mark.parametrize(
    ("finding", "parts"),
    [
        (FITS, ["0.24 % of the control"]),
        (LawReproduced(residual_percent=0.24, open_percent=0.3), ["0.24 %", "0.3 %"]),
        (
            FoundByReading(reading="sampled rows", finding=FITS, recorded_percent=3.0),
            ["0.24 %", "as they were sampled", "3 %", "remove resample"],
        ),
        (
            FoundByReading(reading="even times", finding=gains((KP,))),
            ["at even times", "kp is 160 instead of 200 (0.8 times"],
        ),
        (
            OtherPeriod(period=2e-3, law_period=1e-3, kept=2, is_given=False),
            ["0.002 s", "0.001 s", "one sample in 2", "sample_period=0.002"],
        ),
        (
            OtherPeriod(period=1e-5, law_period=1e-3, kept=None, is_given=False),
            ["its own clock", "sample_period=0.00001"],
        ),
        (
            OtherPeriod(period=2e-3, law_period=1e-3, kept=2, is_given=True),
            ["sample_period=0.002", "reference_between"],
        ),
        (late(2, delay=2), ["12 % of the control", "2 samples later", "delay=2", "-2", "applied"]),
        (
            late(-1, is_before_law=True, unknown="the motion is short"),
            ["1 sample earlier", "before the law", "applies", "the motion is short"],
        ),
        (late(5, is_at_least=True), ["at least 5 samples", "Check the clocks"]),
        (late(-1, blame="log", shift=1), ["the log is wrong", 'shift={"control": 1}']),
        (
            late(-1, blame="position or reference"),
            ['shift={"reference": 1}', 'shift={"position": 1}'],
        ),
        (late(1, blame="law", delay=1, shift=0), ["Declare delay=1", "when it is recorded"]),
        (
            ConstantOrDrift(residual_percent=2.0, constant=0.1, drift=0.2, unit="V"),
            ["a constant of 0.1 V", "a drift of 0.2 V over the record", "2 %", "Check the offset"],
        ),
        (
            gains((KP,)),
            ["0.8 times", "160 instead of 200", "every other gain", "Declare that gain"],
        ),
        (
            gains((KP, KV), has_right_gains=False, injected_differs=True),
            [
                "kp is ",
                "0.8 times",
                "and kv is ",
                "0.9 times",
                "Declare these gains",
                "size of the test signal",
            ],
        ),
        (gains((KP,), (KV,), is_large=False), ["except for a factor", "; or kv", "does not show"]),
        (
            gains((KP,), scale=ControlScale(times=0.8, units=None)),
            ["control is 0.8 times the true", "The law alone", "check the unit and the scaling"],
        ),
        (
            gains((KP,), scale=ControlScale(times=-1.0, units=None)),
            ["the sign of the recorded control is opposite", "check the sign"],
        ),
        (
            OtherScale(
                residual_percent=100.0,
                is_large=True,
                scale=ControlScale(times=1e-3, units=("mm", "m")),
                scaled_percent=0.3,
            ),
            ["larger than the control", "mm for m", "0.001 times", "0.3 %", "Check the unit"],
        ),
        (OtherInjectedSize(residual_percent=12.0, is_large=True), ["size of the test signal"]),
        (
            UnexplainedControl(residual_percent=12.0, is_large=True, may_be_injected=True),
            ["axisid law", "estimation.find_law", 'columns={"injected": "NAME"}', "injected_at="],
        ),
        (
            FoundGainsAgree(finding=FITS, gains={"kp": 160.0}, standard_errors=1.2),
            ["kp = 160", "1.2 joint standard errors", "0.24 %"],
        ),
        (
            FoundGainsDiffer(
                residual_percent=0.24,
                gains={"kp": 160.0, "kv": 243.0},
                found={"kp": 200.0, "kv": 270.0},
                standard_errors=9.0,
            ),
            ["kp = 160 and kv = 243", "kp = 200 and kv = 270", "9 joint", "0.24 %", "fixed"],
        ),
        (LawOfSecondRecord(result="estimates", finding=FITS), ["the estimates", "0.24 %"]),
        (LawOfSecondRecord(result="fit", finding=FITS), ["axis of the fit", "0.24 %"]),
        (
            ControlScaleMoves(
                finding=FITS,
                scale=1.005,
                parameter="M",
                change=0.45,
                unit="kg",
                standard_errors=5.0,
            ),
            ["1.005 times", "M by +0.45 kg", "5 standard errors", "0.24 %", "Check the scale"],
        ),
        (NoiseGain(ratio=1.01, agrees=True), ["1.01 times"]),
        (NoiseGain(ratio=1000.0, agrees=False), ["1000 times", "Check the units"]),
    ],
)
def test_a_finding_is_told_with_its_numbers_and_its_remedy(
    finding: Finding, parts: list[str]
) -> None:
    for part in parts:
        assert part in finding.sentence


@pytest.mark.parametrize(
    ("repair", "parts"),
    [
        (ExchangedColumns(), ["position and reference exchanged", "Check"]),
        (OtherTestSignal(change="added to the reference"), ['injected_at="reference"']),
        (OtherTestSignal(change="opposite sign"), ["times -1", "Check its sign"]),
        (OtherTestSignal(change="none"), ["without the test signal", "Check"]),
        (
            ScaledColumn(role="position", times=1e-3, column="qm", unit="mm"),
            ["position times 0.001", 'columns={"position": "qm:mm"}'],
        ),
        (ScaledColumn(role="position", times=0.02, column="qm", unit=None), ["qm:UNIT*0.02"]),
        (MovedColumn(role="feed", samples=-2), ["feed 2 samples earlier", 'shift={"feed": -2}']),
        (ReferenceClock(rate=5e-4), ["500 ppm shorter", "fast", "one clock"]),
        (ReferenceClock(rate=-5e-4), ["500 ppm longer", "slow"]),
        (moved_zero(None), ["+0.001 m", "qm:UNIT-0.001m"]),
        (moved_zero(0.1), ["0.1 V too large", "qm:UNIT-0.001m", "integral"]),
        (moved_zero(90.0, exceeds_limit=True), ["90 V", "more than the drive gives"]),
        (OtherVelocity(law="cascade_pd"), ["cascade_pd", "Declare that law"]),
        (UndeclaredLimit(limit=3.2, unit="V", samples=40), ["3.2 V", "40 samples", "Declare"]),
    ],
)
def test_a_change_with_which_the_law_fits_is_told_with_its_remedy(
    repair: Any, parts: list[str]
) -> None:
    found = RepairedLaw(residual_percent=40.0, repaired_percent=0.2, repair=repair)
    for part in ["40 % of the control", "0.2 %", *parts]:
        assert part in found.sentence
