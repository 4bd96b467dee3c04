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
from axisid.elements import VELOCITY, current_drive, formula_drive, voltage_drive
from axisid.estimation.simulation import gains_by_lane
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
        ("drive", lambda: lagging(delay=1e6)),
        ("drive", lambda: _timed(upper=0.6e-3)),
        ("drive", lambda: _timed(lower=1e-4)),
        ("drive", lambda: _timed(known=5e-4, known_sd=1e-5)),
        ("drive", lambda: _timed(known=5e-4)),
        ("axis", lambda: _timed("Fv")),
        ("axis", lambda: _timed("q")),
        ("axis", lambda: current_drive(**WOUND, supply=None)),  # type: ignore[arg-type]
        ("axis", lambda: current_drive(**KT, supply=math.nan)),
        ("drive", lambda: current_drive(**WOUND, supply=-24.0)),
        ("drive", lambda: current_drive(**WOUND, supply=Constant(24.0, "A"))),
        ("drive", lambda: current_drive(**KT, ke=0.05)),
        ("drive", lambda: current_drive(**KT, ke=0.05, reach=3.0)),
        ("drive", lambda: current_drive(**KT, reach=math.nan)),
        ("drive", lambda: current_drive(**KT, reach=-3.0)),
        ("drive", lambda: current_drive(**KT, reach=2 * VELOCITY)),
        ("drive", lambda: current_drive(**KT, reach=1 / VELOCITY)),
        ("drive", lambda: voltage_drive(**WOUND, reach=3.0)),
        ("drive", lambda: current_drive(**KT, gear=3.0)),
        ("drive", lambda: formula_drive(sympy.Symbol("u"), friction=1.0)),
        ("drive", lambda: voltage_drive(**WOUND, volts=Constant(24.0, "V"))),
        ("drive", lambda: voltage_drive(**WOUND, unit="A")),
        ("drive", lambda: current_drive(**KT, unit="V")),
        ("drive", lambda: current_drive(**KT, efficiency=1e-9)),
        ("axis", lambda: cascade_p_pi(**GAINS, speed_limit=-math.inf)),
        ("law", lambda: cascade_p_pi(**GAINS, feed_forward=math.nan)),
        ("law", lambda: replace(cascade_p_pi(**GAINS, tn=0.1), positive=("ki",))),
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
        ("simulation-input", "shape", {"kp": [1.0, 2.0]}),
        ("simulation-input", "kp of lane 1 is nan", {"kp": [1.0, math.nan, 2.0]}),
        ("simulation-input", "kp is inf", {"kp": math.inf}),
        ("simulation-input", "tn of lane 2 is 0", {"tn": [1.0, 2.0, 0.0]}),
    ],
)
def test_gains_that_a_lane_cannot_have_are_named(
    cascaded: GeneratedAxis, code: str, says: str, gains: dict[str, Any]
) -> None:
    with refuses(code, says):
        gains_by_lane(cascaded, gains, 3)


def test_another_gain_keeps_to_the_range_of_its_law(cascaded: GeneratedAxis) -> None:
    with refuses("law", "'tn'"):
        cascaded.with_gains({"tn": -0.1})
    assert cascaded.with_gains({"tn": 0.2, "kp": -1.0}).axis.control is not None
