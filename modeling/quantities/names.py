"""Check the names and numbers of a declaration.

Names are used in generated Python and C text, so they are checked once, at declaration. Numbers
become plain floats.
"""

import contextlib
import keyword
import math
import re
from collections.abc import Iterable
from typing import Any

import sympy

from axisid.support.checks import refuse
from axisid.support.errors import ModelError
from axisid.support.wording import quoted

_PATTERN = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,30}")

_C_KEYWORDS = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if "
    "inline int long register restrict return short signed sizeof static struct switch typedef "
    "union unsigned void volatile while bool true false nullptr main".split()
)
# Functions of <math.h> and of CasADi that generated text may call.
_FUNCTIONS = frozenset(
    "sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt pow fabs fmin fmax sign abs min "
    "max".split()
)
# Arguments and results of the generated functions; CasADi uses the names `null jac hess`.
RESERVED = frozenset(
    "tau direction parameters ddm_parameters reference measured_position measured_velocity "
    "measurement_error reference_rate injected held control state next_state step row known "
    "limited_output unlimited_output output_limit jacobian first_slope last_slope sides switches "
    "by_position by_velocity plant_rate wave_number signals law_gains gains period casadi null jac "
    "hess".split()
)
_TAKEN = {
    "a keyword of Python": {*keyword.kwlist, *keyword.softkwlist},
    "a keyword of C": _C_KEYWORDS,
    "a mathematical function": _FUNCTIONS,
    "reserved for the generated functions": RESERVED,
}
# Symbols that the program makes: the parameters of the direct model, the delay line of a law, and
# the sides of kinks.
_PROGRAM_SYMBOLS = re.compile(r"(theta|delayed|side)\d+")


# Meaning of names that are known in every expression.
_CONSTANTS = {"pi": "the number pi", "G": "the standard acceleration of gravity"}


def check_name(name: str, what: str) -> str:
    """Return a name that generated text can contain; refuse other names.

    Parameters
    ----------
    name : str
    what : str
        Description of the named object, for messages.

    Raises
    ------
    ModelError
        The name is malformed, a keyword of C or Python, a function, or reserved.
    """
    if not isinstance(name, str) or not _PATTERN.fullmatch(name):
        raise ModelError(
            f"{what} is named {quoted(name)}. A name is a letter followed by at most 30 letters, "
            "digits or underscores. Choose another name.",
            code="axis",
        )
    subject = f"{what} is named {name!r}, which"
    refuse(
        ModelError,
        (
            _PROGRAM_SYMBOLS.fullmatch(name),
            f"{subject} is reserved for the program. Choose another name",
        ),
        *(
            (name in names, f"{subject} is {reason}. Choose another name")
            for reason, names in _TAKEN.items()
        ),
        code="axis",
    )
    return name


def check_symbol(name: str, what: str, *, control: bool = False) -> None:
    """Refuse a symbol's name that generated text cannot contain, or that has a fixed meaning.

    Parameters
    ----------
    name, what : str
        Name, and description of the named object for messages.
    control : bool
        Whether it is a symbol of a control law, in which ``G`` is not the acceleration of gravity.

    Raises
    ------
    ModelError
        `check_name` refuses the name, or the name is ``pi`` or ``G``.
    """
    check_name(name, what)
    if name in _CONSTANTS and not (control and name == "G"):
        raise ModelError(
            f"{what} is named {name!r}, which is {_CONSTANTS[name]} in every expression. Choose "
            "another name.",
            code="axis",
        )


def fresh_name(name: str, taken: set[str]) -> str:
    """Return a permitted name that differs from all names in use, ignoring case.

    Parameters
    ----------
    name : str
        Proposed name; a number is appended if it is in use.
    taken : set of str
        Names in use, in lower case; the new name is added.
    """
    stem, i = name[:28], 1
    while True:
        with contextlib.suppress(ModelError):
            check_symbol(name, "it")
            if name.lower() not in taken:
                taken.add(name.lower())
                return name
        i += 1
        name = f"{stem}_{i}"


def check_distinct(names: Iterable[tuple[str, str]]) -> None:
    """Refuse two names that are equal, or differ only by case.

    Parameters
    ----------
    names : iterable of (str, str)
        Each name with a description of the named object, for the message.

    Raises
    ------
    ModelError
        Two names are equal, or differ only by case.
    """
    seen: dict[str, tuple[str, str]] = {}
    for name, what in names:
        if name.lower() in seen:
            first, owner = seen[name.lower()]
            but = "" if name == first else " except for upper and lower case"
            raise ModelError(
                f"{what} {name!r} and {owner} {first!r} have the same name{but}. Rename one of "
                "the two.",
                code="axis",
            )
        seen[name.lower()] = (name, what)


_SIMPLE, _DIGITS = 1000, 6


def settle(record: object, **values: Any) -> None:
    """Set fields of a frozen dataclass to checked values, in its ``__post_init__``."""
    for name, value in values.items():
        object.__setattr__(record, name, value)


def number(value: Any, what: str, *, finite: bool = True) -> float:
    """Return a value as a float.

    Parameters
    ----------
    value : object
    what : str
        Description of the value, for messages.
    finite : bool
        Whether the value must be finite.

    Raises
    ------
    ModelError
        The value is not a number (also NaN, a text or a bool), or is infinite although it must be
        finite.
    """
    try:
        result = float(value)
    except (TypeError, ValueError, OverflowError):
        result = math.nan
    if isinstance(value, (str, bytes, bool)) or math.isnan(result):
        raise ModelError(f"{what} is {quoted(value)}. Give a number.", code="axis")
    if finite and math.isinf(result):
        raise ModelError(f"{what} is {quoted(value)}. Give a finite number.", code="axis")
    return result


def rounded(expression: sympy.Expr) -> sympy.Expr:
    """Return an expression with numbers rounded to six digits unless they are simple fractions."""
    return expression.xreplace(
        {
            x: sympy.Float(x, _DIGITS)
            for x in expression.atoms(sympy.Rational)
            if max(abs(x.p), x.q) >= _SIMPLE
        }
    )
