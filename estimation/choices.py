"""What users choose by name, a row for each: methods, covariances, outputs of fits, keys of a log.

In: nothing. Out: rows that say where it lives, from which `axisid.estimation.methods` has it.
Knows nothing of how anything is computed, so that help and completion load no stage.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType


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

INVERSE, DIRECT = (f"axisid.estimation.regression:{side}Form" for side in ("Inverse", "Direct"))
#: In the order in which they are run, and of help and messages.
METHOD_ROWS = (
    MethodRow(name="idm-ls", method=_LEAST_SQUARES, form=INVERSE, compares=True),
    MethodRow(name="ddm-ls", method=_LEAST_SQUARES, form=DIRECT),
    MethodRow(name="idm-iv", method=_INSTRUMENTS, form=INVERSE, compares=True),
    MethodRow(name="ddm-iv", method=_INSTRUMENTS, form=DIRECT, same_as="idm-iv"),
    MethodRow(name="didim", method=f"{_METHODS}.didim:Didim", form=INVERSE, output_error=True),
)

LEAST_SQUARES_START, NOMINAL_START = "least-squares", "nominal"
#: Where instruments may start, first the one by default.
INSTRUMENT_STARTS = (LEAST_SQUARES_START, NOMINAL_START)

SQUARES_LOSS, HUBER_LOSS, BISQUARE_LOSS = "squares", "huber", "bisquare"
#: How rows count, in the order of help, first the one by default.
ROW_LOSSES = (SQUARES_LOSS, HUBER_LOSS, BISQUARE_LOSS)


def method_names() -> tuple[str, ...]:
    """Return the names, in the order of help."""
    return tuple(row.name for row in METHOD_ROWS)


def instruments_of(name: str) -> str:
    """Return the method that solves least squares' form by instruments; empty for other methods."""
    forms = [row.form for row in METHOD_ROWS if (row.name, row.method) == (name, _LEAST_SQUARES)]
    able = (row for row in METHOD_ROWS if row.method == _INSTRUMENTS and row.form in forms)
    return next((row.name for row in able), "")


def is_output_error(name: str) -> bool:
    """Return whether the rows of a method are the simulated loop's."""
    return any(row.output_error for row in METHOD_ROWS if row.name == name)


def comparison_methods() -> tuple[str, ...]:
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
    covariance : str
        ``module:class`` of the `Covariance`.
    allows_autocorrelation : bool
        Whether residuals that follow one another may be correlated.
    takes_lags : bool
        Whether the class takes lags, None letting the data choose; else it takes nothing.
    """

    name: str
    label: str
    covariance: str
    allows_autocorrelation: bool = False
    takes_lags: bool = False


_REGRESSION = "axisid.estimation.regression"
#: In the order of help and tables, first the one by default.
COVARIANCE_ROWS = (
    CovarianceRow(
        name="hac",
        label="HAC",
        covariance=f"{_REGRESSION}.covariance:Hac",
        allows_autocorrelation=True,
        takes_lags=True,
    ),
    CovarianceRow(
        name="robust",
        label="robust",
        covariance=f"{_REGRESSION}.covariance:Robust",
    ),
    CovarianceRow(
        name="iid",
        label="i.i.d.",
        covariance=f"{_REGRESSION}.covariance:PublishedCovariance",
    ),
)

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
OPEN_LOOP_FIT = f'axisid fit with output="{OPEN_LOOP}"'

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


@dataclass(frozen=True, slots=True, kw_only=True)
class LogKey:
    """What may be said of a log, by a key of its run.toml and an argument in Python.

    Attributes
    ----------
    name : str
        Of the key, and of the argument of `read_record` or of `Repairs`.
    said : str
        What it means, for help and for comments.
    example : str
        A value as TOML has it.
    option : str
        What it is called on the command line, without dashes; empty where it stands in the file
        alone.
    metavar : str
        Of the option.
    is_repair : bool
        Whether it is one of `Repairs`.
    """

    name: str
    said: str
    example: str
    option: str = ""
    metavar: str = ""
    is_repair: bool = False


#: By name, in the order of a file, whose tables are last.
LOG_KEYS: Mapping[str, LogKey] = {
    key.name: key
    for key in (
        LogKey(
            name="sample_period",
            said="In place of the time column's mean step, s; confirms that the log is not sampled "
            "as the control law runs, which is then simulated at its own period.",
            example="1e-3",
        ),
        LogKey(
            name="windows",
            said="Take only this part of the log, s, or these, each filtered and simulated by "
            "itself.",
            example='["2..8.5", "12.."]',
            option="window",
            metavar="FROM..TO",
        ),
        LogKey(
            name="injected_at",
            said="What the test signal in the column injected was added to, control or reference; "
            "to the control before the drive's limit.",
            example='"control"',
        ),
        LogKey(
            name="resample",
            said="Uneven or different times onto an even grid.",
            example='"auto"',
            option="resample",
            metavar="HZ|auto",
            is_repair=True,
        ),
        LogKey(
            name="gaps",
            said="Cut the log where samples are missing or its clock goes back; each piece is "
            "filtered by itself.",
            example='"split"',
            option="gaps",
            metavar="split",
            is_repair=True,
        ),
        LogKey(
            name="wrap",
            said="Undo jumps of the position by it; give other columns a lost sign back, as in "
            '"control=65536".',
            example='"360:deg"',
            is_repair=True,
        ),
        LogKey(
            name="mask",
            said="Leave out the rows that samples reach which the drive's limit or a recorder cut "
            "off.",
            example='"clipped"',
            is_repair=True,
        ),
        LogKey(
            name="tail",
            said="Leave out what is no row at the end of a text: a line or number cut off, a "
            "footer.",
            example='"drop"',
            is_repair=True,
        ),
        LogKey(
            name="max_memory",
            said="Bytes that reading the log may take, half of the machine's memory by default.",
            example="4e9",
        ),
        LogKey(
            name="columns",
            said="Columns by name or number (#3); roles: time, position, velocity and acceleration "
            "(measured), reference, control, force, injected (a test signal), signals that the "
            "axis declares; units such as mm, deg, rpm, ms, mA, or a scaling, as in "
            "inc:counts*360deg/4096/50+0.2deg.",
            example='{ time = "t:ms", position = "pos:mm" }',
            option="columns",
            metavar="ROLE=NAME[:UNIT],...",
        ),
        LogKey(
            name="shift",
            said="Move a column so many samples to later times, or by a time such as 2ms, where "
            "the log wrote it too early.",
            example="{ control = 1 }",
            is_repair=True,
        ),
        LogKey(
            name="between",
            said="What a measured velocity, acceleration or force is between its values, where "
            "they are written in every few samples alone: spline, linear or held.",
            example='{ velocity = "spline" }',
            is_repair=True,
        ),
    )
}
