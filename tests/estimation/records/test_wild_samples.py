"""Wild samples are named, masked and counted; what a machine does by itself is left alone."""

import math
from dataclasses import replace

import numpy as np
import pytest

from axisid import load_axis, read_record
from axisid.estimation.raw_tables import Samples
from axisid.estimation.records.columns import RoleColumns
from axisid.estimation.records.wild_samples import leading_zeros_note, without_wild_samples

TIME = 1e-3 * np.arange(2000)
COUNT = 1e-6
#: Rests, then goes there and back, with an encoder.
MOTION = 0.02 * (1 - np.cos(2 * math.pi * np.maximum(TIME - 0.5, 0.0)))
POSITION = COUNT * np.round(MOTION / COUNT)
CONTROL = np.round(np.gradient(np.gradient(MOTION, 1e-3), 1e-3), 3)
RIGHT = {"position": POSITION, "reference": MOTION, "control": CONTROL}


def columns_of(**columns: np.ndarray) -> RoleColumns:
    clock = 1e-3 * np.arange(len(next(iter(columns.values()))))
    samples = {role: Samples(values=values, clock=clock) for role, values in columns.items()}
    return RoleColumns(source="log", names={}, samples=samples)


def cleaned(limit: float = math.inf, **columns: np.ndarray) -> RoleColumns:
    return without_wild_samples(columns_of(**(RIGHT | columns)), {}, limit)


def masked(columns: RoleColumns) -> dict[str, list[int]]:
    return {role: np.flatnonzero(mask).tolist() for role, mask in columns.masks.items()}


def moved(values: np.ndarray, by: float, *places: int) -> np.ndarray:
    changed = values.copy()
    changed[list(places)] += by
    return changed


@pytest.mark.parametrize("size", [1e2, 1e3, 3e4, 1e9, 4e66])
@pytest.mark.parametrize("places", [[0], [1], [300], [1200], [1999], [700, 1300]])
def test_a_wild_position_is_masked_counted_and_bridged(size: float, places: list[int]) -> None:
    found = cleaned(position=moved(POSITION, size * COUNT, *places))
    (repair,) = found.repairs
    assert masked(found) == {"position": places}
    assert (repair.kind, repair.count) == ("wild", len(places))
    assert found.samples["position"].values == pytest.approx(POSITION, abs=3 * COUNT)


def test_ten_wild_samples_and_two_side_by_side_are_masked() -> None:
    places = [60, 300, 301, 500, 777, 900, 1300, 1501, 1700, 1900]
    wild = POSITION.copy()
    wild[places] += 1e-3 * np.array([3, 5, -7, 1, 2, -1, 4, -2, 1, 9])
    assert masked(cleaned(position=wild)) == {"position": places}


@pytest.mark.parametrize("size", [0.01, 1.0, 1e9])
def test_a_wild_reference_that_nothing_answers_is_masked(size: float) -> None:
    assert masked(cleaned(reference=moved(MOTION, size, 1100))) == {"reference": [1100]}


def test_an_impulse_of_the_reference_that_the_control_answers_is_kept() -> None:
    found = cleaned(reference=moved(MOTION, 0.01, 1100), control=moved(CONTROL, 50.0, 1100))
    assert not found.masks
    assert not found.repairs


def test_a_wild_control_is_masked() -> None:
    assert masked(cleaned(control=moved(CONTROL, 50.0, 1100))) == {"control": [1100]}
    assert masked(cleaned(control=moved(CONTROL, 50.0, 1100), limit=10.0)) == {"control": [1100]}


