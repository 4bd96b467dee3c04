"""Blocks of laws give what scipy.signal, or a loop written by hand, gives of the same samples."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from axisid import build, load_axis
from axisid.control import (
    MEASURED_POSITION,
    REFERENCE,
    Block,
    ControlLaw,
    gain,
    low_pass,
    notch,
    rate_limit,
)
from axisid.estimation.loops import LawTicks, control_along, state_at_rest
from axisid.support.arrays import Array

PERIOD, SAMPLES = 1e-3, 400


def _values() -> tuple[Array, Array]:
    rng = np.random.default_rng(1)
    reference, position = (0.3 + 0.1 * np.cumsum(rng.normal(size=SAMPLES)) for _ in range(2))
    return reference, position


def _along(block: Block, **gains: float) -> Array:
    """What a block gives along a reference and a position."""
    law = ControlLaw(
        name="block", period=PERIOD, output=block.value, memory=block.memory, gains=gains
    )
    axis = load_axis("emps2015")
    axis = replace(axis, control=law, drive=replace(axis.drive, limit=np.inf))
    generated = build(axis, native=False)
    ticks = LawTicks.at_samples(*_values(), np.zeros(SAMPLES))
    return control_along(generated, ticks, state_at_rest(generated, ticks))


def test_low_pass_is_a_recursion_of_first_order() -> None:
    _, position = _values()
    block = low_pass(MEASURED_POSITION, time_constant=4e-3, start=MEASURED_POSITION)
    share = PERIOD / (PERIOD + 4e-3)
    rest = signal.lfilter_zi([share], [1, share - 1]) * position[0]
    wanted, _ = signal.lfilter([share], [1, share - 1], position, zi=rest)
    np.testing.assert_allclose(_along(block), wanted, rtol=1e-12)


@pytest.mark.parametrize(("frequency", "quality"), [(80.0, 1.0), (120.0, 5.0)])
def test_notch_is_that_of_scipy(frequency: float, quality: float) -> None:
    reference, _ = _values()
    block = notch(REFERENCE, frequency=frequency, quality=quality, start=REFERENCE)
    above, below = signal.iirnotch(frequency, quality, 1 / PERIOD)
    rest = signal.lfilter_zi(above, below) * reference[0]
    wanted, _ = signal.lfilter(above, below, reference, zi=rest)
    np.testing.assert_allclose(_along(block), wanted, rtol=1e-10)


def test_a_gain_may_be_the_number_of_a_block() -> None:
    plain = notch(REFERENCE, frequency=80.0, start=REFERENCE)
    named = notch(REFERENCE, frequency=gain("f"), start=REFERENCE)
    np.testing.assert_array_equal(_along(plain), _along(named, f=80.0))


def test_rate_limit_follows_no_faster() -> None:
    reference, _ = _values()
    along = _along(rate_limit(REFERENCE, rate=50.0, start=REFERENCE))
    last, wanted = reference[0], []
    for value in reference:
        last += min(max(value - last, -0.05), 0.05)
        wanted.append(last)
    np.testing.assert_allclose(along, wanted, rtol=1e-12)
    assert np.abs(np.diff(along)).max() <= 0.05 + 1e-12
