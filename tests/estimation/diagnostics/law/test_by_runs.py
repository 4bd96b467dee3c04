"""Laws that are no sums of products of their gains are checked by runs of them."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from axisid import Record, build, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation import LawCheck, check_law
from axisid.support.errors import Missing
from tests.axes.cascaded import cascaded
from tests.axes.ready_laws import LAWS, with_law

P_PI, BACK = "cascade_p_pi, clamped", "cascade_p_pi, back-calculation"
_QUICK = (P_PI, "pid", "state_feedback")


@cache
def _axis(name: str, limit: float = 10.0) -> GeneratedAxis:
    axis = with_law(name, limit).axis
    experiment = axis.experiment
    return build(replace(axis, experiment=replace(experiment, position_noise=1e-6)), native=False)


@cache
def _record(name: str, limit: float = 10.0) -> Record:
    return twin_record(_axis(name, limit))


def _checked(name: str, gains: Mapping[str, float], limit: float = 10.0) -> LawCheck:
    """The check of a law with some gains divided by what is given."""
    axis, law = _axis(name, limit).axis, LAWS[name]()
    declared = {**law.gains, **{gain: law.gains[gain] / off for gain, off in gains.items()}}
    axis = replace(axis, control=replace(law, gains=declared))
    return check_law(build(axis, native=False), _record(name, limit))


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [name if name in _QUICK else pytest.param(name, marks=pytest.mark.slow) for name in LAWS],
)
def test_a_right_law_passes(name: str) -> None:
    check = _checked(name, {})
    assert check.passed, check.sentence
    assert check.residual_percent < 1e-6
    if name in (P_PI, BACK):
        assert (np.abs(_record(name, 3.2).control) == 3.2).mean() > 0.01
        assert _checked(name, {}, 3.2).passed, "where its drive saturates"


GAINS = [
    *((P_PI, gain, 10.0) for gain in ("kp", "kv", "tn")),
    (BACK, "tracking_time", 3.0),
    ("pid", "filter_time", 10.0),
    ("state_feedback", "k_integral", 10.0),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "gain", "limit"), GAINS)
def test_a_gain_that_is_wrong_alone_is_named_with_its_value(
    name: str, gain: str, limit: float
) -> None:
    check, value = _checked(name, {gain: 1.05}, limit), LAWS[name]().gains[gain]
    assert not check.passed
    assert f"{gain} is 1.05 times the declared one, {value:.5g} for" in check.meaning
    assert "every other gain is right" in check.meaning
    assert check.factors[gain] == pytest.approx(1.05, rel=1e-4)
    assert {v for g, v in check.factors.items() if g != gain} == {1.0}
    assert check.fitted_residual_percent < 1e-3


@pytest.mark.parametrize(
    ("times", "said"),
    [
        (0.8, "; or the control is recorded 0.8 times as large as it is, which scales every"),
        (1e-3, "one unit stands for another, such as millimetres for metres"),
        (-1.0, "its sign is opposite to the law's, with which it would be off by"),
    ],
)
def test_another_scale_of_the_control_is_told_beside_the_gain_that_makes_as_much(
    times: float, said: str
) -> None:
    record = _record(P_PI)
    scaled = replace(record, control=times * np.asarray(record.control))
    check = check_law(_axis(P_PI), scaled)
    assert not check.passed
    assert said in check.meaning
    assert ("kv is 0.8 times the declared one" in check.meaning) == (times == 0.8)


@pytest.mark.slow
def test_what_no_gain_explains_is_said_to_be_something_else() -> None:
    """The drive averages its velocity; the law that is declared does not."""
    name = "cascade_p_pi, feed-forward"
    plain = replace(LAWS["cascade_p_pi"](), gains={"kp": 10.0, "kv": 400.0, "tn": 0.1})
    check = check_law(build(replace(_axis(name).axis, control=plain), native=False), _record(name))
    assert "no change of its gains explains it" in check.meaning
    assert "axisid law (estimation.find_law) finds which ready law it is of" in check.meaning
    assert not check.passed


def _seven_digits(record: Record) -> Record:
    reference = np.round(np.asarray(record.reference), 7)
    return replace(record, position=np.round(record.position, 7), reference=reference)


@pytest.mark.parametrize(
    ("name", "written"),
    [(P_PI, _seven_digits), ("pid", lambda r: replace(r, control=r.control + 0.1))],
)
def test_seven_digits_or_another_start_of_an_integral_are_no_fault(
    name: str, written: Callable[[Record], Record]
) -> None:
    check = check_law(_axis(name), written(_record(name)))
    assert check.passed, check.sentence


@cache
def _behind_encoder(step: float) -> tuple[GeneratedAxis, Record]:
    axis = cascaded()
    experiment = replace(axis.experiment, position_noise=0.0, resolution=step)
    found = build(replace(axis, experiment=experiment), native=False)
    return found, twin_record(found)


@pytest.mark.slow
@pytest.mark.parametrize("step", [1e-6, 2e-5])
def test_steps_of_an_encoder_excuse_no_other_control(step: float) -> None:
    """What they leave open of the control is that of a log which rounds, and this one does not."""
    axis, record = _behind_encoder(step)
    assert check_law(axis, record).passed
    wave = np.sqrt(2 * np.mean(record.control**2)) * np.sin(2 * np.pi * 11 * record.time)
    for control, said in (
        (-record.control, "its sign is opposite"),
        (np.roll(record.control, -1), "1 sample before"),
        (record.control + 0.2 * wave, "off by 19"),
        (record.control + 0.1 * wave, "off by "),
    ):
        found = check_law(axis, replace(record, control=control))
        assert not found.passed
        assert said in found.meaning


@pytest.mark.slow
@pytest.mark.parametrize("coarser", [5, 20])
def test_a_right_law_behind_a_log_that_rounds_is_not_refused(coarser: int) -> None:
    axis, record = _behind_encoder(1e-6)
    rounded = coarser * 1e-6 * np.round(record.position / (coarser * 1e-6))
    found = check_law(axis, replace(record, position=rounded))
    assert isinstance(found, Missing) or found.passed
    assert not check_law(axis, replace(record, control=-record.control)).passed
