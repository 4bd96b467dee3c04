"""What may resist the EMPS: terms one by one, and axes that are put together from them.

Each adds to ``M q'' + Fv q' + Fc sign q' + tau0``, the model that was published with the record.
The control is recorded, so that no control law is declared.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from string import ascii_lowercase
from types import MappingProxyType

import sympy

from axisid import Axis, Constant, Coordinate, Parameter, Signal, newton
from axisid.elements import (
    Drive,
    cogging,
    coulomb,
    offset,
    quadratic,
    stribeck,
    viscous,
)

GAIN = 35.15065188248547  # N/V, of the public record
SCREW = 20e-3  # m a turn
COLUMNS = {"time": "t", "position": "qm", "control": "vir"}

q = Coordinate("q", unit="m")
M = Parameter("M", "kg", nominal=100.0, lower=0.0, description="mass")
Fv = Parameter("Fv", "N/(m/s)", lower=0.0, description="viscous friction")
Fc = Parameter("Fc", "N", lower=0.0, description="Coulomb friction")
tau0 = Parameter("tau0", "N", description="offset")
ELAPSED = Signal("elapsed", "s", description="time since the middle of the record")
SIDE = q.symbol - Constant(0.1232, "m", "middle").symbol
DIRECTION = sympy.sign(q.velocity)


@dataclass(frozen=True, slots=True, kw_only=True)
class Term:
    """Something that may resist the motion.

    Attributes
    ----------
    words : str
        For tables.
    parameters : tuple of Parameter
    resistance : expression
        On the inertia's side of the force balance.
    """

    words: str
    parameters: tuple[Parameter, ...]
    resistance: sympy.Expr


def _of_one(words: str, name: str, unit: str, shape: sympy.Expr) -> Term:
    """One parameter times a shape."""
    parameter = Parameter(name, unit, description=words)
    return Term(words=words, parameters=(parameter,), resistance=parameter.symbol * shape)


def _cogging(words: str, name: str, period: float, orders: Sequence[int]) -> Term:
    """Harmonics of a force over the position, of one period that is known."""
    parameters: list[Parameter] = []
    resistance = sympy.S.Zero
    for n in orders:
        pair = Parameter(f"{name}c{n}", "N"), Parameter(f"{name}s{n}", "N")
        parameters += pair
        resistance += cogging(*pair, q, period=Constant(period, "m"), harmonic=n)
    return Term(words=words, parameters=tuple(parameters), resistance=resistance)


def _stribeck() -> Term:
    excess = Parameter("Fs", "N", description="Stribeck friction")
    speed = Parameter("vs", "m/s", nominal=0.03, lower=0.002, upper=1.0)
    shape = stribeck(excess, q, velocity=speed, exponent=1)
    return Term(words="Stribeck friction", parameters=(excess, speed), resistance=shape)


def _quadratic() -> Term:
    drag = Parameter("Fq", "N/(m/s)^2", description="quadratic friction")
    return Term(words="quadratic friction", parameters=(drag,), resistance=quadratic(drag, q))


#: By the names that rungs know them by.
TERMS = MappingProxyType(
    {
        "direction": _of_one(
            "viscous friction of its own by direction", "Fd", "N/(m/s)", sympy.Abs(q.velocity)
        ),
        "stribeck": _stribeck(),
        "quadratic": _quadratic(),
        "drift": _of_one("offset that drifts", "drift", "N/s", ELAPSED.symbol),
        "friction drift": _of_one(
            "Coulomb friction that drifts", "cooled", "N/s", ELAPSED.symbol * DIRECTION
        ),
        "slope": _of_one("force over the position", "k", "N/m", SIDE),
        "friction slope": _of_one("friction over the position", "kd", "N/m", SIDE * DIRECTION),
        "bow": _of_one("force over its square", "k2", "N/m^2", SIDE**2),
        "friction bow": _of_one("friction over its square", "kd2", "N/m^2", SIDE**2 * DIRECTION),
        "cogging": _cogging("force, 2.5 and 1.25 mm", "e", SCREW / 8, (1, 2)),
    }
)


#: Those of them that are friction, beside viscous and Coulomb friction.
FRICTION = (
    "direction",
    "stribeck",
    "quadratic",
    "friction drift",
    "friction slope",
    "friction bow",
)


def axis_with(names: Sequence[str] = (), *, lag: float = 0.0, delay: float = 0.0) -> Axis:
    """The stage with some terms beside the published ones."""
    terms = [TERMS[name] for name in names]
    drifts = any(ELAPSED.symbol in term.resistance.free_symbols for term in terms)
    short = "".join(ascii_lowercase[[*TERMS].index(name)] for name in names)
    return newton(
        f"emps_with_{short}",
        coordinate=q,
        parameters=(M, Fv, Fc, tau0, *(p for term in terms for p in term.parameters)),
        inertia=M,
        resistance=(
            viscous(Fv, q),
            coulomb(Fc, q),
            offset(tau0),
            *(term.resistance for term in terms),
        ),
        drive=Drive(gain=GAIN, unit="V", limit=10.0, lag=lag, delay=delay),
        signals=(ELAPSED,) if drifts else (),
        columns=COLUMNS,
    )


def rescaled(names: Sequence[str], values: Mapping[str, float]) -> Axis:
    """The stage with values as they are but for two numbers: a scale of friction, and an offset."""
    scale = Parameter("scale", "1", nominal=1.0, description="of friction")
    whole = axis_with(names)
    frozen = {
        p.symbol: Constant(values[p.name], p.unit, f"{p.name}_found").symbol
        for p in whole.parameters
    }
    friction = viscous(Fv, q) + coulomb(Fc, q)
    friction += sum(TERMS[name].resistance for name in names if name in FRICTION)
    others = sum(TERMS[name].resistance for name in names if name not in FRICTION)
    return newton(
        f"{whole.name}_rescaled"[-31:],
        coordinate=q,
        parameters=(scale, tau0),
        inertia=M.symbol.xreplace(frozen),
        resistance=(
            scale.symbol * friction.xreplace(frozen),
            sympy.sympify(others).xreplace(frozen),
            offset(tau0),
        ),
        drive=whole.drive,
        signals=whole.signals,
        columns=COLUMNS,
    )
