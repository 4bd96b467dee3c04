"""Searches simulate a drive without its steps, and an axis as it is compiled."""

from dataclasses import replace

import pytest

from axisid import build, load_axis
from axisid.estimation.predictions.loop_predictions import unrounded


@pytest.mark.parametrize("step", [0.0, 0.01])
def test_an_equal_axis_that_is_not_compiled_takes_no_ones_place(step: float) -> None:
    axis = load_axis("emps2015")
    declared = replace(axis, drive=replace(axis.drive, quantisation=step))
    slow, fast = (build(declared, native=native) for native in (False, True))
    assert slow == fast
    for each in (slow, fast, slow):
        found = unrounded(each)
        assert found.native.enabled == each.native.enabled
        assert not found.declared.drive.quantisation
