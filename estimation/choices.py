"""What users choose by name, a row for each: methods, covariances, outputs of fits, keys of a log.

In: nothing. Out: rows that say where it lives, from which `axisid.estimation.methods` has it.
Knows nothing of how anything is computed, so that help and completion load no stage.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from axisid.support.settings import other_command


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
        CONTROL: "the control of the simulated loop",
        POSITION: "the position of the simulated loop, which needs the exact control law",
        FORCE: "the force of the simulated drive",
        OPEN_LOOP: "the position simulated with the recorded control, in windows",
    }
)


def open_loop_fit() -> str:
    """Return the command that fits the position under the recorded control."""
    return other_command("fit", "output", OPEN_LOOP)


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
            said="Sampling period of the log, s, instead of the mean step of its time column. It "
            "confirms that the log has another period than the control law; the law is then "
            "simulated at its own period.",
            example="1e-3",
        ),
        LogKey(
            name="windows",
            said="Use only these parts of the log, s. Each is filtered and simulated separately.",
            example='["2..8.5", "12.."]',
            option="window",
            metavar="FROM..TO",
        ),
        LogKey(
            name="injected_at",
            said="Injection point of the test signal in the column injected: control (between the "
            "law and the drive's limit) or reference.",
            example='"control"',
        ),
        LogKey(
            name="resample",
            said="Interpolate uneven samples, or columns with different times, onto one even grid.",
            example='"auto"',
            option="resample",
            metavar="HZ|auto",
            is_repair=True,
        ),
        LogKey(
            name="gaps",
            said="Cut the log where samples are missing or its clock goes back. Each piece is "
            "filtered separately.",
            example='"split"',
            option="gaps",
            metavar="split",
            is_repair=True,
        ),
        LogKey(
            name="wrap",
            said="Remove jumps of the position by this modulus. It also restores the sign of "
            'unsigned numbers in other columns, as in "control=65536".',
            example='"360:deg"',
            is_repair=True,
        ),
        LogKey(
            name="mask",
            said="Leave out the rows whose filters reach samples at the limit of the drive or of "
            "the recorder.",
            example='"clipped"',
            is_repair=True,
        ),
        LogKey(
            name="tail",
            said="Leave out lines at the end of a text file that are not rows: a line or number "
            "that was cut off, a footer.",
            example='"drop"',
            is_repair=True,
        ),
        LogKey(
            name="max_memory",
            said="Largest memory for reading the log, bytes; half of the machine's by default.",
            example="4e9",
        ),
        LogKey(
            name="columns",
            said="Columns for the roles, by name or number (#3). Roles are time, position, "
            "velocity and acceleration (measured), reference, control, force, injected (a test "
            "signal), and signals that the axis declares. Units are mm, deg, rpm, ms, mA and "
            "others, or a scaling, as in inc:counts*360deg/4096/50+0.2deg.",
            example='{ time = "t:ms", position = "pos:mm" }',
            option="columns",
            metavar="ROLE=NAME[:UNIT],...",
        ),
        LogKey(
            name="shift",
            said="Move a column to later times, by a number of samples or by a time such as 2ms, "
            "if the logger wrote it too early.",
            example="{ control = 1 }",
            is_repair=True,
        ),
        LogKey(
            name="between",
            said="Interpolate a measured velocity, acceleration or force that has values only in "
            "every few samples: spline, linear or held.",
            example='{ velocity = "spline" }',
            is_repair=True,
        ),
    )
}
