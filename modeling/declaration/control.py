"""Control laws, sampled or continuous.

A drive samples: once per period the law reads the reference and the measured position, and holds
its control until the next sample. The values that the law stores between samples (for a velocity
filter, an integral) are declared as `Memory`. The ready-made laws use the same classes
(`ready_laws`).
"""

from collections.abc import Mapping, Set
from dataclasses import dataclass, field

import sympy

from axisid.modeling.quantities import (
    BALANCED,
    LIMITED_OUTPUT,
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    REFERENCE,
    UNLIMITED_OUTPUT,
    ConstantSymbol,
    SignalSymbol,
    check_symbol,
    expression,
    listed,
    multiplied_out,
    number,
    settle,
    signals_in,
)
from axisid.support.checks import is_among, is_whole, listed as several, refuse
from axisid.support.errors import ModelError
from axisid.support.mappings import FrozenMapping
from axisid.support.wording import quoted

#: Largest number of samples of a delay.
LONGEST_DELAY = 100
_INPUTS = frozenset({REFERENCE, MEASURED_POSITION, MEASURED_VELOCITY, PERIOD})
_OUTPUTS = frozenset({LIMITED_OUTPUT, UNLIMITED_OUTPUT})
_AT_REST = frozenset({MEASURED_POSITION, REFERENCE, BALANCED})


#: Ways in which a reference may run between the samples of a log, the default first.
REFERENCES_BETWEEN = ("spline", "linear", "held")


