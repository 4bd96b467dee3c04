"""Columns of clocks of their own on one grid: exact where the curve is, cut where nothing is."""

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, strategies as st

from axisid.estimation.records.columns import RoleColumns
from axisid.estimation.records.resampling import AlignedColumns, resample
from axisid.estimation.tables import Samples
from tests.refusals import refuses

PERIOD = 1e-3
Clock = np.ndarray


def cubic(time: np.ndarray) -> np.ndarray:
    return 0.3 - 2 * time + 5 * time**2 - 40 * time**3


def line(time: np.ndarray) -> np.ndarray:
    return 4.0 - 3.0 * time


def laid(
    position: Clock, force: Clock, rate: float | str = "auto", *, split: bool = False, **more: float
) -> AlignedColumns:
    """A position on a cubic, a force on a line, each at its own times."""
    samples = {
        "position": Samples(values=cubic(position), clock=position),
        "force": Samples(values=line(force), clock=force),
    }
    columns = RoleColumns(source="log", names={}, samples=samples)
    return resample(columns, rate, split=split, **more)  # type: ignore[arg-type]


@pytest.mark.slow
@given(
    lost=st.sets(st.integers(1, 298), max_size=40),
    late=st.floats(0.0, 0.9),
    slower=st.integers(1, 7),
    rate=st.floats(1000.0, 5000.0),
)
def test_cubics_and_lines_come_back_at_any_rate(
    lost: set[int], late: float, slower: int, rate: float
) -> None:
    """A spline has no error on a cubic, a straight line none on a line, whatever was sampled."""
    position = PERIOD * np.array([k for k in range(300) if k not in lost])
    force = PERIOD * (late + np.arange(0, 300, slower))
    found = laid(position, force, rate, split=True, stated=PERIOD)
    assert found.columns["position"] == pytest.approx(cubic(found.time), abs=1e-10)
    assert found.columns["force"] == pytest.approx(line(found.time), abs=1e-10)
    assert found.period == pytest.approx(1 / rate)
    for start, stop in found.segments:
        assert np.diff(found.time[start:stop]) == pytest.approx(1 / rate, rel=1e-6)


@pytest.mark.slow
@given(
    position=st.sets(st.integers(1, 9), max_size=4),
    force=st.sets(st.integers(1, 9), max_size=4),
)
def test_rows_are_where_every_column_has_samples(position: set[int], force: set[int]) -> None:
    """Of ten stretches of 40 ms, 20 ms long each, some are missing of one column or the other."""

    def clock(missing: set[int]) -> np.ndarray:
        stretches = [0.04 * k + PERIOD * np.arange(21) for k in range(10) if k not in missing]
        return np.concatenate(stretches)

    found = laid(clock(position), clock(force), split=True, stated=PERIOD)
    shared = [k for k in range(10) if k not in position | force]
    assert len(found.segments) == len(shared)
    assert found.time == pytest.approx(clock(position | force), abs=1e-9)


def test_a_piece_too_short_for_a_spline_is_left_out() -> None:
    even = PERIOD * np.arange(100)
    pieces = np.concatenate([even[:40], even[50:53], even[70:]])
    found = laid(pieces, even, split=True)
    assert found.segments == ((0, 40), (40, 70))


def test_a_rate_that_folds_the_positions_noise_is_refused() -> None:
    even = PERIOD * np.arange(100)
    assert laid(even, even, 910.0).period == pytest.approx(1 / 910)
    with refuses("resampling"):
        laid(even, even, 890.0)


@pytest.mark.parametrize(
    ("position", "force", "code"),
    [
        (np.arange(50), 100 + np.arange(50), "resampling"),
        ([0, 1, 2, 3, 3, 4], np.arange(50), "time"),
        (np.arange(50), [0, 1, 2], "too-short"),
    ],
)
def test_clocks_that_give_no_grid_are_refused(
    position: Sequence[float], force: Sequence[float], code: str
) -> None:
    with refuses(code):
        laid(PERIOD * np.asarray(position, float), PERIOD * np.asarray(force, float))


def test_both_neighbours_of_a_masked_sample_are_masked() -> None:
    even = PERIOD * np.arange(100)
    samples = {"position": Samples(values=cubic(even), clock=even)}
    mask = np.arange(100) == 50
    columns = RoleColumns(source="log", names={}, samples=samples, masks={"position": mask})
    found = resample(columns, 2000.0, split=False)
    assert np.flatnonzero(found.masked).tolist() == [99, 100, 101]
