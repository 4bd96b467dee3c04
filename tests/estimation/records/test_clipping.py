"""Flat tops are told from what a right signal may show: rounding, rests, set values, holds."""

import re
from collections.abc import Sequence

import numpy as np
import pytest

from axisid import read_record, simulate, twin_record
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation import Repairs
from axisid.estimation.raw_tables import Samples
from axisid.estimation.records.clipping import clipped
from axisid.estimation.records.columns import RoleColumns
from axisid.modeling.declaration import Axis

TIME = 1e-3 * np.arange(6000)
MOTION = np.sin(TIME)


def masked(force: np.ndarray, position: np.ndarray = MOTION) -> np.ndarray:
    """Samples of a force that are masked."""
    return only_masked(sampled(position=position, force=force)).masks["force"]


def only_masked(columns: RoleColumns, axis: Axis | None = None) -> RoleColumns:
    return clipped(columns, axis, masked=True)[0]


def sampled(**columns: np.ndarray) -> RoleColumns:
    samples = {role: Samples(values=values) for role, values in columns.items()}
    return RoleColumns(source="log", names={}, samples=samples)


def rounded(values: np.ndarray, bits: int) -> np.ndarray:
    """As a converter of so many bits, with a fifth of its range unused, gives them."""
    if not bits:
        return values
    quantum = 2.4 * np.abs(values).max() / 2**bits
    return quantum * np.round(values / quantum)


def profile(levels: Sequence[float], ramp: int, hold: int = 200) -> np.ndarray:
    """Set values that are held, with straight ramps between them."""
    pieces, last = [np.zeros(50)], 0.0
    for level in levels:
        if ramp:
            pieces.append(np.linspace(last, level, ramp + 1)[1:])
        pieces.append(np.full(hold, level))
        last = level
    return np.concatenate([*pieces, np.zeros(50)])


@pytest.mark.slow
@pytest.mark.parametrize("noise", [None, 0.0])
def test_right_control_of_every_axis_is_left_alone(
    library_axis: GeneratedAxis, noise: float | None
) -> None:
    record = twin_record(library_axis, position_noise=noise)
    control = np.asarray(record.control)
    assert np.abs(control).max() < library_axis.axis.drive.limit
    counts = 1e-5 * np.round(record.position / 1e-5)
    for position in (record.position, counts):
        for bits in (0, 16, 12, 10, 8):
            assert not masked(rounded(control, bits), position).any()


@pytest.mark.slow
def test_control_that_a_recorder_cut_off_is_found(library_axis: GeneratedAxis) -> None:
    record = twin_record(library_axis)
    whole = np.asarray(record.control)
    for share, bits in ((0.5, 0), (0.7, 0), (0.9, 0), (0.7, 16), (0.5, 12), (0.9, 12)):
        level = share * float(np.quantile(np.abs(whole), 0.999))
        control = rounded(np.clip(whole, -level, level), bits)
        columns = sampled(position=record.position, control=control)
        found = only_masked(columns, library_axis.axis)
        top = np.abs(control) >= np.abs(control).max() * (1 - 1e-9)
        assert np.array_equal(found.masks["control"], top)
        sides = " and ".join(f"{value:.6g}" for value in np.unique(control[top]))
        assert f"control {top.sum()} (at {sides})" in found.repairs[0].text


@pytest.mark.parametrize("quantum", [0.0, 1e-3, 6 / 4096])
@pytest.mark.parametrize(
    ("levels", "ramp"),
    [([3, 0, -3, 0], 37), ([3, -3], 53), ([3, 0, -3, 0], 0), ([1, 2, 3, 2, 0, -3, 0], 0)],
)
def test_set_values_are_not_cut_off(levels: list[float], ramp: int, quantum: float) -> None:
    force = profile(levels * 4, ramp)
    corners = [0, 0.3, 0.7123, 1.5001, 1.9, 2.5, 2.8111, 3.9007, 4.2, 6]  # between samples
    assert not masked(np.interp(TIME, corners, [0, 0, 3, 3, 0, 0, -3, -3, 0, 0])).any()
    if quantum:
        force = quantum * np.round(force / quantum)
    position = np.cumsum(np.cumsum(force)) * 1e-6
    assert not masked(force, position).any()


@pytest.mark.parametrize("bits", [0, 12, 10, 8])
@pytest.mark.parametrize("hertz", [0.2, 1.0, 5.0])
def test_peaks_of_a_rounded_sine_are_not_cut_off(hertz: float, bits: int) -> None:
    sine = np.sin(2 * np.pi * hertz * TIME)
    assert not masked(rounded(sine, bits)).any()
    cut = rounded(np.clip(sine, -0.8, 0.8), bits)
    # A slope of less than two quanta in a sample cannot be told from a rounded peak.
    quantum = 2.4 * 0.8 / 2**bits if bits else 0.0
    if 0.6 * 2 * np.pi * hertz * 1e-3 > 3 * quantum:
        assert np.array_equal(masked(cut), np.abs(cut) == np.abs(cut).max())


@pytest.mark.parametrize("held", [2, 4, 10])
def test_control_that_is_written_less_often_keeps_every_value(
    rng: np.random.Generator, held: int
) -> None:
    signal = np.sin(20 * TIME) + 0.01 * rng.normal(size=len(TIME))
    slow = np.repeat(signal[::held], held)[: len(TIME)]
    assert not masked(slow).any()
    cut = np.clip(slow, -0.7, 0.7)
    assert np.array_equal(masked(cut), np.abs(cut) == 0.7)


def test_control_at_rest_is_not_cut_off(emps: GeneratedAxis) -> None:
    """A loop without noise holds its control to the last bit while the axis sticks."""
    record = twin_record(emps, position_noise=0.0)
    reference = np.concatenate([np.asarray(record.reference), np.full(3000, 0.05)])
    theta = np.array([record.provenance.truth[name] for name in emps.names])
    loop = simulate(emps, theta, reference, record.period)
    weight = 4 * np.abs(loop.control).max()  # what a vertical axis would hold up
    at_rest = np.where(np.abs(np.gradient(loop.measured_position)) > 0, 0.0, weight)
    assert not masked(loop.control + at_rest, loop.measured_position).any()


def test_a_control_that_is_cut_off_is_told_where_no_mask_was_asked_for(
    emps2015: GeneratedAxis,
) -> None:
    columns = twin_record(emps2015).channels()
    top = 0.6 * float(np.abs(columns["control"]).max())
    cut = {**columns, "control": np.clip(columns["control"], -top, top)}
    (doubt,) = read_record(cut, emps2015).provenance.doubts
    assert re.search('the control is clipped in .*mask = "clipped"', doubt)
    for right, repairs in ((columns, Repairs()), (cut, Repairs(mask="clipped"))):
        assert not read_record(right, emps2015, repairs=repairs).provenance.doubts
