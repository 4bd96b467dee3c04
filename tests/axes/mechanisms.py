"""Thirteen mechanisms of the textbooks, each twice: by its energies, and by where its bodies are.

The energies are sums of squares of rates, written as a textbook writes them. The places are written
again in plain numbers, by geometry (a linkage closes where two circles meet), so that what is
derived from the energies can be held against differences of places. Lengths are known; masses,
moments of inertia and stiffnesses are parameters.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy
from mpmath import mp
from sympy import acos, atan, atan2, cos, pi, sin, sqrt

from axisid import Axis, Constant, Coordinate, Parameter, lagrange
from axisid.elements import Drive, G

turn, way = Coordinate("q", unit="rad"), Coordinate("q")

J1, J2, J3 = (
    Parameter(f"J{i}", "kg m^2", nominal=value, lower=0.0)
    for i, value in ((1, 0.02), (2, 0.05), (3, 0.03))
)
M1, M2 = (Parameter(f"m{i}", "kg", nominal=value, lower=0.0) for i, value in ((1, 1.5), (2, 0.8)))
K = Parameter("k", "N/m", nominal=300.0, lower=0.0)
_FRICTION = {
    "rad": (Parameter("b", "N m/(rad/s)", nominal=0.1), Parameter("c", "N m", nominal=0.2)),
    "m": (Parameter("b", "N/(m/s)", nominal=5.0), Parameter("c", "N", nominal=2.0)),
}
GRAVITY = 9.80665

_Places = Callable[[Any], tuple[Any, ...]]  # coordinates or angles at a position, by mpmath


@dataclass(frozen=True, slots=True, kw_only=True)
class Mechanism:
    """A mechanism by its energies, and by its places.

    Attributes
    ----------
    kinetic, potential : sympy.Expr
    moved : mapping of Parameter to callable
        What moves each inertia: coordinates of a mass, or the angle of a moment of inertia.
    lifted : mapping of Parameter to callable
        The energy that is stored for one unit of a parameter, J.
    coordinate : Coordinate
    lowest, highest : float
        Positions that it reaches.
    """

    kinetic: sympy.Expr
    moved: Mapping[Parameter, _Places]
    potential: sympy.Expr = sympy.S.Zero
    lifted: Mapping[Parameter, Callable[[Any], Any]] = field(default_factory=dict)
    coordinate: Coordinate = turn
    lowest: float = -3.0
    highest: float = 3.0

    def axis(self, name: str) -> Axis:
        """Its declaration, with viscous and Coulomb friction."""
        viscous, coulomb = _FRICTION[self.coordinate.unit]
        rate = self.coordinate.velocity
        return lagrange(
            name,
            coordinate=self.coordinate,
            parameters=(*dict.fromkeys((*self.moved, *self.lifted)), viscous, coulomb),
            kinetic=self.kinetic,
            potential=self.potential,
            dissipation=viscous * rate**2 / 2 + coulomb * sympy.Abs(rate),
            drive=Drive(gain=1.0),
        )

    def columns(self, position: Any, velocity: Any, acceleration: Any) -> list[Any]:
        """What each parameter adds to the force, by differences of places.

        A coordinate p of the position has the energy ``(p' dq)**2 / 2``, and with it the force
        ``p' (p' ddq + p'' dq**2)``.
        """
        found = dict.fromkeys((*self.moved, *self.lifted), mp.zero)
        for parameter, places in self.moved.items():
            for i in range(len(places(position))):
                slope, bend = (
                    mp.diff(lambda at, i=i, places=places: places(at)[i], position, n)
                    for n in (1, 2)
                )
                found[parameter] += slope * (slope * acceleration + bend * velocity**2)
        for parameter, energy in self.lifted.items():
            found[parameter] += mp.diff(energy, position)
        return [*found.values(), velocity, mp.sign(velocity)]


def _m(value: float) -> sympy.Expr:
    return Constant(value, "m").symbol


q, dq = turn.symbol, turn.velocity
x, dx = way.symbol, way.velocity
g = G.symbol
# Crank, rod, offset, distance of pivots, arm, in m; the same numbers stand in the places below.
R, L, E, D, H = (_m(value) for value in (0.05, 0.2, 0.01, 0.12, 0.3))
r, l, e, d, h = (mp.mpf(str(value)) for value in (0.05, 0.2, 0.01, 0.12, 0.3))  # noqa: E741


def _half(parameter: Parameter, *coordinates: sympy.Expr) -> sympy.Expr:
    """The energy of an inertia that moves along coordinates."""
    return parameter * sum((each.diff(q) * dq) ** 2 for each in coordinates) / 2


def _angle(at: Any) -> tuple[Any]:
    return (at,)


def _four_bar() -> Mechanism:
    """A crank, a coupler and a rocker; the places find their joint where two circles meet."""
    numbers = (0.05, 0.16, 0.12, 0.18)
    a, b, c, f = (_m(value) for value in numbers)
    across = sqrt(f**2 + a**2 - 2 * f * a * cos(q))
    rocker = pi - atan2(a * sin(q), f - a * cos(q))
    rocker = rocker - acos((across**2 + c**2 - b**2) / (2 * across * c))
    pin = (a * cos(q), a * sin(q))
    joint = (f + c * cos(rocker), c * sin(rocker))
    middle = ((one + other) / 2 for one, other in zip(pin, joint, strict=True))
    kinetic = J1 * dq**2 / 2 + _half(J2, rocker) + _half(M2, *middle)
    kinetic += _half(J3, atan2(joint[1] - pin[1], joint[0] - pin[0]))
    ka, kb, kc, kf = (mp.mpf(str(value)) for value in numbers)

    def meeting(at: Any) -> tuple[Any, Any, Any, Any]:
        px, py = ka * mp.cos(at), ka * mp.sin(at)
        apart = mp.hypot(kf - px, py)
        along = (kb**2 - kc**2 + apart**2) / (2 * apart)
        aside = mp.sqrt(kb**2 - along**2)
        ux, uy = (kf - px) / apart, -py / apart
        return px, py, px + along * ux - aside * uy, py + along * uy + aside * ux

    def swung(at: Any) -> tuple[Any]:
        _, _, jx, jy = meeting(at)
        return (mp.atan2(jy, jx - kf),)

    def centre(at: Any) -> tuple[Any, Any]:
        px, py, jx, jy = meeting(at)
        return (px + jx) / 2, (py + jy) / 2

    def coupler(at: Any) -> tuple[Any]:
        px, py, jx, jy = meeting(at)
        return (mp.atan2(jy - py, jx - px),)

    return Mechanism(
        kinetic=kinetic,
        potential=M2 * g * (pin[1] + joint[1]) / 2,
        moved={J1: _angle, J2: swung, M2: centre, J3: coupler},
        lifted={M2: lambda at: GRAVITY * centre(at)[1]},
        lowest=0.2,
        highest=2.9,
    )


def _lever(at: Any) -> Any:
    """The angle of a slotted lever that a pin on a crank drives."""
    return mp.atan2(r * mp.sin(at), d + r * mp.cos(at))


def _between(at: Any) -> Any:
    """The distance between a point on an arm of 0.3 m and one 0.05 m beside the pivot."""
    return mp.hypot(h * mp.cos(at) - r, h * mp.sin(at))


def _follower(at: Any) -> Any:
    return e * mp.cos(at) + mp.sqrt(r**2 - (e * mp.sin(at)) ** 2)


def _driven_shaft(at: Any) -> tuple[Any]:
    """Behind a joint that leans by 0.5 rad: both crosses' arms are normal to each other."""
    return (mp.atan2(mp.sin(at), mp.cos(at) * mp.cos(mp.mpf("0.5"))),)