@dataclass(frozen=True, slots=True)
class Memory:
    """A number that the law stores from one sample to the next.

    Attributes
    ----------
    name : str
        Symbol of the stored value in the law.
    following : sympy.Expr
        Value at the next sample, a function of the variables of `ControlLaw.output`, of
        `UNLIMITED_OUTPUT`, the output itself, and of `LIMITED_OUTPUT`, the output clipped at the
        drive's limit, such as for an integral that stops where the drive is saturated. Use these
        two symbols and not the expression of the output: they are equal to the last bit where the
        limit is not reached.
    start : sympy.Expr
        Value at the first sample, with the axis at rest: a function of `MEASURED_POSITION`,
        `REFERENCE`, numbers and constants. `BALANCED`, for an integral or another memory that
        compensates a load, is the value with which the law's output holds the axis at rest; the
        smallest if there are several such values. The loop of a record starts instead with the
        values that give the first controls of the record.
    """

    name: str
    following: sympy.Expr
    start: sympy.Expr

    def __post_init__(self) -> None:
        check_symbol(self.name, "a memory of a control law", control=True)
        settle(
            self,
            following=expression(self.following, f"the following value of memory {self.name!r}"),
            start=expression(self.start, f"the start value of memory {self.name!r}"),
        )

    @property
    def symbol(self) -> sympy.Symbol:
        """The SymPy symbol."""
        return sympy.Symbol(self.name, real=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlLaw:
    """Difference equation from the reference and the measured motion to the control.

    Attributes
    ----------
    name : str
        Name for tables and manifests.
    period : float
        Sampling period, s.
    output : sympy.Expr
        The control in the drive's unit, a function of `REFERENCE`, `MEASURED_POSITION`,
        `MEASURED_VELOCITY`, `PERIOD`, the gains, the memory, constants (`Constant`) and recorded
        signals (`Signal`), such as a feed-forward or a commanded velocity.
    gains : mapping of str to float
        Known constants of the law by symbol name, SI.
    memory : tuple of Memory
        Values that are stored between samples.
    delay : int
        Whole samples between computing a control and applying it.
    reference_between : str
        Course of the reference between the samples of a log that is slower than the law:
        ``spline`` (smooth), ``linear`` (straight) or ``held``. If given, it also states that the
        law has its own clock: a log with another period is then accepted without confirmation.
        Empty means ``spline``. A reference that is straight between samples lags while it
        accelerates, by a twelfth of the acceleration times the squared period, which biases the
        inertia.
    continuous : bool
        Evaluate the law continuously, instead of holding its output between samples; the reference
        is straight between samples. For an analogue controller, or equations (6) and (7) of the
        paper as written. Such a law has no memory and no delay, and its output does not contain
        the period. It should be smooth within a sample, because the start of saturation within a
        sample reduces accuracy. For an axis that sticks, breakaway is checked at the end of each
        sample.
    positive : tuple of str
        Gains that must stay above 0 when gains are changed: times, limits, divisors.
    """

    name: str
    period: float
    output: sympy.Expr
    gains: Mapping[str, float] = field(default_factory=dict)
    memory: tuple[Memory, ...] = ()
    delay: int = 0
    continuous: bool = False
    reference_between: str = ""
    positive: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        gains = {name: number(v, f"{self.name!r}: gain {name!r}") for name, v in self.gains.items()}
        settle(
            self,
            period=number(self.period, f"{self.name!r}: the period"),
            gains=FrozenMapping(gains),
            memory=listed(self.memory, Memory, f"control law {self.name!r}: the memory contains"),
            output=expression(self.output, "the control law's output"),
            positive=several(self.positive),
        )
        for name in (*self.gains, *(memory.name for memory in self.memory)):
            check_symbol(name, f"a gain or memory of control law {self.name!r}", control=True)
        refuse(
            ModelError,
            (
                not self.period > 0,
                f": the period is {self.period!r} s, not positive. Give a positive period",
                "",
            ),
            *(
                (
                    not (is_among(name, self.gains) and self.gains[name] > 0),
                    f": the gain {quoted(name)} is "
                    f"{self.gains[name] if is_among(name, self.gains) else 'not declared'}, but it "
                    "must be positive. Give a number above 0",
                )
                for name in self.positive
            ),
            (
                not (is_whole(self.delay) and 0 <= self.delay <= LONGEST_DELAY),
                f": the delay is {quoted(self.delay)}. Give a whole number of samples from 0 to "
                f"{LONGEST_DELAY}",
            ),
            (
                self.reference_between not in ("", *REFERENCES_BETWEEN),
                f": reference_between is {quoted(self.reference_between)}. Give "
                f"{', '.join(REFERENCES_BETWEEN[:-1])} or {REFERENCES_BETWEEN[-1]}, or omit "
                "reference_between",
            ),
            (
                self.continuous
                and (self.memory or self.delay or PERIOD in self.output.free_symbols),
                " is continuous but contains a memory, a delay or the period, which only a "
                "sampled law can have. Omit memory, delay and period, or omit continuous=True",
            ),
            *(
                (
                    memory.start != BALANCED and memory.start.has(BALANCED),
                    f": memory {memory.name!r} starts at {memory.start}, which contains "
                    f"{BALANCED} and other terms. Give {BALANCED} alone, or an expression without "
                    f"{BALANCED}",
                )
                for memory in self.memory
            ),
            before=f"control law {self.name!r}",
            code="law",
        )
        allowed = _INPUTS | {gain(name) for name in self.names} | self.signals
        self._check(self.output, allowed, "output")
        for memory in self.memory:
            self._check(memory.following, allowed | _OUTPUTS, f"memory {memory.name!r}")
            self._check(memory.start, _AT_REST, f"start of memory {memory.name!r}")

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the gains, of the memories and of the delay line."""
        return (*self.gains, *(memory.name for memory in self.memory), *self.delay_line)

    @property
    def signals(self) -> frozenset[SignalSymbol]:
        """Return the recorded signals that the law reads."""
        return signals_in(self.output, *(memory.following for memory in self.memory))

    @property
    def takes_velocity(self) -> bool:
        """Return whether the law reads the velocity of an ideal sensor."""
        values = (self.output, *(memory.following for memory in self.memory))
        return any(value.has(MEASURED_VELOCITY) for value in values)

    @property
    def balanced(self) -> tuple[int, ...]:
        """Return the indices of the memories whose start value is `BALANCED`."""
        return tuple(i for i, memory in enumerate(self.memory) if memory.start == BALANCED)

    @property
    def delay_line(self) -> tuple[str, ...]:
        """Return the names of the controls computed but not applied yet, the newest first."""
        return tuple(f"delayed{i + 1}" for i in range(self.delay))

    @property
    def is_polynomial(self) -> bool:
        """Return whether the control is a sum of signals, each times a product of gains.

        This is False if a memory depends on a gain or on the output, because such a memory is no
        signal that is independent of the gains.
        """
        gains = {gain(name) for name in self.gains}
        depends_on_gains = any(
            memory.following.free_symbols & (gains | _OUTPUTS) for memory in self.memory
        )
        return not depends_on_gains and self.terms != ((sympy.S.One, self.output),)

    @property
    def terms(self) -> tuple[tuple[sympy.Expr, sympy.Expr], ...]:
        """Return the terms of the output: a product of gains, and the signal that it multiplies.

        A law that is not a polynomial in its gains is a single term with the factor 1.
        """
        gains = tuple(gain(name) for name in self.gains)
        factors: dict[sympy.Expr, None] = {}  # products of gains, in the order of the terms
        for term in sympy.Add.make_args(multiplied_out(self.output)):
            signal, factor = term.as_independent(*gains, as_Add=False)
            if signal.free_symbols & set(gains) or not factor.is_polynomial(*gains):
                return ((sympy.S.One, self.output),)
            factors[factor] = None
        return tuple((factor, _signal(self.output, factor, gains)) for factor in factors)

    def _check(self, value: sympy.Expr, allowed: Set[sympy.Basic], what: str) -> None:
        """Refuse an expression of the law that contains a symbol outside `allowed`."""
        unknown = sorted(map(str, value.free_symbols - value.atoms(ConstantSymbol) - allowed))
        if unknown:
            raise ModelError(
                f"control law {self.name!r}: the {what} has the unknown symbols "
                f"{', '.join(unknown)}. Use only {', '.join(sorted(map(str, allowed)))}."
            )


def no_law(period: float) -> ControlLaw:
    """Return a sampled law whose output is 0; only a test signal added to it moves the axis.

    The law has no gains, so its names cannot collide with those of the axis.

    Parameters
    ----------
    period : float
        Sampling period, s.
    """
    return ControlLaw(name="none", period=period, output=sympy.S.Zero)


def gain(name: str) -> sympy.Symbol:
    """Return the symbol of a gain declared in `ControlLaw.gains`."""
    return sympy.Symbol(name, real=True)


def _signal(output: sympy.Expr, factor: sympy.Expr, gains: tuple[sympy.Symbol, ...]) -> sympy.Expr:
    """Return the signal that a product of gains multiplies in an output.

    The signal is computed by derivatives with respect to the gains, because expanding the output
    would lose digits.

    Parameters
    ----------
    output : sympy.Expr
        Output of the law, a polynomial in the gains.
    factor : sympy.Expr
        Product of gains.
    gains : tuple of sympy.Symbol
        All gains of the law.
    """
    powers = factor.as_powers_dict()
    for symbol in gains:
        power = powers.get(symbol, 0)
        output = output.diff(symbol, power) / sympy.factorial(power) if power else output
    return output.xreplace(dict.fromkeys(gains, sympy.S.Zero))
