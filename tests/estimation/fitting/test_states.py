"""Friction that remembers has no rows, and is fitted by the simulated loop."""

from typing import Any

import numpy as np
import pytest

from axisid import Parameter, Record, build, fit, identify, simulate
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.elements import dahl
from axisid.support.arrays import Array
from tests.axes.remembering import CASCADE, Fc, bristle, declared, virtual, x
from tests.refusals import refuses


def _record(axis: GeneratedAxis, theta: Array, *, noise: float, samples: int) -> Record:
    """A record of a swing whose frequency grows, each turn followed by a wiggle of micrometres."""
    time = axis.axis.control.period * np.arange(samples)  # type: ignore[union-attr]
    slow = 2e-3 * np.sin(2 * np.pi * (0.5 * time + 0.6 * time**2))
    held = np.floor(time / 0.5) % 3 == 2
    last = np.maximum.accumulate(np.where(held, 0, np.arange(samples)))
    reference = slow[last] + np.where(held, 1e-5 * np.sin(4 * np.pi * time), 0.0)
    white = noise * np.random.default_rng(1).normal(size=samples)
    loop = simulate(axis, theta, reference, time[1], position_noise=white)
    return Record(
        time=loop.time,
        position=loop.measured_position,
        reference=reference,
        control=loop.control,
    )


@pytest.mark.parametrize("how", [{}, {"methods": ["didim"]}, {"methods": ["idm-iv"]}])
def test_methods_of_rows_refuse_what_no_record_has(how: dict[str, Any]) -> None:
    axis = virtual("dahl")
    record = _record(axis, axis.nominal, noise=0.0, samples=50)
    with refuses("states-no-rows"):
        identify(axis, record, **how)
    with refuses("states-open-loop"):
        fit(axis, record, "open-loop")


@pytest.mark.slow
def test_the_parameters_of_a_bristle_lie_within_their_own_intervals() -> None:
    axis = build(bristle(control=CASCADE))
    truth = axis.nominal * [0.9, 1.25, 0.8, 1.1, 0.9, 1.1, 0.8]
    result = fit(axis, _record(axis, truth, noise=2e-9, samples=4000))
    assert result.started == "nominal"
    assert "remembers" in result.remarks[0].text
    for name, value in zip(axis.names, truth, strict=True):
        low, high = result.parameters[name].interval
        assert low <= value <= high, name
        assert result.parameters[name].deviation < 1e-3 * value
    assert not [c.name for c in result.checks if c.status == "fail"]


def test_what_friction_remembers_by_is_not_searched_from_nothing() -> None:
    unknown = Parameter("s0", "N/m", lower=0.0)
    axis = build(declared("unsized", (unknown, Fc), dahl(unknown, x, coulomb=Fc)))
    right = virtual("dahl")
    record = _record(right, right.nominal, noise=0.0, samples=300)
    with refuses("fit-state-zero"):
        fit(axis, record)


@pytest.mark.parametrize("time", ["lag", "delay"])
def test_a_time_of_the_drive_is_not_free_beside_friction_that_remembers(time: str) -> None:
    axis = build(bristle(control=CASCADE))
    record = _record(axis, axis.nominal, noise=0.0, samples=50)
    with refuses("free-time-states"):
        fit(axis, record, free=time)


def test_friction_that_is_too_stiff_to_be_searched_is_refused_at_once() -> None:
    axis = virtual("dahl")
    record = _record(axis, axis.nominal, noise=0.0, samples=50)
    with refuses("fit-too-stiff", says="a sample takes 1024 steps"):
        fit(axis, record, start={"s0": 1e12})
