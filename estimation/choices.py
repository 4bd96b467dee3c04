"""Choices by name: methods, covariances, outputs and losses of fits, keys of a log.

In: nothing. Out: rows with the module of each choice, which `axisid.estimation.methods` loads.
Knows nothing of computations, so that help and completion load no stage.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from axisid.support.settings import other_command


@dataclass(frozen=True, slots=True, kw_only=True)
class MethodRow:
    """A method, with the module and class that implement it.

    Attributes
    ----------
    name : str
        As users give it, ``idm-ls``.
    method : str
        ``module:class`` of the `Method`.
    form : str
        ``module:class`` of the form of the model, inverse or direct, whose rows it solves.
    compares : bool
        True if `compare` can use the method: `compare` solves the rows of the inverse model that
        are not held out, by least squares or with the instruments of the estimate.
    same_as : str
        The method that solves the same equations for the same estimate; empty for none.
    output_error : bool
        True if its rows are those of the simulated loop: they contain no measured motion, and the
        residual is the simulation error.
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
#: Methods in the order in which they are run, which is also that of help and messages.
METHOD_ROWS = (
    MethodRow(name="idm-ls", method=_LEAST_SQUARES, form=INVERSE, compares=True),
    MethodRow(name="ddm-ls", method=_LEAST_SQUARES, form=DIRECT),
    MethodRow(name="idm-iv", method=_INSTRUMENTS, form=INVERSE, compares=True),
    MethodRow(name="ddm-iv", method=_INSTRUMENTS, form=DIRECT, same_as="idm-iv"),
    MethodRow(name="didim", method=f"{_METHODS}.didim:Didim", form=INVERSE, output_error=True),
)

LEAST_SQUARES_START, NOMINAL_START = "least-squares", "nominal"
#: Starts of the instruments, the default first.
INSTRUMENT_STARTS = (LEAST_SQUARES_START, NOMINAL_START)

SQUARES_LOSS, HUBER_LOSS, BISQUARE_LOSS = "squares", "huber", "bisquare"
#: Loss functions of rows in the order of help, the default first.
ROW_LOSSES = (SQUARES_LOSS, HUBER_LOSS, BISQUARE_LOSS)


def method_names() -> tuple[str, ...]:
    """Return the names of the methods, in the order of help."""
    return tuple(row.name for row in METHOD_ROWS)


def instruments_of(name: str) -> str:
    """Return the method by instruments with the same form of the model as a least-squares method.

    Empty for the name of a method that is not least squares.
    """
    forms = [row.form for row in METHOD_ROWS if (row.name, row.method) == (name, _LEAST_SQUARES)]
    for row in METHOD_ROWS:
        if row.method == _INSTRUMENTS and row.form in forms:
            return row.name
    return ""


def is_output_error(name: str) -> bool:
    """Return True if the rows of a method are those of the simulated loop."""
    return any(row.output_error for row in METHOD_ROWS if row.name == name)


def comparison_methods() -> tuple[str, ...]:
    """Return the names of the methods that `compare` can use."""
    return tuple(row.name for row in METHOD_ROWS if row.compares)


def same_estimates(names: Sequence[str]) -> dict[str, str]:
    """Return the given methods whose estimate another given method repeats, by name.

    Each name is that of the later method, such as ``ddm-iv``; its value is the other method with
    the same estimate, ``idm-iv``. Empty where no two given methods have the same estimate.
    """
    same = {row.name: row.same_as for row in METHOD_ROWS if row.same_as}
    return {name: same[name] for name in names if same.get(name) in names}


@dataclass(frozen=True, slots=True, kw_only=True)
class CovarianceRow:
    """A covariance of an estimate, with the module and class that implement it.

    Attributes
    ----------
    name : str
        As users give it, ``hac``.
    label : str
        Name in tables.
    covariance : str
        ``module:class`` of the `Covariance`.
    allows_autocorrelation : bool
        True if consecutive residuals may be correlated.
    takes_lags : bool
        True if the class takes a number of lags, None for a choice from the data; otherwise it
        takes no argument.
    """

    name: str
    label: str
    covariance: str
    allows_autocorrelation: bool = False
    takes_lags: bool = False


_REGRESSION = "axisid.estimation.regression"
#: Covariances in the order of help and tables, the default first.
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
#: Outputs of fits in the order of help, the default first.
OUTPUTS: Mapping[str, str] = MappingProxyType(
    {
        CONTROL: "the control of the simulated loop",
        POSITION: "the position of the simulated loop (most sensitive to an error of the control "
        "law)",
        FORCE: "the force of the simulated drive",
        OPEN_LOOP: "the position simulated with the recorded control, in windows",
    }
)


