"""What of drives, their times and the gains of ready laws is refused, each with its sentence."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
import sympy

from axisid import Axis, Constant, Parameter
from axisid.codegen.artefacts import GeneratedAxis, build
from axisid.control import cascade_p_pi
from axisid.elements import VELOCITY, Drive, current_drive, formula_drive, voltage_drive
from axisid.estimation.simulation.lane_arguments import gains_by_lane
from tests.axes.lagging import PERIOD, lagging
from tests.refusals import refuses

KT = {"kt": 0.05}
WOUND = {**KT, "resistance": 1.25}
GAINS = {"kp": 160.0, "kv": 243.0, "period": PERIOD}


def _timed(name: str = "Tc", **declared: float) -> Axis:
    return lagging(lag=Parameter(name, "s", **{"nominal": 5e-4, **declared}))


@pytest.mark.parametrize(
    ("code", "make"),
    [
        ("drive-delay", lambda: lagging(delay=1e6)),
        ("drive-time-bounds", lambda: _timed(upper=0.6e-3)),
        ("drive-time-bounds", lambda: _timed(lower=1e-4)),
        ("drive-time-known", lambda: _timed(known=5e-4, known_sd=1e-5)),
        ("drive-time-known", lambda: _timed(known=5e-4)),
        ("drive-estimated", lambda: Drive(gain=1.0, estimated=("gain", Parameter("T", "s")))),
        ("names-differ-by-case", lambda: _timed("Fv")),
        ("names-differ-by-case", lambda: _timed("q")),
        ("not-a-number", lambda: current_drive(**WOUND, supply=None)),  # type: ignore[arg-type]
        ("not-a-number", lambda: current_drive(**KT, supply=math.nan)),
        ("drive-figure", lambda: current_drive(**WOUND, supply=-24.0)),
        ("drive-figure-unit", lambda: current_drive(**WOUND, supply=Constant(24.0, "A"))),
        ("drive-reach", lambda: current_drive(**KT, ke=0.05)),
        ("drive-reach", lambda: current_drive(**KT, ke=0.05, reach=3.0)),
        ("drive-reach-at-rest", lambda: current_drive(**KT, reach=math.nan)),
        ("drive-reach-at-rest", lambda: current_drive(**KT, reach=-3.0)),
        ("drive-reach-at-rest", lambda: current_drive(**KT, reach=2 * VELOCITY)),
        ("drive-reach-at-rest", lambda: current_drive(**KT, reach=1 / VELOCITY)),
        ("drive-argument", lambda: voltage_drive(**WOUND, reach=3.0)),
        ("drive-argument", lambda: current_drive(**KT, gear=3.0)),
        ("drive-argument", lambda: formula_drive(sympy.Symbol("u"), friction=1.0)),
        ("drive-volts-unit", lambda: voltage_drive(**WOUND, volts=Constant(24.0, "V"))),
        ("drive-control-unit", lambda: voltage_drive(**WOUND, unit="A")),
        ("drive-current-unit", lambda: current_drive(**KT, unit="V")),
        ("gear-efficiency", lambda: current_drive(**KT, efficiency=1e-9)),
        ("number-not-finite", lambda: cascade_p_pi(**GAINS, speed_limit=-math.inf)),
        ("law-number-finite", lambda: cascade_p_pi(**GAINS, feed_forward=math.nan)),
        ("gain-positive", lambda: replace(cascade_p_pi(**GAINS, tn=0.1), positive=("ki",))),
    ],
)
def test_what_a_drive_or_a_ready_law_cannot_be_is_refused(
    code: str, make: Callable[[], Any]
) -> None:
    with refuses(code):
        make()


@pytest.fixture(scope="module")
def cascaded() -> GeneratedAxis:
    return build(replace(lagging(), control=cascade_p_pi(**GAINS, tn=0.1)), native=False)


@pytest.mark.parametrize(
    ("code", "says", "gains"),
    [
        ("batch-gains", "kp is True", {"kp": True}),
        ("batch-gains", "shape", {"kp": [1.0, 2.0]}),
        ("batch-gain-value", "kp of lane 1 is nan", {"kp": [1.0, math.nan, 2.0]}),
        ("batch-gain-value", "kp is inf", {"kp": math.inf}),
        ("batch-gain-value", "tn of lane 2 is 0", {"tn": [1.0, 2.0, 0.0]}),
    ],
)
def test_gains_that_a_lane_cannot_have_are_named(
    cascaded: GeneratedAxis, code: str, says: str, gains: dict[str, Any]
) -> None:
    with refuses(code, says):
        gains_by_lane(cascaded, gains, 3)


def test_another_gain_keeps_to_the_range_of_its_law(cascaded: GeneratedAxis) -> None:
    with refuses("gain-positive", "'tn'"):
        cascaded.with_gains({"tn": -0.1})
    assert cascaded.with_gains({"tn": 0.2, "kp": -1.0}).axis.control is not None
