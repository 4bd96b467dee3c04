"""A position from another zero than the reference is told with its size, beside the control's."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, build, load_axis, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.control import BALANCED
from axisid.estimation import check_law
from axisid.estimation.diagnostics.law.control_law import LawCheck
from axisid.estimation.diagnostics.law.sentences import position_zero
from tests.estimation.loops.test_start import carried
from tests.estimation.simulation.test_loop_start import vertical

AXES = ("emps", "vertical_screw", "pendulum", "belt_axis")


def _checked(axis: GeneratedAxis, record: Record) -> LawCheck:
    return check_law(axis, record)


@pytest.mark.slow
@pytest.mark.parametrize("name", AXES)
def test_a_zero_apart_is_told_with_its_size_and_taken_off(name: str) -> None:
    axis = build(load_axis(name))
    record = twin_record(axis)
    assert _checked(axis, record).passed
    control = np.asarray(record.control)
    law = axis.axis.control
    # As much as makes a third of the control.
    unit = position_zero(axis, law, replace(record, control=control + 1.0))
    away = unit.away / 3 * float(np.std(control))
    off = replace(record, position=record.position + away)
    found = _checked(axis, off)
    assert not found.passed
    assert f"{away:+.3g} {axis.axis.coordinate.unit} away from its zero" in found.meaning
    assert "tracking error" in found.meaning
    told = position_zero(axis, law, off)
    assert told.away == pytest.approx(away, rel=2e-2)
    mended = replace(off, position=off.position - told.away)
    assert _checked(axis, mended).passed


@pytest.mark.slow
def test_a_law_that_integrates_is_told_the_position_alone() -> None:
    record, _ = carried(0)
    found = _checked(vertical(BALANCED), replace(record, position=record.position + 1e-3))
    assert not found.passed
    assert "+0.001 m away from its zero" in found.meaning
    assert "off the control" not in found.sentence
