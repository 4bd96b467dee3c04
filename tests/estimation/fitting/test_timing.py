"""A time of the drive is free where the records show it, with a law and without one."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from axisid import Axis, Record, build, fit
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.fitting.timing import split_free
from tests.refusals import refuses


def _declared(axis: Axis) -> GeneratedAxis:
    """What is asked of an axis here is its declaration."""
    return cast(GeneratedAxis, SimpleNamespace(declared=axis))


def test_an_open_loop_refuses_records_that_do_not_show_the_time(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    measured = replace(twin, force=np.sin(twin.time))
    with refuses("drive-timing-record"):
        split_free("delay", emps2015, [measured], "open-loop")
    drive = replace(emps2015.axis.drive, lag=1e-3, logged="current")
    behind = _declared(replace(emps2015.axis, drive=drive))
    with refuses("drive-timing-logged"):
        split_free("lag", behind, [twin], "open-loop")


@pytest.mark.slow
def test_a_delay_is_found_without_a_law(emps2015: GeneratedAxis, twin: Record) -> None:
    axis = build(replace(emps2015.axis, control=None))
    found = fit(axis, twin.windowed((None, 1.5)), "open-loop", free="delay", start="nominal")
    assert abs(found["delay"].value) < 4 * found["delay"].deviation + 1e-6
    assert found["delay"].deviation < 1e-4
