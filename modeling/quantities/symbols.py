"""The quantities of a declaration: the coordinate and the parameters.

Both are used directly in SymPy expressions: ``M * q.acceleration + Fv * q.velocity``.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, TypeAlias, TypeVar

import sympy

from axisid.support.checks import is_among, listed as several, refuse
from axisid.support.errors import ModelError
from axisid.support.wording import quoted

from .names import check_symbol, number, settle
from .units import Unit, parse_unit

#: Largest numbers of operations and operands in an expression: of different ones, and of all with
#: repetitions.
MOST_NODES, _MOST_REPEATED = 4000, 40_000

T = TypeVar("T")

#: Drive force (or torque) on the load side, in the unit of the coordinate's dual (N or N m).
FORCE = sympy.Symbol("tau", real=True)
#: Control, the input of the drive, in its own unit.
CONTROL = sympy.Symbol("control", real=True)
#: Friction direction: +1 and -1 while sliding, between them while stuck (Filippov).
DIRECTION = sympy.Symbol("direction", real=True)
#: Position and velocity in the force of a drive, which does not know the axis's coordinate.
POSITION = sympy.Symbol("axis_position", real=True)
VELOCITY = sympy.Symbol("axis_velocity", real=True)


class Symbolic(ABC):
    """Base class of an object that represents one symbol and can be used in SymPy expressions."""

    __slots__ = ()

    @property
    @abstractmethod
    def symbol(self) -> sympy.Symbol:
        """Return the SymPy symbol that this object represents."""

    def _sympy_(self) -> sympy.Symbol:
        """Return the symbol, for SymPy's own conversion."""
        return self.symbol

    def __add__(self, other: Any) -> sympy.Expr:
        return self.symbol + other

    def __radd__(self, other: Any) -> sympy.Expr:
        return other + self.symbol

    def __sub__(self, other: Any) -> sympy.Expr:
        return self.symbol - other

    def __rsub__(self, other: Any) -> sympy.Expr:
        return other - self.symbol

    def __mul__(self, other: Any) -> sympy.Expr:
        return self.symbol * other

    def __rmul__(self, other: Any) -> sympy.Expr:
        return other * self.symbol

    def __truediv__(self, other: Any) -> sympy.Expr:
        return self.symbol / other

    def __rtruediv__(self, other: Any) -> sympy.Expr:
        return other / self.symbol

    def __pow__(self, other: Any) -> sympy.Expr:
        return self.symbol**other

    def __neg__(self) -> sympy.Expr:
        return -self.symbol


#: Types that a declaration accepts as a number.
Amount: TypeAlias = sympy.Expr | Symbolic | float


@dataclass(frozen=True, slots=True)
class Coordinate(Symbolic):
    """The single degree of freedom of an axis.

    Attributes
    ----------
    name : str
        Name of the position; velocity and acceleration are ``d<name>`` and ``dd<name>``.
    unit : str
        ``m`` for a linear axis, ``rad`` for a rotary one.
    """

    name: str
    unit: str = "m"

    def __post_init__(self) -> None:
        for name in (self.name, f"d{self.name}", f"dd{self.name}"):
            check_symbol(name, "the coordinate")
        if not is_among(self.unit, ("m", "rad")):
            raise ModelError(
                f"coordinate {self.name!r} has the unit {quoted(self.unit)}. Use 'm' for a linear "
                "axis or 'rad' for a rotary one.",
                code="units",
            )

    @property
    def symbol(self) -> sympy.Symbol:
        """Position."""
        return sympy.Symbol(self.name, real=True)

    @property
    def velocity(self) -> sympy.Symbol:
        """First derivative with respect to time."""
        return sympy.Symbol(f"d{self.name}", real=True)

    @property
    def acceleration(self) -> sympy.Symbol:
        """Second derivative with respect to time."""
        return sympy.Symbol(f"dd{self.name}", real=True)

    @property
    def force_unit(self) -> Unit:
        """Unit of the force that does work along the coordinate."""
        return parse_unit("N" if self.unit == "m" else "N m")

    @property
    def velocity_unit(self) -> Unit:
        """Unit of the velocity."""
        return parse_unit(f"{self.unit}/s")

    @property
    def acceleration_unit(self) -> Unit:
        """Unit of the acceleration."""
        return parse_unit(f"{self.unit}/s^2")


def check_coordinate(coordinate: object) -> None:
    """Refuse an object that is not a coordinate, such as its name."""
    if not isinstance(coordinate, Coordinate):
        raise ModelError(
            f"the coordinate is {quoted(coordinate)}. Give a Coordinate, such as Coordinate('q').",
            code="axis",
        )


