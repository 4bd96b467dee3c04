"""Axes whose friction remembers."""

from functools import cache
from typing import Any

import numpy as np

from axisid import Coordinate, Parameter, build, newton
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.control import REFERENCE, ControlLaw, cascade_pd_difference, gain
from axisid.elements import Drive, dahl, lugre, maxwell_slip, viscous
from axisid.modeling.declaration.axis import Axis

x = Coordinate("x")
M = Parameter("M", "kg", nominal=10.0, lower=0.0)
Fv = Parameter("Fv", "N/(m/s)", nominal=60.0, lower=0.0)
s0 = Parameter("s0", "N/m", nominal=1e6, lower=0.0)
s1 = Parameter("s1", "N/(m/s)", nominal=3e3, lower=0.0)
Fc = Parameter("Fc", "N", nominal=20.0, lower=0.0)
Fs = Parameter("Fs", "N", nominal=30.0, lower=0.0)
vs = Parameter("vs", "m/s", nominal=0.01, lower=0.0)

STIFFNESS, LEVELS = np.array([2e5, 1e5, 5e4]), np.array([4.0, 6.0, 8.0])

CASCADE = cascade_pd_difference(kp=60.0, kv=40.0, period=1e-3)
#: A law that commands the force itself.
FORCED = ControlLaw(name="force", period=1e-3, output=gain("k") * REFERENCE, gains={"k": 1.0})


def declared(name: str, parameters: tuple[Parameter, ...], *terms: Any, **other: Any) -> Axis:
    """An axis of the mass M with the friction of some terms."""
    return newton(
        name,
        coordinate=x,
        parameters=(M, *parameters),
        inertia=M,
        resistance=terms,
        **{"drive": Drive(gain=30.0), "control": CASCADE, **other},
    )


def bristle(**other: Any) -> Axis:
    """LuGre friction with its viscous part."""
    friction = lugre(s0, s1, x, coulomb=Fc, static=Fs, velocity=vs)
    return declared("bristle", (s0, s1, Fv, Fc, Fs, vs), friction, viscous(Fv, x), **other)


def dahl_axis(**other: Any) -> Axis:
    """Dahl's friction beside a viscous one."""
    terms = dahl(s0, x, coulomb=Fc), viscous(Fv, x)
    return declared("dahl", (s0, Fc, Fv), *terms, **other)


def stack(**other: Any) -> Axis:
    """Three springs behind sliders, beside viscous friction."""
    parameters, terms = [Fv], [viscous(Fv, x)]
    for i, (stiffness, level) in enumerate(zip(STIFFNESS, LEVELS, strict=True), 1):
        k = Parameter(f"k{i}", "N/m", nominal=float(stiffness), lower=0.0)
        w = Parameter(f"W{i}", "N", nominal=float(level), lower=0.0)
        parameters += [k, w]
        terms.append(maxwell_slip(k, w, x))
    return declared("stack", tuple(parameters), *terms, **other)


@cache
def virtual(kind: str) -> GeneratedAxis:
    """One of them for the virtual machine, for which nothing is compiled."""
    return build({"bristle": bristle, "dahl": dahl_axis, "stack": stack}[kind]())
