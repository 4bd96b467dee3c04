"""Several records: what is known of each, what each makes of the parameters, their filters."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from axisid import build, fix
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.parameters.known import known_of, prefilters_of, read_known
from axisid.estimation.parameters.layout import layout_of
from axisid.estimation.signals.prefilter import Prefilter
from tests.axes.leaning import leaning
from tests.axes.stage import generated, stage
from tests.refusals import refuses


def test_two_angles_tell_a_weight_from_an_offset() -> None:
    axis = leaning()
    known = known_of({"angle": [0.0, 0.5]}, 2)
    found = layout_of(axis, 2, known, (), commanded=True)
    assert [p.name for p in found.parameters] == ["m", "w", "f0"]
    theta = np.array([2.0, 10.0, 1.0])
    assert found.own(theta, 0)[-1] == pytest.approx(1.0)
    # The base parameter of the second is w + f0/sin(0.5).
    constant = found.own(theta, 1)[-1] * np.sin(0.5)
    assert constant == pytest.approx(1.0 + 10.0 * np.sin(0.5))
    alike = layout_of(axis, 2, known_of({"angle": [0.5, 0.5]}, 2), (), commanded=True)
    assert len(alike.parameters) == 2


def _known_of_two(values: Any) -> object:
    return known_of({"m": values}, 2)


def _bounded() -> GeneratedAxis:
    parameters = [replace(p, lower=0.0) if p.name == "M" else p for p in stage().parameters]
    return build(replace(stage(), parameters=parameters))


@pytest.mark.parametrize(
    ("axis", "known", "local", "said"),
    [
        (generated, {"nothing": [0.0, 1.0]}, (), "no 'nothing' to be known"),
        (generated, {}, ("nothing",), "no parameter 'nothing'"),
        (generated, {"tau0": [0.0, 1.0]}, ("tau0",), "leave one of the two out"),
        (_bounded, {"M": [90.0, -90.0]}, ("tau0",), "90, -90"),
        (leaning, {}, ("f0",), "enters nonlinearly"),
        (lambda: build(fix(stage(), M=(100.0, 1.0))), {}, ("tau0",), r"known M=100.0\+-1.0,100"),
    ],
)
def test_what_records_cannot_share_is_refused_with_what_to_say(
    axis: Callable[[], GeneratedAxis],
    known: dict[str, list[float]],
    local: tuple[str, ...],
    said: str,
) -> None:
    with refuses("parameters", said):
        layout_of(axis(), 2, known_of(known, 2), local, commanded=True)


def test_a_text_lists_a_value_for_each_record_some_with_deviations() -> None:
    found = read_known(["m_add=0,20+-0.01", "kp= 160 , 2.4e2"])
    assert found == {"m_add": ((0.0, 0.0), (20.0, 0.01)), "kp": ((160.0, 0.0), (240.0, 0.0))}
    (payload, _) = known_of(found, 2)
    assert payload.values == (0.0, 20.0)
    assert payload.deviations == (0.0, 0.01)
    assert payload.doubtful == ((20.0, 0.01),)
    assert payload.text(1) == "20 +- 0.01"
    (twice,) = known_of({"m": [0.0, (20.0, 0.1), (20.0, 0.1), (20.0, 0.2)]}, 4)
    assert twice.doubtful == ((20.0, 0.1), (20.0, 0.2))


@pytest.mark.parametrize(
    ("read", "told", "said"),
    [
        (read_known, ["m_add"], "write NAME=V1,V2"),
        (read_known, ["m_add="], "number 1 is no value"),
        (read_known, ["m_add=0,1+-"], "number 2 is no value"),
        (read_known, ["m=1,2", "m=3,4"], "once"),
        (_known_of_two, [0.0], "give"),
        (_known_of_two, [0.0, 1.0, 2.0], "give"),
        (_known_of_two, [0.0, (1.0, -1.0)], "give"),
        (_known_of_two, [0.0, (1, 2, 3)], "give"),
    ],
)
def test_what_lists_no_values_is_refused_with_their_place(
    read: Callable[[Any], object], told: list[Any], said: str
) -> None:
    with refuses("parameters", said):
        read(told)


@pytest.mark.parametrize(
    "periods", [(1e-3, 2e-3), (1e-3, 1.5e-3), (1 / 300, 1 / 500, 3e-3), (2e-3, 5e-4)]
)
def test_rows_are_as_far_apart_in_all_records(periods: tuple[float, ...]) -> None:
    asked = Prefilter(cutoff=40.0, decimate=10)
    found = prefilters_of(asked, periods[0], periods)
    apart = [f.decimate * period for f, period in zip(found, periods, strict=True)]
    assert apart == pytest.approx([apart[0]] * len(apart), rel=1e-9)
    assert 0.5 * 10 * periods[0] <= apart[0] <= 2 * 10 * periods[0]
    assert {f.cutoff for f in found} == {40.0}
    assert prefilters_of(asked, 1e-3, [1e-3, 1.0000001e-3]) == [asked, asked]
    with refuses("parameters"):
        prefilters_of(asked, periods[0], [periods[0], 1.0137 * periods[0]])
