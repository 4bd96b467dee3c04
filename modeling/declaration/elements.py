"""Elements that resist the motion, as SymPy expressions to be added.

Each stands on the inertia's side of the force balance, ``tau = inertia * ddq + resistances``, so
that a positive parameter opposes a positive velocity or displacement. Units are written for a
linear axis; on a rotary one N is N m and m is rad.

An amount is a `Parameter` or any expression of parameters and constants, linear in the parameters
to identify. A quantity that enters nonlinearly (a Stribeck velocity, a period) is usually known: a
plain number or a `Constant`. A plain number has the unit that is expected for the argument.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Literal

import sympy

from axisid.modeling.quantities import (
    Amount,
    Coordinate,
    G,
    State,
    StatePart,
    check_coordinate,
    expression,
    positive,
    with_numbers,
    with_unit,
)
from axisid.support.checks import is_whole
from axisid.support.errors import ModelError
from axisid.support.wording import quoted

_AMOUNT = "the amount of a friction or load element"


def viscous(coefficient: Amount, coordinate: Coordinate) -> sympy.Expr:
    """Viscous friction ``Fv dq``.

    `coefficient` in N/(m/s); opposes motion if positive. [ArmstrongHelouvry1994]_.
    """
    return _amount(coefficient, coordinate, "/({}/s)") * coordinate.velocity


def asymmetric_viscous(forward: Amount, backward: Amount, coordinate: Coordinate) -> sympy.Expr:
    """Return viscous friction by direction: ``Fvp dq`` for dq > 0, ``Fvm dq`` for dq < 0.

    Both in N/(m/s); each opposes its motion if positive. [ArmstrongHelouvry1994]_.
    """
    ahead, back = (_amount(value, coordinate, "/({}/s)") for value in (forward, backward))
    dq, size = coordinate.velocity, sympy.Abs(coordinate.velocity)
    return ahead * (dq + size) / 2 + back * (dq - size) / 2


def coulomb(level: Amount, coordinate: Coordinate) -> sympy.Expr:
    """Coulomb friction ``Fc sign(dq)``, set-valued at rest: the axis can stick.

    `level` in N; opposes motion if positive. [Olsson1998]_; at rest [Filippov1988]_.
    """
    return _amount(level, coordinate) * sympy.sign(coordinate.velocity)


def asymmetric_coulomb(forward: Amount, backward: Amount, coordinate: Coordinate) -> sympy.Expr:
    """Return Coulomb friction by direction: ``Fcp`` for dq > 0, ``-Fcm`` for dq < 0.

    Both in N; each opposes its motion if positive. This friction contains an offset of
    ``(Fcp - Fcm) / 2``, so an additional `offset` cannot be distinguished.
    [ArmstrongHelouvry1994]_.
    """
    ahead, back = _amount(forward, coordinate), _amount(backward, coordinate)
    direction = sympy.sign(coordinate.velocity)
    return ahead * (1 + direction) / 2 - back * (1 - direction) / 2


def quadratic(coefficient: Amount, coordinate: Coordinate) -> sympy.Expr:
    """Quadratic drag ``Fq dq |dq|``: turbulent fluid or air.

    `coefficient` in N/(m/s)^2; opposes motion if positive. [Olsson1998]_.
    """
    drag = _amount(coefficient, coordinate, "/({}/s)^2")
    return drag * coordinate.velocity * sympy.Abs(coordinate.velocity)


def stribeck(
    excess: Amount, coordinate: Coordinate, *, velocity: Amount, exponent: Amount = 2
) -> sympy.Expr:
    """Return the Stribeck term beyond Coulomb friction: ``Fs exp(-(|dq|/vs)^d) sign(dq)``.

    Add it to `coulomb`: the breakaway force is then ``Fc + Fs``. `excess` Fs in N, opposes motion
    if positive; `velocity` vs in m/s; `exponent` d without unit: 1 for the exponential form, 2 for
    the Gaussian one. A `Parameter` for vs or d enters nonlinearly. [ArmstrongHelouvry1994]_.
    """
    check_coordinate(coordinate)
    speed = positive(velocity, f"{coordinate.unit}/s", "the Stribeck velocity")
    power = positive(exponent, "1", "the Stribeck exponent")
    if isinstance(exponent, int) or (isinstance(exponent, float) and exponent.is_integer()):
        power = sympy.Integer(int(exponent))  # an exact square needs no power function
    shape = sympy.exp(-((sympy.Abs(coordinate.velocity) / speed) ** power))
    return _amount(excess, coordinate) * shape * sympy.sign(coordinate.velocity)


def dahl(
    stiffness: Amount, coordinate: Coordinate, *, coulomb: Amount, name: str = ""
) -> sympy.Expr:
    """Dahl friction, with an internal state: ``s0 z`` with ``dz = dq - s0 |dq| z / Fc``.

    Elastic over small displacements, Coulomb friction over large ones. `stiffness` s0 in N/m;
    `coulomb` Fc in N; `name` of the state z, in m. Least squares cannot estimate it: simulate and
    `fit`. [Dahl1968]_.
    """
    s0, level = _amount(stiffness, coordinate, "/{}"), _amount(coulomb, coordinate)
    parts = (
        _part("the stiffness of Dahl friction", s0, coordinate, "/{}", "0 or more"),
        _part("the Coulomb level of Dahl friction", level, coordinate, "", "positive"),
    )
    return s0 * _bristle(s0, level, coordinate, name, parts)[0]


def lugre(
    stiffness: Amount,
    damping: Amount,
    coordinate: Coordinate,
    *,
    coulomb: Amount,
    static: Amount,
    velocity: Amount,
    name: str = "",
) -> sympy.Expr:
    """LuGre friction without its viscous part: ``s0 z + s1 dz``, ``dz = dq - s0 |dq| z / g(dq)``.

    ``g = Fc + (Fs - Fc) exp(-(dq/vs)^2)``; add `viscous`. `stiffness` s0 in N/m, `damping` s1 in
    N/(m/s), `coulomb` Fc and `static` Fs in N, `velocity` vs in m/s; `name` of the state z, in m.
    Under a vibrating load the axis drifts, even below Fs: this is a property of the friction law.
    Least squares cannot estimate it: simulate and `fit`. [CanudasDeWit1995]_.
    """
    s0 = _amount(stiffness, coordinate, "/{}")
    s1 = _amount(damping, coordinate, "/({}/s)")
    sliding, static_level = _amount(coulomb, coordinate), _amount(static, coordinate)
    speed = positive(velocity, f"{coordinate.unit}/s", "the Stribeck velocity")
    level = sliding + (static_level - sliding) * sympy.exp(-((coordinate.velocity / speed) ** 2))
    parts = (
        _part("the stiffness of LuGre friction", s0, coordinate, "/{}", "0 or more"),
        _part("the damping of LuGre friction", s1, coordinate, "/({}/s)"),
        _part("the Coulomb level of LuGre friction", sliding, coordinate, "", "positive"),
        _part("the static level of LuGre friction", static_level, coordinate, "", "positive"),
        StatePart(
            what="the Stribeck velocity of LuGre friction",
            value=speed,
            unit=f"{coordinate.unit}/s",
            least="positive",
        ),
    )
    z, rate = _bristle(s0, level, coordinate, name, parts)
    return s0 * z + s1 * rate


def maxwell_slip(
    stiffness: Amount, level: Amount, coordinate: Coordinate, *, name: str = ""
) -> sympy.Expr:
    """Force of a spring behind a slider: ``k z``, z following the position until ``|k z| = W``.

    The sum of several such elements has a hysteresis over the position by Masing's rules, and does
    not creep. `stiffness` k in N/m, `level` W in N; `name` of the state z, in m. Least squares
    cannot estimate it: simulate and `fit`. [Lampaert2003]_.
    """
    k, largest = _amount(stiffness, coordinate, "/{}"), _amount(level, coordinate)
    parts = (
        _part("the stiffness of a Maxwell slider", k, coordinate, "/{}", "positive"),
        _part("the level of a Maxwell slider", largest, coordinate, "", "0 or more"),
    )
    z = State(
        name or _state_name(k),
        coordinate.unit,
        coordinate.velocity,
        limit=largest / k,
        parts=parts,
    )
    return k * z.symbol


def load_dependent(coefficient: Amount, load: Amount, coordinate: Coordinate) -> sympy.Expr:
    """Coulomb friction that grows with a load: ``mu |load| sign(dq)``.

    `coefficient` mu without unit (or the unit of the force over that of the load), opposes motion
    if positive; `load` is a known force, or a function of the position. If the load contains
    parameters, the force contains products of parameters: declare each product as one parameter.
    [Hamon2010]_.
    """
    mu, normal = with_unit(coefficient, "1", _AMOUNT), _amount(load, coordinate)
    return mu * sympy.Abs(normal) * sympy.sign(coordinate.velocity)


def periodic_coulomb(
    cosine: Amount, sine: Amount, coordinate: Coordinate, *, period: Amount, harmonic: int = 1
) -> sympy.Expr:
    """Harmonic of Coulomb friction over the position: ``(a cos + b sin)(2 pi n q/p) sign(dq)``.

    `cosine` a and `sine` b in N, `period` p in m, `harmonic` n. It is added to the mean level of
    `coulomb`, for example for the run-out of a gear, bearing or screw. [ArmstrongHelouvry1994]_.
    """
    return cogging(cosine, sine, coordinate, period=period, harmonic=harmonic) * sympy.sign(
        coordinate.velocity
    )


def cogging(
    cosine: Amount, sine: Amount, coordinate: Coordinate, *, period: Amount, harmonic: int = 1
) -> sympy.Expr:
    """Harmonic of the force over the position: ``a cos(2 pi n q/p) + b sin(2 pi n q/p)``.

    `cosine` a and `sine` b in N; the force resists a positive motion where it is positive.
    `period` p in m: the pitch of the motor's poles or slots, over which the force does no work;
    `harmonic` n. [Gieras2012]_.
    """
    if not (is_whole(harmonic) and harmonic > 0):
        raise ModelError(
            f"the harmonic is {quoted(harmonic)}. Give a whole number of 1 or more.",
            code="axis",
        )
    even, odd = _amount(cosine, coordinate), _amount(sine, coordinate)
    length = positive(period, coordinate.unit, "the period")
    angle = 2 * sympy.pi * harmonic * coordinate.symbol / length
    return even * sympy.cos(angle) + odd * sympy.sin(angle)


def offset(level: Amount) -> sympy.Expr:
    """Constant force: amplifier offset, constant gravity, unequal friction.

    `level` in N; resists a positive motion if positive. [Janot2019]_.
    """
    return expression(level, _AMOUNT)


def gravity(mass: Amount) -> sympy.Expr:
    """Weight ``m G`` on a vertical axis, its coordinate upwards; ``G = 9.80665 m/s^2``.

    `mass` in kg; resists a positive (upward) motion if positive. [Khalil2002]_.
    """
    return with_unit(mass, "kg", _AMOUNT) * G.symbol


def gravity_moment(sine: Amount, cosine: Amount, coordinate: Coordinate) -> sympy.Expr:
    """Moment of a weight about a horizontal axis: ``a sin(q) + b cos(q)``.

    Both in N m: the weight times a distance of the centre of gravity from the axis at q = 0, below
    the axis for a (`sine`) and along the horizontal for b (`cosine`). Give 0 if one of the
    distances is 0. With a first moment ``ms`` in kg m, write ``G * ms``. Resists a positive motion
    where it is positive. [Khalil2002]_.
    """
    below, horizontal = _amount(sine, coordinate), _amount(cosine, coordinate)
    return below * sympy.sin(coordinate.symbol) + horizontal * sympy.cos(coordinate.symbol)


def spring(stiffness: Amount, coordinate: Coordinate, rest: Amount = 0.0) -> sympy.Expr:
    """Linear spring ``k (q - rest)``.

    `stiffness` in N/m, `rest` in m; drives back to `rest` if positive. [Khalil2002]_.
    """
    return _amount(stiffness, coordinate, "/{}") * _stretch(coordinate, rest)


def cubic_spring(stiffness: Amount, coordinate: Coordinate, rest: Amount = 0.0) -> sympy.Expr:
    """Hardening part of a spring: ``k3 (q - rest)^3``; softening if negative.

    `stiffness` in N/m^3, `rest` in m; drives back to `rest` if positive. [Kovacic2011]_.
    """
    return _amount(stiffness, coordinate, "/{}^3") * _stretch(coordinate, rest) ** 3


def motor_inertia(inertia: Amount, coordinate: Coordinate, *, ratio: Amount) -> sympy.Expr:
    """Inertia of a motor as the load feels it: ``n^2 J``, a part of the axis's inertia.

    `inertia` J in kg m^2; `ratio` n is the motor's angle over the coordinate, in rad/m (a screw of
    5 mm pitch has ``2 pi / 0.005``). No motion distinguishes the motor's inertia from the load's
    inertia: declare one of the two as known, unless gravity shows the mass. [Khalil2002]_.
    """
    check_coordinate(coordinate)
    turns = positive(ratio, f"rad/{coordinate.unit}", "the gear ratio")
    return turns**2 * with_unit(inertia, "kg m^2", _AMOUNT)


def back_emf(
    constant: Amount,
    coordinate: Coordinate,
    *,
    kt: Amount,
    resistance: Amount,
    ratio: Amount = 1.0,
) -> sympy.Expr:
    """Braking force of the back-EMF of a motor on a voltage: ``kt ke n^2 / R dq``, to identify ke.

    `constant` ke in V/(rad/s), or V/(m/s) of a linear motor. `kt` in N m/A, `resistance` R in V/A
    and `ratio` n in rad/m have the values of a `voltage_drive` without ke, whose force is then the
    force of the motor at standstill. The braking force is a viscous friction: no motion
    distinguishes it from `viscous`, unless one of the two is known. [Krishnan2001]_.
    """
    check_coordinate(coordinate)
    is_geared = ratio != 1
    turns = positive(ratio, f"rad/{coordinate.unit}" if is_geared else "1", "the gear ratio")
    is_rotary = is_geared or coordinate.unit == "rad"
    force = positive(kt, "N m/A" if is_rotary else "N/A", "kt")
    emf = with_unit(constant, "V/(rad/s)" if is_rotary else "V/(m/s)", _AMOUNT)
    ohms = positive(resistance, "V/A", "the resistance")
    return force * emf * turns**2 / ohms * coordinate.velocity


def end_stop(
    coordinate: Coordinate,
    *,
    lower: Amount,
    upper: Amount,
    stiffness: float,
    dissipation: float = 0.0,
) -> sympy.Expr:
    """Contact force of a stop at each end: ``k d max(0, 1 + c dd)``, d the depth, dd its rate.

    The force is known, not identified; it is intended for simulations. It is zero between `lower`
    and `upper` (m), pushes back beyond them and never pulls. `stiffness` k in N/m; `dissipation` c
    in s/m, about ``3/2 (1 - e) / v`` for an impact at speed v with the coefficient of restitution
    e. The force is continuous. The start and the end of a contact are events of the simulation, so
    that even short contacts are found. In a regression, the known force amplifies the noise of the
    rows in contact: exclude those rows. [HuntCrossley1975]_.
    """
    check_coordinate(coordinate)
    k = positive(stiffness, "N/m" if coordinate.unit == "m" else "N m/rad", "the stop's stiffness")
    c = with_unit(dissipation, f"s/{coordinate.unit}", "the stop's dissipation")
    low = with_unit(lower, coordinate.unit, "the lower stop")
    high = with_unit(upper, coordinate.unit, "the upper stop")
    if with_numbers(high - low).is_positive is False:
        raise ModelError(
            f"the stops are at {quoted(lower)} and {quoted(upper)}. Give the lower stop first.",
            code="axis",
        )
    q, dq = coordinate.symbol, coordinate.velocity
    above = sympy.Max(0, q - high) * sympy.Max(0, 1 + c * dq)
    below = sympy.Max(0, low - q) * sympy.Max(0, 1 - c * dq)
    return k * above - k * below


def _amount(value: Amount, coordinate: Coordinate, over: str = "") -> sympy.Expr:
    """Return the amount of an element as an expression; 0 if it is the number 0.

    A plain number is in the axis's force unit followed by `over`, such as ``/({}/s)``, where ``{}``
    stands for the coordinate's unit.
    """
    check_coordinate(coordinate)
    return _unless_zero(value, f"{coordinate.force_unit}{over.format(coordinate.unit)}", _AMOUNT)


def _part(
    what: str,
    value: sympy.Expr,
    coordinate: Coordinate,
    over: str = "",
    least: Literal["positive", "0 or more", ""] = "",
) -> StatePart:
    """Return a quantity in the equation of a state, with the unit and range to be checked later.

    Parameters
    ----------
    what : str
        Description of the quantity, for messages.
    value : sympy.Expr
    coordinate : Coordinate
    over : str
        Rest of the unit after the force unit, such as ``/({}/s)``, where ``{}`` stands for the
        coordinate's unit.
    least : {"positive", "0 or more", ""}
        Permitted range; empty for any number.
    """
    unit = f"{coordinate.force_unit}{over.format(coordinate.unit)}"
    return StatePart(what=what, value=value, unit=unit, least=least)


def _bristle(
    stiffness: sympy.Expr,
    level: sympy.Expr,
    coordinate: Coordinate,
    name: str,
    parts: tuple[StatePart, ...],
) -> tuple[sympy.Expr, sympy.Expr]:
    """Return a bristle's deflection z, an internal state, and its rate.

    The rate is ``dz = dq - s0 |dq| z / level``.

    Parameters
    ----------
    stiffness : sympy.Expr
        s0.
    level : sympy.Expr
        Friction force during steady sliding.
    coordinate : Coordinate
    name : str
        Name of the state; empty for the default name (`_state_name`).
    parts : tuple of StatePart
        Quantities in the equation of the state, for checks.
    """
    dq = coordinate.velocity

    def rate(z: sympy.Symbol) -> sympy.Expr:
        """Return the rate of change of the deflection z."""
        return dq - stiffness * sympy.Abs(dq) * z / level

    z = State(name or _state_name(stiffness), coordinate.unit, rate, parts=parts).symbol
    return z, rate(z)


def _stretch(coordinate: Coordinate, rest: Amount) -> sympy.Expr:
    """Return the displacement of the coordinate from a rest position."""
    return coordinate.symbol - _unless_zero(rest, coordinate.unit, "the rest position")


def _state_name(stiffness: sympy.Expr) -> str:
    """Return the default name of a state: ``z_s0`` for a stiffness named ``s0``, else ``z``."""
    name = str(stiffness)
    return f"z_{name}" if stiffness.is_Symbol and name.isidentifier() else "z"


def _unless_zero(value: Amount, unit: str, what: str) -> sympy.Expr:
    """Return an amount as in `with_unit`; the number 0 stays 0, so that its term vanishes."""
    if isinstance(value, (int, float)) and not isinstance(value, bool) and value == 0:
        return sympy.S.Zero
    return with_unit(value, unit, what)


#: The elements by their names in declarations as text.
ELEMENTS: Mapping[str, Callable[..., sympy.Expr]] = MappingProxyType(
    {
        element.__name__: element
        for element in (
            viscous,
            asymmetric_viscous,
            coulomb,
            asymmetric_coulomb,
            quadratic,
            stribeck,
            dahl,
            lugre,
            maxwell_slip,
            load_dependent,
            periodic_coulomb,
            cogging,
            offset,
            gravity,
            gravity_moment,
            spring,
            cubic_spring,
            motor_inertia,
            back_emf,
            end_stop,
        )
    }
)
