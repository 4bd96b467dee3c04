"""Every method of estimation, by the name that users give."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class MethodRow:
    """A method, and where it lives.

    Attributes
    ----------
    name : str
        As users give it, ``idm-ls``.
    method : str
        ``module:class`` of the `Method`.
    form : str
        ``module:class`` of the `Form` that it regresses.
    compares : bool
        Whether `compare` can judge models by it, which solves the rows of the inverse model that
        are not held out by least squares, or by the estimate's instruments.
    same_as : str
        The method that solves the same equations for the same estimate; empty for none.
    output_error : bool
        Whether its rows are the simulated loop's, so that nothing that was measured of the motion
        is among them, and what it leaves is the simulation error.
    """

    name: str
    method: str
    form: str
    compares: bool = False
    same_as: str = ""
    output_error: bool = False


_METHODS = "axisid.estimation.methods"
_LEAST_SQUARES = f"{_METHODS}.least_squares:LeastSquares"
_INSTRUMENTS = f"{_METHODS}.instrumental:Instruments"
_DIDIM = f"{_METHODS}.didim:Didim"
INVERSE, DIRECT = (f"axisid.estimation.regression:{side}Form" for side in ("Inverse", "Direct"))
#: In the order in which they are run, and of help and messages.
METHOD_ROWS = (
    MethodRow(name="idm-ls", method=_LEAST_SQUARES, form=INVERSE, compares=True),
    MethodRow(name="ddm-ls", method=_LEAST_SQUARES, form=DIRECT),
    MethodRow(name="idm-iv", method=_INSTRUMENTS, form=INVERSE, compares=True),
    MethodRow(name="ddm-iv", method=_INSTRUMENTS, form=DIRECT, same_as="idm-iv"),
    MethodRow(name="didim", method=_DIDIM, form=INVERSE, output_error=True),
)

LEAST_SQUARES_START, NOMINAL_START = "least-squares", "nominal"
#: Where instruments may start, first the one by default.
STARTS = (LEAST_SQUARES_START, NOMINAL_START)

SQUARES_LOSS, HUBER_LOSS, BISQUARE_LOSS = "squares", "huber", "bisquare"
#: How rows count, in the order of help, first the one by default.
ROW_LOSSES = (SQUARES_LOSS, HUBER_LOSS, BISQUARE_LOSS)


def method_names() -> tuple[str, ...]:
    """Return the names, in the order of help."""
    return tuple(row.name for row in METHOD_ROWS)


def is_iteration(name: str) -> bool:
    """Return whether a method iterates, so that it starts somewhere."""
    return any(row.method in (_INSTRUMENTS, _DIDIM) for row in METHOD_ROWS if row.name == name)


def instruments_of(name: str) -> str:
    """Return the method that solves least squares' form by instruments; empty for other methods."""
    forms = [row.form for row in METHOD_ROWS if (row.name, row.method) == (name, _LEAST_SQUARES)]
    able = (row for row in METHOD_ROWS if row.method == _INSTRUMENTS and row.form in forms)
    return next((row.name for row in able), "")


def is_output_error(name: str) -> bool:
    """Return whether the rows of a method are the simulated loop's."""
    return any(row.output_error for row in METHOD_ROWS if row.name == name)


def comparing() -> tuple[str, ...]:
    """Return the methods that `compare` can judge models by."""
    return tuple(row.name for row in METHOD_ROWS if row.compares)


def same_estimates(names: Sequence[str]) -> dict[str, str]:
    """Return those of some methods whose estimate is that of another one of them, with that one."""
    same = {row.name: row.same_as for row in METHOD_ROWS if row.same_as}
    return {name: same[name] for name in names if same.get(name) in names}
