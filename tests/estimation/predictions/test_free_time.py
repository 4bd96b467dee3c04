"""Errors by a time of the drive are those of the loops that have it."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, build, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.parameters import FormByTime
from axisid.estimation.predictions import LoopPredictions, Predictions, WindowPredictions
from axisid.estimation.regression import InverseForm
from axisid.modeling.quantities import Parameter

THETA = np.array([100.2, 236.9, 24.8])
LATER, STEP = 2e-5, 5e-5


def _late(axis: GeneratedAxis, name: str, time: float) -> GeneratedAxis:
    drive = axis.declared.drive.with_time(name, time)
    return build(replace(axis.declared, drive=drive))


@pytest.mark.parametrize("name", ["lag", "delay"])
@pytest.mark.parametrize("output", ["control", "open-loop"])
def test_errors_are_a_straight_line_of_the_time(
    emps2015: GeneratedAxis, output: str, name: str
) -> None:
    record = twin_record(emps2015).windowed((None, 0.4))
    form = InverseForm(emps2015)
    time = Parameter(name, "s", lower=0.0)

    def of(axis: GeneratedAxis, form: InverseForm, records: list[Record]) -> Predictions:
        axes = [axis] * len(records)
        if output == "open-loop":
            return WindowPredictions(form, axes, records, 0.1)
        return LoopPredictions(form, axes, records, output)

    every_other = {name: values[::2] for name, values in record.channels().items()}
    slow = Record(**every_other, sample_period=2e-3)
    records = [record, slow] if output == "open-loop" else [record]
    now, late = (_late(emps2015, name, 4e-4 + more) for more in (0.0, LATER))
    with_time = FormByTime(emps2015, of_model=form, time=time)
    timed = of(now, with_time, records)
    step = of(_late(emps2015, name, 4e-4 + STEP), with_time, records)
    other, here = of(late, form, records), of(now, form, records)
    timed.follow_time(step, np.append(THETA, 4e-4), 4e-4, STEP)
    for each in (other, here):
        each.settle(THETA)
    found = timed(np.append(THETA, 4e-4 + LATER)[None, :]).errors[:, 0]
    expected = other(THETA[None, :]).errors[:, 0]
    before = here(THETA[None, :]).errors[:, 0]
    assert np.linalg.norm(found - expected) < 0.05 * np.linalg.norm(expected - before)