def open_loop_fit() -> str:
    """Return the command that fits the position simulated with the recorded control."""
    return other_command("fit", "output", OPEN_LOOP)


#: Prefix of the names of fits among other methods.
FIT = "fit:"


def fit_names() -> tuple[str, ...]:
    """Return the names of the fits of one output, as in lists of methods: ``fit:control``.

    The fit of the force is not among them, because twins do not record a force.
    """
    return tuple(f"{FIT}{output}" for output in OUTPUTS if output != FORCE)


def fitted_output(method: str) -> str:
    """Return the output that a method fits; empty for a method that is not a fit."""
    return method.removeprefix(FIT) if method.startswith(FIT) else ""


SQUARES, SOFT_L1, HUBER = "squares", "soft-l1", "huber"
#: Losses of fits in the order of help, the default first.
LOSSES: Mapping[str, str] = MappingProxyType(
    {
        SQUARES: "all samples have equal weight",
        SOFT_L1: "the weight decreases smoothly with the size of the error",
        HUBER: "errors above 1.345 standard deviations have less weight",
    }
)

INSTRUMENTS_START = "instruments"
#: Starts of a fit, the default first.
FIT_STARTS = (INSTRUMENTS_START, LEAST_SQUARES_START, NOMINAL_START)

#: Treatments of samples near standstill and velocity reversals, the default first.
RESTS = ("leave-out", "keep")


@dataclass(frozen=True, slots=True, kw_only=True)
class LogKey:
    """A key of the run.toml of a log, which is also an argument in Python.

    Attributes
    ----------
    name : str
        Name of the key, and of the argument of `read_record` or `Repairs`.
    said : str
        Meaning of the key, for help and for comments in a run.toml.
    example : str
        A value in TOML.
    option : str
        Name on the command line, without dashes; empty for a key of the file only.
    metavar : str
        Placeholder of the option's value in help.
    is_repair : bool
        True for an argument of `Repairs`.
    """

    name: str
    said: str
    example: str
    option: str = ""
    metavar: str = ""
    is_repair: bool = False


#: Keys by name, in the order of a file, whose tables are last.
LOG_KEYS: Mapping[str, LogKey] = {
    key.name: key
    for key in (
        LogKey(
            name="sample_period",
            said="Sampling period of the log, s, instead of the mean step of its time column. This "
            "key confirms that the log has another period than the control law. The law is then "
            "simulated at its own period.",
            example="1e-3",
        ),
        LogKey(
            name="windows",
            said="Use only these parts of the log, s. Each part is filtered and simulated "
            "separately.",
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
            said="Resample columns with uneven or different times to one even grid: at this rate "
            "in Hz, or with auto at the median rate of the position.",
            example='"auto"',
            option="resample",
            metavar="HZ|auto",
            is_repair=True,
        ),
        LogKey(
            name="gaps",
            said="Cut the log where samples are missing or the clock of the log goes back. Each "
            "piece is filtered separately.",
            example='"split"',
            option="gaps",
            metavar="split",
            is_repair=True,
        ),
        LogKey(
            name="wrap",
            said="Remove jumps of the position by this modulus. A modulus of another column "
            'restores the sign of its unsigned numbers, as in "control=65536".',
            example='"360:deg"',
            is_repair=True,
        ),
        LogKey(
            name="mask",
            said="Leave out each row whose filter reaches a sample at the limit of the drive or of "
            "the recorder.",
            example='"clipped"',
            is_repair=True,
        ),
        LogKey(
            name="tail",
            said="Leave out lines at the end of a text file that are not rows: a line or number "
            "that was cut off, or a footer.",
            example='"drop"',
            is_repair=True,
        ),
        LogKey(
            name="max_memory",
            said="Largest memory for reading the log, bytes. The default is half of the machine's "
            "memory.",
            example="4e9",
        ),
        LogKey(
            name="columns",
            said="Columns by name or number (#3), as NAME or NAME:UNIT. Roles: time, position, "
            "velocity and acceleration (measured), reference, control, force, injected (a test "
            "signal), and signals that the axis declares. UNIT is mm, deg, rpm, ms, mA, ..., or a "
            "scaling. Example: inc:counts*360deg/4096/50+0.2deg. In this example inc is the name "
            "of the column, counts is the unit of its values (4096 per turn, gear ratio 50), and "
            "0.2deg is an offset.",
            example='{ time = "t:ms", position = "pos:mm" }',
            option="columns",
            metavar="ROLE=NAME[:UNIT],...",
        ),
        LogKey(
            name="shift",
            said="Move a column to later times if the logger wrote it too early, by a number of "
            "samples or by a time such as 2ms.",
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
