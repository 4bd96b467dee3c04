"""Filtering and decimation against SciPy, closed forms and the settings' own promises."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy import signal

from axisid import DataError, Prefilter
from axisid.estimation.signals import SampledFilter

PERIOD = 1e-3


def sampled(**settings: Any) -> SampledFilter:
    return SampledFilter(Prefilter(**settings), PERIOD)


def test_velocity_and_acceleration_of_a_slow_sine_are_its_derivatives() -> None:
    t = np.arange(3000) * PERIOD
    w = 2 * np.pi * 1.0
    q, dq, ddq = sampled(cutoff=100.0).motion(np.sin(w * t))
    inner = slice(200, -200)
    assert q[inner] == pytest.approx(np.sin(w * t[inner]), abs=1e-6)
    assert dq[inner] == pytest.approx(w * np.cos(w * t[inner]), abs=1e-4 * w)
    assert ddq[inner] == pytest.approx(-(w**2) * np.sin(w * t[inner]), abs=1e-4 * w**2)


def test_scipy_alignment_is_scipys_decimate_away_from_the_ends(rng: np.random.Generator) -> None:
    y = np.cumsum(rng.normal(size=2003))
    f = sampled(decimate=10, decimation="scipy", drop=(0, 0))
    expected = signal.decimate(y, 10)
    got = f.reduce(y)
    assert got.shape == expected.shape
    assert got[50:-50] == pytest.approx(expected[50:-50], abs=1e-6 * np.ptp(y))


@pytest.mark.parametrize("columns", [(), (1,), (5,)])
def test_both_filters_are_scipys_forward_and_backward_to_the_last_bit(
    rng: np.random.Generator, columns: tuple[int, ...]
) -> None:
    y = np.cumsum(rng.normal(size=(2003, *columns)), axis=0)
    decimation = signal.cheby1(8, 0.05, 0.08, output="sos")
    expected = signal.sosfiltfilt(decimation, y, axis=0, padlen=24)
    found = sampled(decimate=10, drop=(0, 0)).reduce(y)
    assert np.array_equal(found, expected[2::10])
    low_pass = signal.butter(4, 0.2, output="sos")
    flat = y.reshape(len(y), -1)[:, 0]
    expected = signal.sosfiltfilt(low_pass, flat, padlen=12)
    assert np.array_equal(sampled(cutoff=100.0).motion(flat)[0], expected)


def test_matlab_alignment_ends_with_the_last_sample() -> None:
    f = sampled(decimate=10, drop=(49, 0))
    rows = f.rows(24841)
    assert len(rows) == 2480
    assert rows[-1] == 24840
    assert rows[0] == 50


@given(
    samples=st.integers(400, 2000),
    decimate=st.integers(1, 20),
    start=st.integers(0, 60),
    end=st.integers(0, 60),
    decimation=st.sampled_from(["matlab", "scipy"]),
)
def test_rows_are_the_samples_that_reduce_keeps(
    samples: int, decimate: int, start: int, end: int, decimation: str
) -> None:
    f = sampled(decimate=decimate, decimation=decimation, drop=(start, end))
    rows = f.rows(samples)
    ramp = f.reduce(np.arange(samples, dtype=float))
    assert len(ramp) == len(rows)
    assert start <= rows[0]
    assert rows[-1] < samples - end
    # The filter passes a ramp unchanged but for its ripple at zero frequency (0.05 dB, twice).
    inner = slice(len(rows) // 4, -len(rows) // 4)
    ratio = ramp[inner] / rows[inner]
    assert ratio == pytest.approx(np.full_like(ratio, 1.0), abs=0.013)


def test_default_drop_is_the_transient_of_the_low_pass() -> None:
    start, end = sampled(cutoff=60.0).dropped
    assert (start, end) == (48, 48)
    impulse = np.zeros(1001)
    impulse[500] = 1.0
    response = np.abs(sampled(cutoff=60.0).motion(impulse)[0])
    assert response[500 + start :].max() < 2e-3 * response.max()
    assert response[500 + start // 2 :].max() > 2e-3 * response.max()


@pytest.mark.slow
@given(samples=st.integers(1, 400), decimate=st.integers(1, 30), order=st.integers(1, 10))
def test_a_record_long_enough_for_check_is_long_enough_for_the_filters(
    samples: int, decimate: int, order: int
) -> None:
    f = sampled(decimate=decimate, order=order)
    try:
        f.check(samples)
    except DataError as error:
        assert "transients take" in str(error)
        return
    assert np.all(np.isfinite(f.reduce(f.motion(np.linspace(0.0, 1.0, samples))[2])))


def test_what_is_wrong_at_the_ends_of_a_record_reaches_no_row() -> None:
    """The decimation filter is longer than the low-pass: it would carry the ends inwards."""
    samples = 4000
    ends = np.zeros(samples)
    ends[:48] = ends[-48:] = 1.0
    f = sampled(cutoff=60.0, decimate=27)
    assert f.dropped == (48, 48)
    assert not f.reduce(ends).any()
    whole = sampled(cutoff=60.0, decimate=27, drop=(0, 0))
    among = np.isin(whole.rows(samples), f.rows(samples))
    assert np.abs(whole.reduce(ends)[among]).max() > 0.1
