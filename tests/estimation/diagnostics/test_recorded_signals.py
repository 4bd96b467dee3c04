"""A recorded signal that is late, or in another unit, is told beside the force that it makes."""

import re
from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from axisid import Record, build, identify, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.checks.check import Check
from axisid.modeling.quantities import Constant
from tests.axes.recorded import AREA, recorded_axis, recorded_values

FAULT = "recorded signals"


@cache
def _axis(kind: str, *, known: bool = False) -> GeneratedAxis:
    """The axis of a signal; with a known area its scale can be told."""
    axis = recorded_axis(kind)
    if not known:
        return build(axis)
    area = Constant(1e-3, "m^2", "area").symbol
    experiment = axis.experiment
    truth = {name: value for name, value in experiment.truth.items() if name != "A"}
    return build(
        replace(
            axis,
            parameters=tuple(p for p in axis.parameters if p.name != "A"),
            force=axis.force.subs(AREA.symbol, area),
            experiment=replace(experiment, truth=truth),
        )
    )


def _record(kind: str, seed: int = 0, *, known: bool = False) -> Record:
    return twin_record(_axis(kind, known=known), signals=recorded_values(kind, seed), seed=seed + 1)


def _late(record: Record, samples: int) -> Record:
    def moved(values: np.ndarray) -> np.ndarray:
        rows = np.clip(np.arange(len(values)) - samples, 0, len(values) - 1)
        return np.asarray(values[rows])

    return replace(record, signals={n: moved(v) for n, v in record.signals.items()})


def _scaled(record: Record, factor: float) -> Record:
    signals: Mapping[str, np.ndarray] = record.signals
    return replace(record, signals={n: factor * v for n, v in signals.items()})


def _check(record: Record, kind: str, *, known: bool = False) -> Check:
    result = identify(_axis(kind, known=known), record, methods=["idm-iv"])
    (found,) = (c for c in result.verdict if c.name == FAULT)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pressure", "supply"])
def test_a_right_signal_passes(kind: str) -> None:
    assert _check(_record(kind), kind).status == "pass"


@pytest.mark.slow
def test_a_right_signal_of_a_known_area_passes() -> None:
    assert _check(_record("pressure", known=True), "pressure", known=True).status == "pass"


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pressure", "supply"])
@pytest.mark.parametrize("samples", [100, -100])
def test_a_late_signal_is_told_with_its_delay(kind: str, samples: int) -> None:
    record = _record(kind)
    late = _late(record, samples)
    found = _check(late, kind)
    assert found.status == "fail"
    ((name, amount),) = re.findall(r"shift\.(\w+) = ([-\d.]+)", found.meaning)
    assert name == kind
    assert float(amount) == pytest.approx(-samples, abs=1.0)
    assert f"({100:.0f}" in found.meaning or "ms)" in found.meaning
    assert ("late" if samples > 0 else "early") in found.meaning


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factor", "said"),
    [
        (1e-5, "columns pressure=NAME:bar"),
        (1e-3, "columns pressure=NAME:kPa"),
        (1.05, "columns pressure=NAME:UNIT*0.95"),
    ],
)
def test_a_signal_in_another_unit_is_told_where_its_coefficient_is_known(
    factor: float, said: str
) -> None:
    found = _check(_scaled(_record("pressure", known=True), factor), "pressure", known=True)
    assert found.status == "fail"
    assert said in found.meaning
