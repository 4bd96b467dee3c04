"""What users choose by name, a row for each: methods of estimation, covariances, outputs of fits.

In: nothing. Out: rows that say where it lives, from which `axisid.estimation.methods` has it.
Knows nothing of how anything is computed, so that help and completion load no stage.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from axisid.support.errors import UsageError
from axisid.support.remedy import Setting
from axisid.support.user_values import is_among, quoted


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


@dataclass(frozen=True, slots=True, kw_only=True)
class CovarianceRow:
    """A covariance of an estimate, and where it lives.

    Attributes
    ----------
    name : str
        As users give it, ``hac``.
    label : str
        In tables.
    assumes : str
        What residuals may be, for help: ``"autocorrelated"``.
    covariance : str
        ``module:class`` of the `Covariance`.
    allows_autocorrelation : bool
        Whether residuals that follow one another may be correlated.
    takes_lags : bool
        Whether the class takes lags, None letting the data choose; else it takes nothing.
    """

    name: str
    label: str
    assumes: str
    covariance: str
    allows_autocorrelation: bool = False
    takes_lags: bool = False


_REGRESSION = "axisid.estimation.regression"
#: In the order of help and tables, first the one by default.
COVARIANCE_ROWS = (
    CovarianceRow(
        name="hac",
        label="HAC",
        assumes="autocorrelated",
        covariance=f"{_REGRESSION}.covariance:Hac",
        allows_autocorrelation=True,
        takes_lags=True,
    ),
    CovarianceRow(
        name="robust",
        label="robust",
        assumes="of any variance",
        covariance=f"{_REGRESSION}.covariance:Robust",
    ),
    CovarianceRow(
        name="iid",
        label="i.i.d.",
        assumes="alike and independent",
        covariance=f"{_REGRESSION}.covariance:PublishedCovariance",
    ),
)


def covariance_names() -> tuple[str, ...]:
    """Return the names, in the order of help."""
    return tuple(row.name for row in COVARIANCE_ROWS)


def assumptions() -> str:
    """Return what each covariance assumes of residuals, for help."""
    return ", ".join(f"{row.name} {row.assumes}" for row in COVARIANCE_ROWS)


def takes_lags(name: str) -> bool:
    """Return whether a covariance is over a number of lags."""
    return any(row.takes_lags for row in COVARIANCE_ROWS if row.name == name)


CONTROL, POSITION, FORCE, OPEN_LOOP = "control", "position", "force", "open-loop"
#: In the order of help, first the one by default.
OUTPUTS: Mapping[str, str] = MappingProxyType(
    {
        CONTROL: "what the simulated loop's law gives",
        POSITION: "the simulated loop's position, where the law is exact",
        FORCE: "the simulated drive's force",
        OPEN_LOOP: "the position under the recorded control, in windows",
    }
)

#: How it is asked for.
OPEN_LOOP_FIT = Setting("fit output", OPEN_LOOP)

#: What the name of a fit begins with among other methods.
FIT = "fit:"


def fit_names() -> tuple[str, ...]:
    """Fits by one output each that twins record, as they are named among other methods."""
    return tuple(f"{FIT}{output}" for output in OUTPUTS if output != FORCE)


def fitted_output(method: str) -> str:
    """What a method fits; empty for one that is no fit."""
    return method.removeprefix(FIT) if method.startswith(FIT) else ""


SQUARES, SOFT_L1, HUBER = "squares", "soft-l1", "huber"
#: In the order of help, first the one by default.
LOSSES: Mapping[str, str] = MappingProxyType(
    {
        SQUARES: "all samples alike",
        SOFT_L1: "large errors for less, smoothly",
        HUBER: "errors beyond 1.345 deviations for less",
    }
)

INSTRUMENTS_START = "instruments"
#: Where a fit may start, first the one by default.
FIT_STARTS = (INSTRUMENTS_START, LEAST_SQUARES_START, NOMINAL_START)

#: What becomes of samples near rests and reversals, first the choice by default.
RESTS = ("leave-out", "keep")


def check_among(*rows: tuple[str, object, Collection[str]]) -> None:
    """Refuse what is none of the choices that there are.

    Parameters
    ----------
    *rows : tuple
        What it is, in words, what was given, and the choices.

    Raises
    ------
    UsageError
        It is none of them.
    """
    for what, given, choices in rows:
        if not is_among(given, choices):
            raise UsageError(
                f"there is no {what} {quoted(given)}; choose from {', '.join(choices) or 'none'}.",
                code="unknown-choice",
            )
