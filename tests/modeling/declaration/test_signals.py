"""Recorded signals in a declaration: units, names, and what is derived of them."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import sympy

from axisid import (
    Axis,
    Coordinate,
    Parameter,
    Signal,
    derive,
    friction_ladder,
    lagrange,
    load_axis,
    newton,
)
from axisid.control import REFERENCE, ControlLaw, Memory
from axisid.elements import CONTROL, DRIVE_GAIN, TIME, Drive
from tests.axes.recorded import recorded_axis
from tests.files import text_file
from tests.refusals import refused, refuses

q = Coordinate("q")
M, A, B = Parameter("M", "kg", nominal=2.0), Parameter("A", "m^2"), Parameter("B", "m^2")
OFF, OFF2, K = Parameter("off", "N"), Parameter("off2", "N"), Parameter("k", "N s/(m K)")
pressure, temperature = Signal("pressure", "Pa"), Signal("temperature", "K")
RATE, LOAD = Parameter("pressure_rate", "m^2"), Signal("load", "kg")


def axis(*resistance: Any, parameters: tuple[Parameter, ...] = (M, A), **parts: Any) -> Axis:
    given = {"signals": (pressure,), "drive": Drive(gain=1.0), "inertia": M, **parts}
    terms = resistance or (A * pressure,)
    return newton("x", coordinate=q, parameters=parameters, resistance=terms, **given)


def test_a_signal_is_a_column_of_its_own_and_no_constant() -> None:
    """Sums of parameters before one signal are one; those of a signal and of 1 stay apart."""
    found = derive(
        axis(
            *(A * pressure, B * pressure, OFF, OFF2, K * temperature * q.velocity),
            parameters=(M, A, B, OFF, OFF2, K),
            signals=(pressure, temperature),
        )
    )
    assert [str(value) for value in found.base.expressions] == ["M", "A + B", "off + off2", "k"]
    p, warm = pressure.symbol, temperature.symbol
    assert found.idm.columns == (q.acceleration, p, 1, warm * q.velocity)


def test_a_recorded_inertia_leaves_no_direct_regressor() -> None:
    found = derive(axis(A * pressure, inertia=M + LOAD, signals=(pressure, LOAD)))
    assert "depends on load" in str(found.ddm)
    assert found.idm.columns == (q.acceleration, pressure.symbol)


def test_a_ladder_keeps_the_terms_of_signals() -> None:
    for rung in friction_ladder(recorded_axis("pressure")).values():
        assert "A" in [p.name for p in rung.parameters]


def named(name: str) -> Axis:
    signal = Signal(name, "Pa")
    return axis(A * signal, signals=(signal,))


def moved(**signals: Any) -> Axis:
    moves = recorded_axis("pressure").experiment
    return axis(experiment=replace(moves, truth={}, signals=signals))


test_what_is_wrong_with_signals_is_refused = refused(
    [
        ("axis", "has the signals pressure", lambda: axis(signals=())),
        (
            "unused-signals",
            "the signals temperature",
            lambda: axis(signals=(pressure, temperature)),
        ),
        ("axis", "'pressure'. Give Signal objects", lambda: axis(signals=("pressure",))),
        ("axis", "pressure", lambda: axis(signals=(pressure, pressure))),
        (
            "units",
            r"A in m\^2, pressure in N",
            lambda: axis(signals=(Signal("pressure", "N"),)),
        ),
        (
            "units",
            "scaled_by pressure",
            lambda: axis(drive=Drive(gain=1.0, scaled_by=pressure)),
        ),
        ("axis", "injected, pressure", lambda: axis(columns={"pressur": "p"})),
        ("twin", "'flow', which .* signals: press", lambda: moved(flow=1.0)),
        ("twin", "is q. Use only time", lambda: moved(pressure=q.symbol)),
        *(
            ("axis", "", lambda name=name: named(name))
            for name in ("position", "M", "dq", "signals", "tau", "pi", "1p")
        ),
        # Of a signal there is the rate too.
        ("axis", "pressure_rate", lambda: axis(RATE * pressure, parameters=(M, RATE))),
        (
            "equation",
            "eclare the axis with newton",
            lambda: lagrange(
                "x",
                coordinate=q,
                parameters=(M,),
                signals=(LOAD,),
                kinetic=(M + LOAD) * q.velocity**2 / 2,
                drive=Drive(gain=1.0),
            ),
        ),
    ]
)


def test_a_law_may_read_a_signal_and_the_axis_declares_it() -> None:
    feed = Signal("feed", "V")
    law = ControlLaw(name="feed", period=1e-3, output=REFERENCE + feed)
    assert law.signals == {feed.symbol}
    with refuses("axis", "the control law has the signals feed"):
        axis(control=law)
    assert axis(control=law, signals=(pressure, feed)).control is law
    late = Memory("late", following=feed.symbol, start=sympy.S.Zero)
    kept = ControlLaw(name="kept", period=1e-3, output=late.symbol, memory=(late,))
    assert kept.signals == {feed.symbol}


def test_a_potential_may_have_a_signal() -> None:
    found = lagrange(
        "x",
        coordinate=q,
        parameters=(M, A),
        signals=(pressure,),
        kinetic=M * q.velocity**2 / 2,
        potential=A * pressure * q,
        drive=Drive(gain=1.0),
    )
    assert found.force == M * q.acceleration + A * pressure


def test_a_drive_of_its_own_writes_the_signal_into_its_force() -> None:
    class Squared(Drive):
        @property
        def force(self) -> sympy.Expr:
            return DRIVE_GAIN * CONTROL**3

    with refuses("drive", "supply into its"):
        Squared(gain=1.0, scaled_by=Signal("supply", "V") / 24)


TOML = """
name = "x"
[coordinate]
name = "q"
[parameters]
M = { unit = "kg", nominal = 2.0 }
A = { unit = "m^2" }
[signals]
pressure = { unit = "Pa", description = "of the counter-balance" }
supply = { unit = "V", between = "held" }
feed = { unit = "V", between = "held" }
[newton]
inertia = "M"
resistance = ["A*pressure"]
[drive]
gain = 35.0
scaled_by = "supply/24"
[control]
name = "feed"
period = 1e-3
output = "reference - measured_position + feed"
[columns]
pressure = "p:bar"
[experiment]
moves = [{ distance = 0.1, speed = 0.2, acceleration = 4.0 }]
signals = { pressure = "6e5 + 1e5*sin(8*time)", supply = 24, feed = "time" }
"""


def test_toml_declares_signals_as_python_does(tmp_path: Path) -> None:
    file = text_file(tmp_path / "x.toml", TOML)
    read = load_axis(file)
    supply, feed = Signal("supply", "V", "held"), Signal("feed", "V", "held")
    described = Signal("pressure", "Pa", description="of the counter-balance")
    assert read.signals == (described, supply, feed)
    assert read.drive.scaled_by == supply / 24
    assert read.control.signals == {feed.symbol}
    assert read.columns == {"pressure": "p:bar"}
    wave = 6e5 + 1e5 * sympy.sin(8 * TIME)
    assert sympy.nsimplify(read.experiment.signals["pressure"] - wave) == 0


@pytest.mark.parametrize(
    ("wrong", "right", "said"),
    [
        ('"A*pressure"', '"A*presure"', "newton.resistance\\[1\\]: column 3"),
        ('unit = "Pa"', 'unit = "Paa"', "signals.pressure.unit: the unit 'Paa' cannot be read"),
        ('between = "held" }\nfeed', 'between = "hold" }\nfeed', "signals.supply.between: "),
        ('between = "held" }\nfeed', 'betwen = "held" }\nfeed', "signals.supply.betwen"),
        ('unit = "m^2"', 'unit = "m"', "the term pressure\\*A is in kg/s"),
        ('pressure = "p:bar"', 'presure = "p:bar"', "columns.presure"),
        ('feed = "time"', 'feeds = "time"', "experiment.signals.feeds"),
        ('feed = "time"', 'feed = "times"', "the name times is not known"),
        (" + feed", "", "the signals feed are declared but appear neither"),
        ('supply = { unit = "V"', 'M = { unit = "V"', "M"),
        ("scaled_by", "scaledby", "drive.scaledby"),
    ],
)
def test_a_mistake_in_toml_is_told_with_its_place(
    wrong: str, right: str, said: str, tmp_path: Path
) -> None:
    assert wrong in TOML
    file = text_file(tmp_path / "x.toml", TOML.replace(wrong, right))
    with pytest.raises(Exception, match=said):
        load_axis(file)