@dataclass(frozen=True, slots=True)
class Parameter(Symbolic):
    """A physical parameter to be identified.

    Attributes
    ----------
    name, unit : str
        Symbol and coherent SI unit, e.g. ``"Fv", "N/(m/s)"``.
    nominal : float
        A-priori value (CAD, data sheet), in `unit`. The instrumental-variable iteration starts
        here, so the inertia needs a nominal value; friction and offsets may start from 0.
    lower, upper : float
        Physical bounds. An estimate outside is reported, never clipped.
    description : str
        A few words for tables.
    known : float or None
        Value that is known independently of the record (weighed, from CAD); see `fix`. None if the
        value is unknown.
    known_sd : float
        Standard deviation of `known`, in `unit`; 0 if it is exact.
    """

    name: str
    unit: str
    nominal: float = 0.0
    lower: float = -math.inf
    upper: float = math.inf
    description: str = ""
    known: float | None = None
    known_sd: float = 0.0

    def __post_init__(self) -> None:
        check_symbol(self.name, "a parameter")
        parse_unit(self.unit)
        what = f"of parameter {self.name!r}"
        settle(
            self,
            nominal=number(self.nominal, f"the nominal value {what}"),
            lower=number(self.lower, f"the lower bound {what}", finite=False),
            upper=number(self.upper, f"the upper bound {what}", finite=False),
            known=None if self.known is None else number(self.known, f"the known value {what}"),
            known_sd=number(self.known_sd, f"the standard deviation of the known value {what}"),
        )
        refuse(
            ModelError,
            *(
                (
                    value is not None and not self.allows(value),
                    f"its {kind} value {value!r} is outside its bounds [{self.lower!r}, "
                    f"{self.upper!r}]. Correct the value or the bound",
                )
                for kind, value in (("nominal", self.nominal), ("known", self.known))
            ),
            (
                self.known_sd < 0 or (self.known_sd > 0 and self.known is None),
                f"the standard deviation of its known value is {self.known_sd!r}. Give a number "
                "of 0 or more, together with a known value",
            ),
            before=f"parameter {self.name!r}: ",
            code="axis",
        )

    @property
    def symbol(self) -> sympy.Symbol:
        """The SymPy symbol."""
        return sympy.Symbol(self.name, real=True)

    @property
    def is_bounded(self) -> bool:
        """Return whether the parameter has a finite bound."""
        return math.isfinite(self.lower) or math.isfinite(self.upper)

    def allows(self, value: float) -> bool:
        """Return whether a value is within the bounds, or at one."""
        return self.lower <= value <= self.upper

    def out_of_bounds(self, value: float) -> str:
        """Return a clause on a value at a bound or outside the bounds, with value and bounds."""
        where = "at a bound of" if self.allows(value) else "outside its bounds"
        return f"{self.name} = {value:.6g} {self.unit} is {where} [{self.lower:g}, {self.upper:g}]"


def check_size(value: sympy.Expr, what: str) -> None:
    """Refuse an expression that is too large to be traversed repeatedly.

    Parameters
    ----------
    value : sympy.Expr
    what : str
        Description of the expression, for messages.

    Raises
    ------
    ModelError
        The expression has too many operations and operands, or too many levels.
    """
    different: set[sympy.Basic] = set()
    try:
        for count, node in enumerate(sympy.preorder_traversal(value)):
            different.add(node)
            if count >= _MOST_REPEATED or len(different) > MOST_NODES:
                raise ModelError(
                    f"{what} has more than {MOST_NODES} different operations and operands, or "
                    f"{_MOST_REPEATED} including repetitions. Declare a smaller model, or declare "
                    "repeated expressions as parameters.",
                    code="formula",
                )
    except RecursionError as error:
        raise ModelError(f"{what} is nested too deeply. Simplify the expression.") from error


def expression(value: Amount, what: str) -> sympy.Expr:
    """Return an amount as a SymPy expression; refuse text, which SymPy would run as code.

    Parameters
    ----------
    value : Amount
    what : str
        Description of the amount, for messages.

    Raises
    ------
    ModelError
        The amount is neither a number nor a SymPy expression, or is too large.
    """
    if isinstance(value, Symbolic):
        return value.symbol
    if isinstance(value, sympy.Expr):
        check_size(value, what)
        return value
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return sympy.Float(value) if isinstance(value, float) else sympy.Integer(value)
    # Name the type, because a text may look like an expression.
    given, kind = quoted(value), type(value).__name__
    if not given.endswith(f" {kind}"):
        given = f"{given} ({kind})"
    raise ModelError(
        f"{what} is {given}. Give a number or a SymPy expression of "
        "Parameter and Coordinate objects.",
        code="formula",
    )


def listed(values: Any, kind: type[T], what: str) -> tuple[T, ...]:
    """Return objects of one class as a tuple; a single object becomes a tuple of length 1.

    Parameters
    ----------
    values : object or iterable of objects
    kind : type
        Class that every object must have.
    what : str
        Beginning of the message, with its verb: ``the parameters contain``.

    Raises
    ------
    ModelError
        An object is of another class.
    """
    found = several(values)
    for value in found:
        if not isinstance(value, kind):
            raise ModelError(f"{what} {quoted(value)}. Give {kind.__name__} objects.", code="axis")
    return found


#: Reference position at the sample.
REFERENCE = sympy.Symbol("reference", real=True)


#: Measured position at the sample, encoder noise included.
MEASURED_POSITION = sympy.Symbol("measured_position", real=True)


#: Velocity of an ideal sensor at the sample.
MEASURED_VELOCITY = sympy.Symbol("measured_velocity", real=True)


#: Output of a law, clipped at the drive's limit; a memory may use it, such as for anti-windup.
LIMITED_OUTPUT = sympy.Symbol("limited_output", real=True)


#: Output of a law before the drive's limit; a memory may use it. It is computed once, so that it
#: equals `LIMITED_OUTPUT` to the last bit wherever the limit is not reached. The expression of the
#: output, if written a second time, may be summed in another order and differ by rounding.
UNLIMITED_OUTPUT = sympy.Symbol("unlimited_output", real=True)


#: Start value of a memory with which the law's output holds the axis at its initial position, or
#: equals the first control of a record.
BALANCED = sympy.Symbol("balanced", real=True)


#: Time since the first sample, s.
TIME = sympy.Symbol("time", real=True)


#: Sampling period of the law, s.
PERIOD = sympy.Symbol("period", positive=True)
