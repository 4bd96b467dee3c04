"""Ready laws, blocks and constants of a TOML declaration are those of Python."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from axisid import load_axis
from axisid.control import (
    LIMITED_OUTPUT,
    MEASURED_POSITION,
    REFERENCE,
    UNLIMITED_OUTPUT,
    ControlLaw,
    cascade_p_pi,
    dynamixel_position,
    gain,
    impedance,
    low_pass,
    notch,
    pid,
    pid_ideal,
    state_feedback,
)
from axisid.modeling.quantities import Constant, Signal
from axisid.support.errors import DeclarationError
from tests.refusals import refuses

AXIS = """
name = "stage"
coordinate = { name = "q", unit = "m" }

[parameters]
M = { unit = "kg", nominal = 100, lower = 0 }
Fv = { unit = "N/(m/s)" }

[newton]
inertia = "M"
resistance = "Fv*dq"

[drive]
gain = 35.15
unit = "V"
limit = 10.0
"""

Load = Callable[[str], ControlLaw]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    def law(control: str) -> ControlLaw:
        file = tmp_path / "stage.toml"
        file.write_text(AXIS + control)
        return load_axis(str(file)).control

    return law


READY = [
    (
        'law = "cascade_p_pi"\nkp = 40.0\nkv = 243.0\ntn = 0.03\nvelocity = "averaged"\n'
        'speed_limit = 0.4\nanti_windup = "clamping"\nvelocity_feed_forward = 1.0',
        cascade_p_pi(
            kp=40.0,
            kv=243.0,
            tn=0.03,
            period=1e-3,
            velocity="averaged",
            speed_limit=0.4,
            anti_windup="clamping",
            velocity_feed_forward=1.0,
        ),
    ),
    (
        'law = "pid"\nkp = 3.0\nki = 2.0\nkd = 1.0\nfilter_time = 2e-3\n'
        'derivative_of = "position"\nanti_windup = "back_calculation"\ntracking_time = 0.1',
        pid(
            kp=3.0,
            ki=2.0,
            kd=1.0,
            filter_time=2e-3,
            derivative_of="position",
            anti_windup="back_calculation",
            tracking_time=0.1,
            period=1e-3,
        ),
    ),
    (
        'law = "pid_ideal"\nk = 3.0\nti = 2.0\ntd = 1.0',
        pid_ideal(k=3.0, ti=2.0, td=1.0, period=1e-3),
    ),
    (
        'law = "impedance"\nkp = 3.0\nkd = 2.0\nvelocity = "pll"\npll_bandwidth = 300.0',
        impedance(kp=3.0, kd=2.0, velocity="pll", pll_bandwidth=300.0, period=1e-3),
    ),
    (
        'law = "state_feedback"\nk_position = 3.0\nk_velocity = 2.0\nk_integral = 9.0',
        state_feedback(k_position=3.0, k_velocity=2.0, k_integral=9.0, period=1e-3),
    ),
    (
        'law = "dynamixel_position"\np = 800.0\ni = 10.0\nd = 60.0\nff1 = 3.0',
        dynamixel_position(p=800.0, i=10.0, d=60.0, ff1=3.0, period=1e-3),
    ),
]


@pytest.mark.parametrize(("text", "law"), READY)
def test_a_ready_law_is_the_same_in_toml(load: Load, text: str, law: ControlLaw) -> None:
    assert load(f"[control]\nperiod = 1e-3\n{text}") == law


def test_a_recorded_signal_and_a_constant_stand_in_a_ready_law(load: Load) -> None:
    made = load(
        '[control]\nlaw = "impedance"\nperiod = 1e-3\nkp = 3.0\nkd = 2.0\ndelay = 2\n'
        'reference_velocity = "speed"\nfeed_forward = "torque / kt"\n'
        '[signals]\nspeed = { unit = "m/s" }\ntorque = { unit = "N" }\n'
        '[constants]\nkt = { value = 35.15, unit = "N/V" }'
    )
    speed, torque = Signal("speed", "m/s"), Signal("torque", "N")
    kt = Constant(35.15, "N/V", "kt")
    wanted = impedance(
        kp=3.0,
        kd=2.0,
        period=1e-3,
        reference_velocity=speed,
        feed_forward=torque.symbol / kt.symbol,
    )
    assert made.output == wanted.output
    assert made.delay == 2


OWN = """
[constants]
stiffness = { value = 39000.0, unit = "V/m" }
rest = { value = 0.25, unit = "m" }

[control]
name = "own"
period = 1e-3
output = "stiffness*(reference - smooth) - p*still + total"

[control.gains]
p = 3.0

[control.memory]
total = { following = "total + limited_output - unlimited_output", start = "rest" }

[control.blocks]
smooth = { block = "low_pass", signal = "measured_position", time_constant = 2e-3, start = "rest" }
still = { block = "notch", signal = "smooth", frequency = 80.0, quality = "p" }
"""


def test_constants_and_blocks_stand_in_a_law_of_ones_own(load: Load) -> None:
    made = load(OWN)
    stiffness = Constant(39000.0, "V/m", "stiffness").symbol
    rest = Constant(0.25, "m", "rest")
    p, total = gain("p"), made.memory[0].symbol
    smooth = low_pass(MEASURED_POSITION, time_constant=2e-3, name="smooth1", start=rest)
    still = notch(smooth.value, frequency=80.0, quality=p, name="still1")
    assert made.output == stiffness * (REFERENCE - smooth.value) - p * still.value + total
    assert {m.name for m in made.memory} == {
        *("total", "smooth1", "still1_in1", "still1_in2", "still1_out1", "still1_out2")
    }
    assert made.memory[0].following == total + LIMITED_OUTPUT - UNLIMITED_OUTPUT
    assert made.memory[0].start == rest.symbol


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('"low_pass"', '"low_pas"', "there is no block 'low_pas'.*low_pass"),
        ("time_constant = 2e-3, ", "", "time_constant: the key is missing"),
        ("time_constant", "tau", "the key is unknown"),
        ("2e-3", "-2e-3", "time constant of a low-pass is.*0 or more"),
        ('"smooth", frequency', '"smoth", frequency', "the name smoth is not known"),
        (
            "- p*still",
            "- limited_output",
            "name limited_output is not known",
        ),
        ("smooth = {", "p = {", "blocks.p: the law has another symbol of this name"),
    ],
)
def test_mistakes_of_blocks_are_told_with_their_place(
    load: Load, old: str, new: str, says: str
) -> None:
    with refuses("declaration", says):
        load(OWN.replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("tn = 0.03", "tn = -1", "control.tn: .*Give a positive number"),
        ("kp = 40.0", 'kp = "high"', "control.kp: the value is 'high'. Give a number"),
    ],
)
def test_what_follows_from_a_mistake_is_no_other_one(
    load: Load, old: str, new: str, says: str
) -> None:
    with pytest.raises(DeclarationError) as refused:
        load(f"[control]\nperiod = 1e-3\n{READY[0][0]}".replace(old, new))
    (told,) = refused.value.mistakes
    assert re.match(says, told)
