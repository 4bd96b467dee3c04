"""One body: an inertia with what a test adds to it, a stage with friction, a rod, a gear.

Their letters are those of the equations: `q` with the unit mass `M`, the stage's `x` with `m`, `b`
and `c`, the angle `turn` with the moment of inertia `J`. Parameters that a body is offered and that
do not occur in it are not declared.
"""

from collections.abc import Iterable
from functools import cache, partial
from typing import Any

import sympy

from axisid import Axis, Coordinate, Parameter, lagrange, newton
from axisid.control import MEASURED_POSITION, REFERENCE, ControlLaw, cascade_pd
from axisid.elements import Drive, coulomb, viscous

q = Coordinate("q")
M = Parameter("M", "kg", nominal=1.0)
Fv = Parameter("Fv", "N/(m/s)")
Fc = Parameter("Fc", "N")

x = Coordinate("x")
m = Parameter("m", "kg", nominal=5.0)
b = Parameter("b", "N/(m/s)")
c = Parameter("c", "N")
k = Parameter("k", "N/m")

turn = Coordinate("q", unit="rad")
J = Parameter("J", "kg m^2", nominal=1.0)

PUSH = Drive(gain=1.0)


def body(
    *resistance: Any,
    coordinate: Coordinate = q,
    inertia: Any = M,
    parameters: Iterable[Parameter] = (),
    name: str = "test",
    **more: Any,
) -> Axis:
    """An inertia against resistances, by Newton's law, under the drive's own force."""
    return newton(
        name,
        coordinate=coordinate,
        parameters=_occurring(inertia, parameters, resistance),
        inertia=inertia,
        resistance=resistance,
        **{"drive": PUSH, **more},
    )


#: The same for a rotary axis.
rotor = partial(body, coordinate=turn, inertia=J)


def energetic(
    *,
    coordinate: Coordinate = turn,
    inertia: Any = J,
    parameters: Iterable[Parameter] = (),
    name: str = "test",
    **energies: Any,
) -> Axis:
    """An inertia, of the position too, with a potential energy and a dissipation, by Lagrange."""
    given = [energies.get(each, 0) for each in ("potential", "dissipation")]
    return lagrange(
        name,
        coordinate=coordinate,
        parameters=_occurring(inertia, parameters, given),
        kinetic=inertia * coordinate.velocity**2 / 2,
        **{"drive": PUSH, **energies},
    )


def _occurring(
    inertia: Any, parameters: Iterable[Parameter], terms: Iterable[Any]
) -> tuple[Parameter, ...]:
    """The inertia, if it is a parameter, and those parameters that occur."""
    offered = (*((inertia,) if isinstance(inertia, Parameter) else ()), *parameters)
    symbols = {s for term in (inertia, *terms) for s in sympy.sympify(term).free_symbols}
    return tuple(dict.fromkeys(p for p in offered if p.symbol in symbols))


def stage(*resistance: Any, parameters: Iterable[Parameter] = (), **more: Any) -> Axis:
    """A mass with viscous and Coulomb friction on a motor of 18 N/A under a cascade."""
    settled = {
        "name": "stage",
        "drive": Drive(gain=18.0, unit="A"),
        "control": cascade_pd(kp=50.0, kv=60.0, period=1e-3),
    }
    return body(
        viscous(b, x),
        coulomb(c, x),
        *resistance,
        coordinate=x,
        inertia=m,
        parameters=(b, c, *parameters),
        **{**settled, **more},
    )


#: Parameters of a rod: its mass, the distance of its centre and its moment of inertia about it.
ROD = (
    Parameter("m", "kg", nominal=1.5, lower=0.0),
    Parameter("l", "m", nominal=0.4, lower=0.0),
    Parameter("J", "kg m^2", nominal=0.02, lower=0.0),
)


def rod(parameters: Iterable[Parameter] = (), **more: Any) -> Axis:
    """A hanging rod that is declared by its mass, its length and its moment of inertia."""
    mass, length, moment = ROD
    return energetic(
        inertia=mass * length.symbol**2 + moment,
        parameters=(*ROD, *parameters),
        potential=-9.81 * mass * length * sympy.cos(turn.symbol),
        **{"name": "rod", **more},
    )


def geared(*resistance: Any, ratio: float = 120.0, **more: Any) -> Axis:
    """A load and the rotor that drives it through a gear, which no motion tells apart."""
    rotor = Parameter("Jm", "kg m^2", nominal=1e-4)
    return body(
        *resistance,
        coordinate=x,
        inertia=m + ratio**2 * rotor.symbol,
        parameters=(m, rotor, b),
        **{"name": "geared", **more},
    )


@cache
def force_law(period: float = 1e-3) -> ControlLaw:
    """A law without feedback: the reference is the drive's force, whatever is measured."""
    return ControlLaw(name="force", period=period, output=REFERENCE + 0 * MEASURED_POSITION)