@pytest.mark.parametrize("delay", [0, 1, 4])
@pytest.mark.parametrize("has_reference", [True, False])
def test_a_control_that_differentiates_a_step_of_the_reference_is_kept(
    *, has_reference: bool, delay: int
) -> None:
    step = np.where(TIME > 1.1, 0.01, 0.0)
    columns = {"position": 0.01 * (1 - np.exp(-np.maximum(TIME - 1.1, 0) / 0.05))}
    columns["control"] = 1e4 * np.diff(step, prepend=0.0) + step - columns["position"]
    columns["control"] = np.concatenate([np.zeros(delay), columns["control"]])[: len(TIME)]
    columns |= {"reference": step} if has_reference else {}
    assert not without_wild_samples(columns_of(**columns), {}, delay=delay).repairs


def test_a_relay_is_kept() -> None:
    relay = np.where(np.random.default_rng(2).random(2000) < 0.02, 1.0, -1.0)
    assert not cleaned(control=relay).repairs


@pytest.mark.parametrize("levels", [3, 54, 400])
def test_a_coarse_encoder_is_kept(levels: int) -> None:
    step = float(np.ptp(MOTION)) / levels
    noisy = MOTION + 0.2 * step * np.random.default_rng(3).normal(size=2000)
    position = step * np.round(noisy / step)
    velocity = np.diff(position, prepend=position[0]) / 1e-3
    assert not cleaned(position=position, velocity=velocity).repairs


def test_single_counts_of_a_differentiated_position_are_kept() -> None:
    position = 3.7 + COUNT * np.round(40 * TIME)  # counts one after the other, far apart
    velocity = np.diff(position, prepend=position[0]) / 1e-3
    assert not cleaned(velocity=velocity).repairs


@pytest.mark.parametrize("rows", [8, 40, 400])
def test_noise_is_kept(rows: int) -> None:
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(size=(3, rows))
        columns = dict(zip(("position", "velocity", "control"), noise, strict=True))
        assert not without_wild_samples(columns_of(**columns), {}, 10.0).repairs


def test_a_wrapped_position_is_kept_and_a_wild_sample_of_it_is_masked() -> None:
    turned = (20 * np.pi * MOTION / 0.04) % (2 * math.pi)
    # The motion turns back just beyond the seam.
    seam = (0.3 - (TIME[1000] - TIME) ** 2) % (2 * math.pi)
    for position in (turned, seam):
        right = columns_of(position=position, reference=position, control=CONTROL)
        restarts = dict.fromkeys(("position", "reference"), 2 * math.pi)
        assert not without_wild_samples(right, restarts).repairs
        wild = {"position": replace(right.samples["position"], values=moved(position, 1.0, 1200))}
        found = without_wild_samples(right.repaired(wild), restarts)
        assert masked(found) == {"position": [1200]}


def test_a_motion_after_a_gap_is_kept() -> None:
    clock = TIME + np.where(TIME > 1.0, 0.5, 0.0)
    samples = {
        role: Samples(values=values + np.where(TIME > 1.0, 1.0, 0.0), clock=clock)
        for role, values in RIGHT.items()
    }
    columns = RoleColumns(source="log", names={}, samples=samples)
    assert not without_wild_samples(columns, {}).repairs


def test_rows_of_zeros_at_the_beginning_are_told_with_the_window_that_leaves_them_out() -> None:
    late = {role: np.where(TIME < 0.07, 0.0, values + 1.0) for role, values in RIGHT.items()}
    (note,) = leading_zeros_note(columns_of(**late))
    assert "first 70 rows" in note
    assert '"0.07.."' in note
    assert not leading_zeros_note(columns_of(**(RIGHT | {"position": POSITION + 1.0})))


def test_a_record_says_what_was_masked() -> None:
    axis = load_axis("emps")
    roles = {role: role for role in ("time", *RIGHT)}
    log = {"time": TIME, **RIGHT, "position": moved(POSITION, 1e3 * COUNT, 1200)}
    record = read_record(log, axis, columns=roles)
    assert record.masked == ((1200, 1201),)
    assert [(each.kind, each.count) for each in record.provenance.repairs] == [("wild", 1)]
    assert not read_record({**log, "position": POSITION}, axis, columns=roles).masked
