"""Without a reference the noise of the position shows the scale of position and control."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, load_axis, twin_record
from axisid.codegen.generated_axes import GeneratedAxis, build as build_axis
from axisid.estimation.diagnostics.control_law import NoiseGain, noise_gain_check


@pytest.fixture(scope="module")
def axis() -> GeneratedAxis:
    return build_axis(load_axis("pendulum"))


@pytest.fixture(scope="module")
def without_reference(axis: GeneratedAxis) -> Record:
    return replace(twin_record(axis, seed=3), reference=None)


@pytest.mark.parametrize(
    ("of_position", "of_control", "status"),
    [
        (1.0, 1.0, "pass"),
        (1.1, 1.0, "pass"),
        (1000.0, 1.0, "fail"),
        (1 / 57.3, 1.0, "fail"),
        (1.0, 1000.0, "fail"),
        (1.0, -1.0, "fail"),
    ],
)
def test_the_product_of_both_scales_is_checked(
    axis: GeneratedAxis,
    without_reference: Record,
    of_position: float,
    of_control: float,
    status: str,
) -> None:
    record = replace(
        without_reference,
        position=of_position * without_reference.position,
        control=of_control * np.asarray(without_reference.control),
    )
    found = noise_gain_check(axis, record)
    assert found is not None
    assert found.status == status
    assert found.figure == pytest.approx(of_control / of_position, rel=0.02)
    assert found.finding == NoiseGain(ratio=found.figure, agrees=status == "pass")


def test_nothing_is_said_with_a_reference_or_where_the_position_has_no_noise(
    axis: GeneratedAxis, without_reference: Record
) -> None:
    assert noise_gain_check(axis, twin_record(axis, seed=3)) is None
    control = np.asarray(without_reference.control)
    noisy = control + np.random.default_rng(1).normal(size=len(control))
    assert noise_gain_check(axis, replace(without_reference, control=noisy)) is None
