"""A control that is logged before it acts is told from a law of another delay."""

import re
from dataclasses import replace
from functools import cache

import pytest

from axisid import (
    Coordinate,
    Identification,
    Parameter,
    Prefilter,
    Record,
    build,
    identify,
    load_axis,
    newton,
    twin_record,
)
from axisid.codegen.artefacts import GeneratedAxis
from axisid.control import cascade_pd_difference
from axisid.elements import Drive, coulomb, viscous
from axisid.estimation import check_law
from axisid.modeling import Experiment, back_and_forth

TRUTH = {"J": 0.0021, "b": 0.0080, "c": 0.045}


@cache
def small_axis(delay: int) -> GeneratedAxis:
    """A light rotary axis, a thousand samples a second."""
    q = Coordinate("q", "rad")
    J, b = Parameter("J", "kg m^2", nominal=0.002), Parameter("b", "N m s/rad", nominal=0.007)
    c = Parameter("c", "N m", nominal=0.05)
    law = cascade_pd_difference(period=1e-3, kp=25.0, kv=2.0)
    axis = newton(
        "small",
        coordinate=q,
        parameters=(J, b, c),
        inertia=J,
        resistance=(viscous(b, q), coulomb(c, q)),
        drive=Drive(gain=0.1, unit="A"),
        control=replace(law, delay=delay),
        experiment=Experiment(
            moves=back_and_forth(
                speeds=(2.0, 5.0, 10.0), acceleration=150.0, seconds=0.4, repeat=2
            ),
            truth=TRUTH,
            position_noise=2e-5,
        ),
    )
    return build(axis)


@cache
def twin(delay: int, early: int) -> Record:
    record = twin_record(small_axis(delay), seed=5)
    return record.shifted(control=-early) if early else record


@cache
def result(true: int, declared: int, early: int) -> Identification:
    """Of a loop with a true and a declared delay, whose control is logged so many samples early."""
    record = twin(true, early)
    return identify(small_axis(declared), record, Prefilter.suited(record.period))


def said(found: Identification, name: str) -> str:
    (check,) = [check for check in found.verdict if check.name == name]
    return f"{check.status}: {check.meaning}"


@pytest.mark.slow
def test_a_control_logged_as_it_is_computed_is_to_be_shifted_not_the_delay() -> None:
    """Told to declare no delay, and obeying, one had b a sixth too low, with care."""
    found = result(1, 1, 1)
    law = said(found, "control law")
    assert law.startswith("fail")
    assert "shift.control = 1" in law
    assert "delay=" not in law
    alignment = said(found, "alignment")
    assert alignment.startswith("note"), "it counts once"
    assert "shift.control = 1" in alignment
    assert "the drive's delay" not in alignment
    assert re.search(r"so that the control is (0.9|1)\d* samples early beside", alignment)


@pytest.mark.slow
def test_who_declared_the_wrong_delay_is_told_of_both() -> None:
    found = result(1, 0, 1)
    assert said(found, "control law").startswith("pass")
    assert "shift.control = 1 in run.toml, and declare delay=1" in said(found, "alignment")
    off = abs(found["idm-iv"].parameters["b"].value - TRUTH["b"])
    assert off > 10 * result(1, 1, 0)["idm-iv"].parameters["b"].sd_hac


@pytest.mark.slow
def test_shifted_as_advised_it_is_the_truth() -> None:
    moved = twin(1, 1).shifted(control=1)
    found = identify(small_axis(1), moved, Prefilter.suited(moved.period))
    assert not [check.name for check in found.verdict if check.status == "fail"]
    for name, true in TRUTH.items():
        value = found["idm-iv"].parameters[name]
        assert abs(value.corrected - true) < 4 * value.sd_hac
    assert [repair.kind for repair in moved.provenance.repairs] == ["shift", "shift"]


@pytest.mark.slow
@pytest.mark.parametrize(("true", "declared"), [(0, 1), (1, 0), (2, 1)])
def test_a_wrong_delay_is_a_wrong_delay(true: int, declared: int) -> None:
    law = said(result(true, declared, 0), "control law")
    assert f"declare delay={true}. The motion supports that" in law
    assert "shift" not in law


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0, 1])
def test_of_a_right_log_nothing_is_said(delay: int) -> None:
    found = result(delay, delay, 0)
    assert said(found, "control law").startswith("pass")
    assert said(found, "alignment").startswith("pass")


@pytest.mark.slow
@pytest.mark.parametrize("role", ["reference", "position"])
@pytest.mark.parametrize("samples", [1, -1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_reference_or_position_at_another_time_is_named(role: str, samples: int) -> None:
    axis = build(load_axis("rotary_table"))
    record = twin_record(axis, seed=2)
    check = check_law(axis, record.shifted(**{role: samples}))
    assert f"shift.{role} = {-samples}" in check.sentence
