"""The compiled filter of columns against SciPy's."""

import platform

import numpy as np
import pytest
from scipy.signal import butter, sosfilt_zi, sosfiltfilt

from axisid.codegen.runtime.batched_rows import ColumnFilter, column_filter
from axisid.support.arrays import Array

pytestmark = pytest.mark.usefixtures("c_compiler")


@pytest.fixture(scope="module")
def compiled() -> ColumnFilter:
    return column_filter()


def _columns(count: int) -> Array:
    return np.random.default_rng(count).normal(size=(400, count)).cumsum(axis=0)


@pytest.mark.parametrize("order", [1, 4, 8, 10])
@pytest.mark.parametrize("count", [1, 3, 4, 9])
def test_columns_are_filtered_as_scipy_does(compiled: ColumnFilter, order: int, count: int) -> None:
    sections = butter(order, 0.2, output="sos")
    settled, padding = sosfilt_zi(sections), 3 * order
    columns = _columns(count)
    found = compiled.without_phase(columns, sections, settled, padding)
    wanted = sosfiltfilt(sections, columns, axis=0, padlen=padding)
    if platform.machine() == "x86_64":  # elsewhere SciPy's compiler may fuse products and sums
        assert np.array_equal(found, wanted)
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize(
    "laid",
    [np.asfortranarray, lambda x: np.repeat(x, 2, axis=0)[::2], lambda x: x[:, ::-1][:, ::-1]],
    ids=["by column", "every other", "turned"],
)
def test_columns_may_lie_in_memory_in_any_way(compiled: ColumnFilter, laid: object) -> None:
    sections = butter(4, 0.2, output="sos")
    columns = _columns(3)
    how = (sections, sosfilt_zi(sections), 12)
    wanted = compiled.without_phase(columns, *how)
    assert np.array_equal(compiled.without_phase(laid(columns), *how), wanted)  # type: ignore[operator]