LEAN = Constant(0.5, "rad").symbol
SPIN = Constant(20.0, "rad/s").symbol
ACROSS = sqrt(H**2 + R**2 - 2 * H * R * cos(q))
RISE = E * cos(q) + sqrt(R**2 - E**2 * sin(q) ** 2)
HEIGHT = sqrt(H**2 - x**2)
QUICK = atan(R * sin(q) / (D + R * cos(q)))
RAM = L * R * sin(q) / (D + R * cos(q))
ECCENTRICITY = sympy.Rational(1, 5)
CRANK = J1 * dq**2 / 2

MECHANISMS: Mapping[str, Callable[[], Mechanism]] = {
    "scotch_yoke": lambda: Mechanism(
        kinetic=CRANK + _half(M1, R * sin(q)),
        potential=M1 * g * R * sin(q),
        moved={J1: _angle, M1: lambda at: (r * mp.sin(at),)},
        lifted={M1: lambda at: GRAVITY * r * mp.sin(at)},
    ),
    "shaper": lambda: Mechanism(
        kinetic=CRANK + _half(J2, QUICK) + _half(M1, RAM),
        moved={
            J1: _angle,
            J2: lambda at: (_lever(at),),
            M1: lambda at: (l * mp.tan(_lever(at)),),
        },
    ),
    "cardan": lambda: Mechanism(
        kinetic=CRANK + J2 * (cos(LEAN) / (1 - sin(LEAN) ** 2 * cos(q) ** 2) * dq) ** 2 / 2,
        moved={J1: _angle, J2: _driven_shaft},
    ),
    "four_bar": _four_bar,
    "spring_between_points": lambda: Mechanism(
        kinetic=CRANK,
        potential=K * (ACROSS - L) ** 2 / 2,
        moved={J1: _angle},
        lifted={K: lambda at: (_between(at) - l) ** 2 / 2},
    ),
    "boom": lambda: Mechanism(
        kinetic=CRANK + _half(M1, ACROSS),
        potential=M2 * g * H * sin(q),
        moved={J1: _angle, M1: lambda at: (_between(at),)},
        lifted={M2: lambda at: GRAVITY * h * mp.sin(at)},
    ),
    "cam": lambda: Mechanism(
        kinetic=CRANK + _half(M1, RISE),
        potential=K * (RISE - E) ** 2 / 2,
        moved={J1: _angle, M1: lambda at: (_follower(at),)},
        lifted={K: lambda at: (_follower(at) - e) ** 2 / 2},
    ),
    "trammel": lambda: Mechanism(
        kinetic=CRANK + _half(M1, L * cos(q)) + _half(M2, L * sin(q)),
        potential=M2 * g * L * sin(q),
        moved={
            J1: _angle,
            M1: lambda at: (l * mp.cos(at),),
            M2: lambda at: (l * mp.sin(at),),
        },
        lifted={M2: lambda at: GRAVITY * l * mp.sin(at)},
    ),
    "scissor_lift": lambda: Mechanism(
        coordinate=way,
        kinetic=M1 * dx**2 / 2 + M2 * (3 * HEIGHT.diff(x) * dx) ** 2 / 2,
        potential=3 * M2 * g * HEIGHT,
        moved={M1: _angle, M2: lambda at: (3 * mp.sqrt(h**2 - at**2),)},
        lifted={M2: lambda at: 3 * GRAVITY * mp.sqrt(h**2 - at**2)},
        lowest=0.05,
        highest=0.25,
    ),
    "rocking_half_cylinder": lambda: Mechanism(
        kinetic=(J1 + M1 * (D**2 + E**2 - 2 * D * E * cos(q))) * dq**2 / 2,
        potential=-M1 * g * E * cos(q),
        moved={
            J1: _angle,
            M1: lambda at: (d * at - e * mp.sin(at), d - e * mp.cos(at)),
        },
        lifted={M1: lambda at: -GRAVITY * e * mp.cos(at)},
    ),
    "oval_gears": lambda: Mechanism(
        kinetic=CRANK
        + J2 * ((1 - ECCENTRICITY**2) / (1 + ECCENTRICITY**2 + 2 * ECCENTRICITY * cos(q)) * dq) ** 2
        / 2,
        moved={
            J1: _angle,
            J2: lambda at: (2 * mp.atan(mp.tan(at / 2) * 2 / 3),),  # (1 - 1/5) / (1 + 1/5)
        },
    ),
    "governor": lambda: Mechanism(
        kinetic=CRANK + M1 * L**2 * dq**2 + 2 * M2 * L**2 * sin(q) ** 2 * dq**2,
        potential=-2 * (M1 + M2) * g * L * cos(q) - M1 * (SPIN * L * sin(q)) ** 2,
        moved={
            J1: _angle,
            M1: lambda at: (mp.sqrt(2) * l * mp.cos(at), mp.sqrt(2) * l * mp.sin(at)),
            M2: lambda at: (2 * l * mp.cos(at),),
        },
        lifted={
            M1: lambda at: -2 * GRAVITY * l * mp.cos(at) - (20 * l * mp.sin(at)) ** 2,
            M2: lambda at: -2 * GRAVITY * l * mp.cos(at),
        },
    ),
    "toggle": lambda: Mechanism(
        kinetic=CRANK + _half(M1, 2 * L * cos(q)),
        potential=K * (2 * L * (1 - cos(q))) ** 2 / 2,
        moved={J1: _angle, M1: lambda at: (2 * l * mp.cos(at),)},
        lifted={K: lambda at: (2 * l * (1 - mp.cos(at))) ** 2 / 2},
    ),
}  # fmt: skip
