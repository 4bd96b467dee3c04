"""Sentences of the residual, the simulated loop and noise have all numbers of their findings."""

from dataclasses import replace

import pytest

from axisid.estimation.diagnostics.model_error_checks import (
    LoopNotSimulated,
    ResidualAtRepeats,
    SimulatedLoop,
)
from axisid.estimation.noise_models import Chain, NoiseSources, noise_sources
from axisid.estimation.signals import RestingAxis
from axisid.presentation.sentences import sentence
from axisid.support.settings import setting

RESIDUAL = ResidualAtRepeats(
    nature="systematic",
    percent=97.0,
    repeated=1.8,
    noise=0.34,
    repeated_percent=3.7,
    unit="N",
    left="force",
    period=6.24,
)
LOOP = SimulatedLoop(
    percent=60.0, left="force", reproduces=False, is_misspecified=False, rest=None, noise=None
)


@pytest.mark.parametrize("nature", ["systematic", "steps", "small", "none"])
def test_the_residual_is_split_into_what_repeats_and_noise(nature: str) -> None:
    text = sentence(replace(RESIDUAL, nature=nature))
    parts = ["97 %", "repeats", "every 6.24 s", "0.34 N (rms) is noise"]
    if nature != "none":
        parts.append("1.8 N (rms, 3.7 % of the force)")
    assert [part for part in parts if part not in text] == []
    assert "every" not in sentence(replace(RESIDUAL, period=None))


def test_a_loop_that_is_not_simulated_has_its_reason() -> None:
    texts = [
        sentence(LoopNotSimulated(reason="it is too stiff", is_misspecified=each))
        for each in (False, True)
    ]
    assert all("it is too stiff" in text for text in texts)
    assert "Correct the model first" in texts[1].removeprefix(texts[0])


@pytest.mark.parametrize(
    ("changed", "parts"),
    [
        ({}, ["control law", "signs"]),
        ({"percent": 46.0, "reproduces": True}, ["46 % of the force"]),
        ({"rest": RestingAxis(percent=60.0)}, ["60 % of the samples"]),
        ({"rest": RestingAxis(percent=60.0)}, [setting("reversals", "leave-out")]),
        ({"is_misspecified": True}, ["Correct the model first"]),
        ({"noise": noise_sources(Chain(position=1e-6), "m", "A")}, ["position 1e-06 m"]),
    ],
)
def test_a_simulated_loop_has_its_error_and_a_cause(
    changed: dict[str, object], parts: list[str]
) -> None:
    finding = replace(LOOP, **changed)  # type: ignore[arg-type]
    text = sentence(finding)
    assert f"{finding.percent:g} % of the force" in text
    assert [part for part in parts if part not in text] == []


def test_every_source_of_noise_has_its_size_and_unit() -> None:
    chain = Chain(
        position_step=1e-5,
        position=2e-6,
        velocity_step=3e-3,
        velocity=4e-3,
        acceleration=5e-2,
        jitter=6e-6,
        control_step=7e-2,
        control=((0.0, 0.08),),
        disturbances=((0.1, 0.09),),
        is_measured_by_law=False,
    )
    found = noise_sources(chain, "rad", "A")
    text = sentence(found)
    for source in found.sources:
        assert f"{source.size:.3g} {source.unit}" in text
    assert len(found.sources) == 9
    assert "(white)" in text
    assert "0.1 s" in text
    assert "another position" in text
    assert sentence(NoiseSources(sources=())) == "no noise"
