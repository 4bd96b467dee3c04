"""A law that runs between the samples of a slow log, behind an encoder."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from axisid import Record, build, load_axis, read_record, twin_record
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.control import cascade_p_pi
from axisid.estimation import law_agreement
from axisid.modeling.declaration import back_and_forth

_PERIOD, _EVERY = 2.5e-4, 16


@cache
def _slow_log(step: float) -> tuple[GeneratedAxis, Record]:
    """Every 16th sample of a loop of 4 kHz behind an encoder."""
    base = load_axis("emps2015")
    assert base.experiment is not None
    moves = back_and_forth(speeds=(0.05, 0.12), acceleration=0.8, seconds=0.3, repeat=1)
    experiment = replace(base.experiment, moves=moves, position_noise=0.0, resolution=step)
    law = cascade_p_pi(kp=25.0, kv=150.0, tn=0.05, period=_PERIOD)
    axis = build(replace(base, control=law, experiment=experiment), native=False)
    columns = {name: values[3::_EVERY] for name, values in twin_record(axis).channels().items()}
    columns["time"] = _EVERY * _PERIOD * np.arange(len(columns["position"]))
    roles = {name: name for name in columns}
    return axis, read_record(columns, axis, columns=roles, sample_period=_EVERY * _PERIOD)


@pytest.mark.slow
@pytest.mark.parametrize("step", [5e-7, 2e-6])
def test_the_right_law_of_a_fast_loop_in_a_slow_log_behind_an_encoder_does_not_fail(
    step: float,
) -> None:
    axis, record = _slow_log(step)
    found = law_agreement(axis, record)
    assert getattr(found, "passed", True)
    control = np.asarray(record.control)
    opposite = law_agreement(axis, replace(record, control=-control))
    assert not getattr(opposite, "passed", True)
