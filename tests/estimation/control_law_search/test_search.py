"""The search finds the law of a twin with its gains, and says where no ready law is one."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import sympy

from axisid import build, load_axis, twin_record
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.control import ControlLaw, cascade_pd_difference, pid
from axisid.estimation import LawSearch, find_law
from axisid.estimation.control_law_search.search import ExplainedLaw
from axisid.modeling import back_and_forth
from tests.axes.ready_laws import LAWS, PERIOD, with_law
from tests.refusals import refuses

_MOVES = back_and_forth(speeds=(0.05, 0.15), acceleration=0.75, seconds=0.3, repeat=1)


@cache
def _axis(name: str, limit: float = 10.0) -> GeneratedAxis:
    axis = with_law(name, limit).axis
    shorter = replace(axis.experiment, moves=_MOVES, position_noise=1e-6)
    return build(replace(axis, experiment=shorter), native=False)


@cache
def _found(name: str, limit: float = 10.0) -> LawSearch:
    axis = _axis(name, limit)
    return find_law(axis, twin_record(axis))


SOUGHT = {
    "cascade_p_pi": ("cascade_p_pi", {"velocity": "difference"}),
    "cascade_pd_averaged": ("cascade_pd_averaged", {}),
    "cascade_p_pi, feed-forward": ("cascade_p_pi", {"velocity": "averaged"}),
    "pid": ("pid", {}),
    "pid of the position, clamped": ("pid", {"derivative_of": "position"}),
    "impedance": ("impedance", {}),
}


def has_gains_of(best: ExplainedLaw, name: str) -> bool:
    """Whether a law that was found has all gains of a ready one."""
    return best.law.gains == pytest.approx(LAWS[name]().gains, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*SOUGHT, "state_feedback", "pid_ideal"])
def test_the_law_of_a_twin_is_found_with_its_gains_or_told_as_the_same(name: str) -> None:
    found = _found(name)
    best = found.best
    if name in SOUGHT:
        assert (best.function, dict(best.words)) == SOUGHT[name]
        assert has_gains_of(best, name)
    else:
        assert best.function == "pid"
        assert name in best.same
    assert best.held_out_percent < 1e-3
    assert found.explained


@pytest.mark.slow
@pytest.mark.parametrize(  # in 2 % of the samples, and in a third
    ("how", "limit"), [("clamped", 4.0), ("clamped", 3.2), ("back-calculation", 3.2)]
)
def test_anti_windup_is_found_where_the_drive_saturates(how: str, limit: float) -> None:
    name = f"cascade_p_pi, {how}"
    best = _found(name, limit).best
    assert best.words["anti_windup"] == how.replace("clamped", "clamping").replace("-", "_")
    assert has_gains_of(best, name)


@pytest.mark.slow
@pytest.mark.parametrize("words", [{}, {"derivative_of": "position"}])
@pytest.mark.parametrize("periods", [2.0, 6.0, 20.0])
def test_a_derivative_behind_a_filter_is_found_with_its_time(
    periods: float, words: dict[str, str]
) -> None:
    axis = _axis("pid").axis
    law = pid(**{**LAWS["pid"]().gains, "filter_time": periods * PERIOD}, **words, period=PERIOD)
    filtered = build(replace(axis, control=law), native=False)
    best = find_law(filtered, twin_record(filtered)).best
    assert (best.function, dict(best.words), best.law.delay) == ("pid", words, 0)
    assert best.law.gains == pytest.approx(law.gains, rel=1e-5)


@pytest.mark.slow
def test_a_loop_of_half_the_sampling_rate_is_the_filtered_difference() -> None:
    """At 500 rad/s and 1 ms the two are one law, of which the simpler is told first."""
    found = _found("cascade_p_pi, phase-locked loop")
    assert dict(found.best.words) == {"velocity": "difference"}
    assert found.best.law.gains["velocity_filter"] == pytest.approx(0.003, rel=1e-5)
    assert found.best.held_out_percent < 1e-9
    assert "cascade_p_pi, velocity pll" in found.summary()
    assert found.as_well > 1


@pytest.mark.slow
def test_a_delay_is_found_with_the_gains_and_can_be_declared() -> None:
    axis = _axis("cascade_pd_averaged").axis
    slow = replace(axis.control, delay=2, gains={"kp": 40.0, "kv": 150.0})
    axis = replace(axis, control=slow)
    best = find_law(axis, twin_record(axis)).best
    assert (best.function, best.law.delay) == ("cascade_pd_averaged", 2)
    assert best.law.gains["kp"] == pytest.approx(40.0, rel=1e-5)
    assert re.fullmatch(r"control=replace\(cascade_pd_averaged\(.*\), delay=2\)", best.python)
    assert "delay = 2" in best.toml


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "drive", "added"),
    [
        ("cascade_p_pi, feed-forward", {"deadband": 0.1}, 0.0),
        ("cascade_p_pi", {"delay": 2 * PERIOD}, 0.2),
        ("impedance", {"quantisation": 0.05}, 0.0),
    ],
)
def test_what_the_drive_does_to_a_control_and_what_was_added_are_not_the_laws(
    name: str, drive: dict[str, float], added: float
) -> None:
    """A delay, dead band or steps of the drive, whose control was logged after; a test signal."""
    declared = _axis(name).declared
    changed = replace(declared.drive, logged="applied", **drive)
    axis = build(replace(declared, drive=changed), native=False)
    signal = added * np.sign(np.sin(0.05 * np.arange(len(twin_record(axis)))))
    given = {"injected": signal, "injected_at": "control"} if added else {}
    best = find_law(axis, twin_record(axis, **given)).best
    assert (best.function, dict(best.words), best.law.delay) == (*SOUGHT[name], 0)
    assert best.held_out_percent < 0.01
    assert "deadband" not in drive or has_gains_of(best, name)


@pytest.mark.slow
def test_a_law_that_is_none_of_them_is_said_to_be_none() -> None:
    cascade = cascade_pd_difference(kp=60.0, kv=120.0, period=PERIOD)
    other = ControlLaw(
        name="other",
        period=PERIOD,
        gains=cascade.gains,
        output=3 * sympy.tanh(cascade.output),
        memory=cascade.memory,
    )
    axis = replace(_axis("impedance").axis, control=other)
    found = find_law(axis, twin_record(axis))
    assert not found.explained
    assert "No built-in law explains the control" in found.summary()
    assert found.belief == "not believed"


@pytest.mark.slow
def test_the_declaration_of_a_law_can_be_read_again(tmp_path: Path) -> None:
    best = _found("cascade_p_pi").best
    file = tmp_path / "stage.toml"
    file.write_text(
        f'name = "stage"\n{best.toml}\ncoordinate = {{ name = "q", unit = "m" }}\n'
        '[parameters]\nM = { unit = "kg", nominal = 100, lower = 0 }\n'
        '[newton]\ninertia = "M"\n[drive]\ngain = 35.15\nunit = "V"\n'
    )
    law = load_axis(str(file)).control
    assert law.output == best.law.output
    assert law.gains == pytest.approx(best.law.gains, rel=1e-5)


@pytest.mark.parametrize(
    ("given", "code", "says"),
    [
        ({"reference": None}, "missing-column", "reference"),
        ({"control": None}, "missing-column", "control"),
        ({}, "too-short", "60 samples"),
    ],
)
def test_a_record_without_what_a_law_reads_is_refused(
    given: dict[str, None], code: str, says: str
) -> None:
    axis = _axis("cascade_p_pi")
    record = replace(twin_record(axis), **given)
    with refuses(code, says=says):
        find_law(axis, record if given else record.windowed((None, 0.0595)))
