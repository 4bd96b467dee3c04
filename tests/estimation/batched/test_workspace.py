"""Memory that one block after the other is worked out in."""

from threading import Thread

import numpy as np
import pytest

from axisid.estimation.batched import workspace


def in_a_thread_of_its_own(check: object) -> None:
    failed: list[BaseException] = []

    def run() -> None:
        try:
            check()  # type: ignore[operator]
        except BaseException as error:
            failed.append(error)

    thread = Thread(target=run)
    thread.start()
    thread.join()
    if failed:
        raise failed[0]


def test_the_next_block_has_the_memory_of_the_one_before() -> None:
    def check() -> None:
        first = workspace.space("rows", 10, 4)
        assert first.shape == (10, 4)
        assert workspace.space("rows", 5, 8).base is first.base
        assert workspace.space("other", 10, 4).base is not first.base

    in_a_thread_of_its_own(check)


def test_arrays_begin_with_a_line_of_the_cache() -> None:
    def check() -> None:
        for size in (3, 1000, 50_001):
            assert workspace.space(f"of {size}", size).ctypes.data % 64 == 0

    in_a_thread_of_its_own(check)


def test_what_is_kept_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workspace, "_MOST", 100)

    def kept() -> int:
        arrays = vars(workspace._KEPT).get("arrays", {})
        return sum(each.size for each in arrays.values())

    def check() -> None:
        for number in range(8):
            assert workspace.space(f"{number}", 6, 5).shape == (6, 5)
        assert kept() == 90
        assert workspace.space("0", 50, 50).shape == (50, 50)  # grown: the old one is let go
        assert kept() == 60

    in_a_thread_of_its_own(check)


def test_chosen_lanes_come_in_the_order_they_are_chosen_in() -> None:
    """Also as many as there are: repeated, or in another order."""
    values = np.arange(12.0).reshape(4, 3)
    for chosen in ([0, 1, 2], [2, 0, 1], [0, 0, 2], [1], [0, 1, 2, 0]):
        lanes = np.array(chosen)
        assert np.array_equal(workspace.of_lanes(values, lanes), values[:, chosen])
        if len(set(chosen)) == len(chosen):
            put = np.zeros((4, 3))
            workspace.put_lanes(put, lanes, values[:, chosen])
            assert np.array_equal(put[:, chosen], values[:, chosen])
    assert workspace.of_lanes(values, np.arange(3)) is values
    assert workspace.some_lanes(None, np.arange(3)) is None
