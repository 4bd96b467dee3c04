"""Options of the commands on reading, filtering and estimating, and the axis with its records.

Few options describe a log; its run.toml has all other settings.
"""

import csv
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import click

from axisid.estimation.choices import (
    FIT_STARTS,
    LOG_KEYS,
    LOSSES,
    OUTPUTS,
    RESTS,
    ROW_LOSSES,
    fitted_output,
    method_names,
)
from axisid.support.errors import AxisidError, UsageError

from . import stages
from .groups import Options, given_options, option, reading
from .outputs import progress_line

Value = TypeVar("Value")

#: Arguments of `click.option` for ``--bootstrap``.
BOOTSTRAP: dict[str, Any] = {
    "help": "Number of simulated replicas of the records, which give the bias and the standard "
    "errors. The replicas have the noise that was found in the records. 0 for none, otherwise at "
    "least 8.",
    "default": 32,
    "type": click.IntRange(0, 100_000),
    "metavar": "N",
}


def one_or_all(methods: tuple[str, ...]) -> tuple[str, ...]:
    """Return the methods; ``all`` is refused together with other methods except fits."""
    if "all" in methods and any(each != "all" and not fitted_output(each) for each in methods):
        raise click.UsageError(
            "--method all cannot be combined with other methods. Name only the methods to run, or "
            "omit --method."
        )
    return methods


method_option = click.option(
    "--method",
    "methods",
    type=click.Choice(["all", *method_names()]),
    multiple=True,
    default=("all",),
    callback=reading(one_or_all),
    help="Estimator. idm: inverse dynamic model. ddm: direct dynamic model. ls: least squares. iv: "
    "instrumental variables. didim: output error of the force; this method simulates the closed "
    "loop and needs the exact control law. all: every method that is possible with this axis and "
    "record; if a method is not possible, the output gives the reason. Can be repeated.  [default: "
    "all]",
)
bounded_option = click.option(
    "--bounded",
    is_flag=True,
    help="Fix a parameter at its declared bound if its estimate is beyond the bound. Without this "
    "option the estimate is reported and a check fails.",
)
loss_option = click.option(
    "--loss",
    type=click.Choice(ROW_LOSSES),
    default=ROW_LOSSES[0],
    show_default=True,
    help="Loss function of the residuals. huber and bisquare give outliers less weight.",
)


def leave_out_option(*, has_fix: bool) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Return a decorator that adds ``--leave-out``, which the command takes as `left_out`.

    `has_fix` is True for a command that has ``--fix``; the help then refers to this option.
    """
    other = "To set another value, use --fix NAME=VALUE instead. " if has_fix else ""
    return click.option(
        "--leave-out",
        "left_out",
        multiple=True,
        metavar="NAME",
        help="Do not identify this parameter. Its value is 0, or the nominal value if the model is "
        f"nonlinear in the parameter. {other}Can be repeated.",
    )


bootstrap_option = click.option("--bootstrap", show_default=True, **BOOTSTRAP)
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_BOUND = rf"\s*(\w+)\s*=(?=.*\d)\s*({_NUMBER})?\s*\.\.\s*({_NUMBER})?\s*"
_PRIOR = rf"\s*(\w+)\s*=\s*({_NUMBER})\s*(?:\+-|\+/-|±)\s*({_NUMBER})\s*"
_WEIGHT = rf"\s*([\w-]+)\s*=\s*({_NUMBER})\s*"
_KNOWN = re.compile(r"\s*(\w+)\s*=(.*)", re.DOTALL)
_ENTRY = re.compile(rf"\s*({_NUMBER})\s*(?:(?:\+-|\+/-|±)\s*({_NUMBER})\s*)?")
#: A value with an optional name and an optional per cent sign.
VALUE = rf"(?:\s*(\w+)\s*=)?\s*({_NUMBER})\s*(%)?"


@dataclass(frozen=True, slots=True, kw_only=True)
class Filtering(Options):
    """Options of the prefilter; None for an option that is not given."""

    cutoff: float | None = option(
        "Cut-off frequency of the Butterworth low-pass, Hz.  [default: 60, but at most a fifth of "
        "the sampling rate of the log]",
        type=float,
        metavar="HZ",
    )
    decimate: int | None = option(
        "Decimation: keep every Nth row.  [default: 10, or a larger N that suits a low cut-off]",
        type=int,
        metavar="N",
    )
    hold: str | None = option(
        "Force that is paired with a sample of the motion. zoh: mean of the force before and the "
        "force after the sample. raw: force after the sample.  [default: zoh if the drive holds "
        "the control between samples, otherwise raw]",
        type=click.Choice(["raw", "zoh"]),
    )
    reversals: str | None = option(
        "Keep or leave out samples near a velocity reversal or standstill, where the low-pass "
        "smooths the step of friction.  [default: leave-out for an axis with friction, unless the "
        "remaining samples contain too little information on a parameter]",
        type=click.Choice(["keep", "leave-out"]),
    )

    def prefilter(self, period: float | None = None) -> "stages.Prefilter":
        """Return the filter with the given settings.

        Settings that are not given follow from `period`, the sampling period in s. If it is None,
        they remain open until the filter is used for a record.
        """
        given = {name: value for name, value in self.arguments().items() if value is not None}
        if period is None:
            return stages.Prefilter(**given)
        return stages.Prefilter.suited(period, **given)


def fix_option(said: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Return a decorator that adds ``--fix``, which the command takes as `fix`."""
    return click.option("--fix", multiple=True, metavar="NAME=VALUE[+-SD]", help=said)


def names_in(text: str | None) -> tuple[str, ...]:
    """Return the names in a list such as ``M,Fv``; a name that occurs twice is refused."""
    names = tuple(map(str.strip, text.split(","))) if text else ()
    for name in names:
        if not name or names.count(name) > 1:
            found = f"{name!r} twice" if name else "an empty name"
            raise click.BadParameter(f"{text!r} has {found}. Give each name once, as in M,Fv.")
    return names


def _outputs(texts: tuple[str, ...]) -> tuple[str, ...]:
    """Return the outputs to be fitted, from texts with one or several names each."""
    names = names_in(",".join(texts))
    for name in names:
        if name not in OUTPUTS:
            raise click.BadParameter(
                f"there is no output {name!r}. Choose from {', '.join(OUTPUTS)}."
            )
    return names


def by_names(
    form: str, wrong: str, value: Callable[..., Value]
) -> Callable[[tuple[str, ...]], dict[str, Value]]:
    """Return a function that reads texts as values by name.

    Parameters
    ----------
    form : str
        Regular expression of each text; its first group is the name.
    wrong : str
        End of the message on a text that does not match; the text precedes it.
    value : callable
        Makes the value from the other groups; a group without text is empty.
    """

    def read(texts: tuple[str, ...]) -> dict[str, Value]:
        found = [(text, re.fullmatch(form, text)) for text in texts]
        for text, match in found:
            if match is None:
                raise click.BadParameter(f"{text!r} {wrong}")
        groups = [match.groups(default="") for _, match in found if match]
        return {name: value(*others) for name, *others in groups}

    return read


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitting(Options):
    """Settings of a fit, the arguments of `fit`."""

    output: tuple[str, ...] = option(
        "Recorded signals that the simulation is fitted to. "
        + "; ".join(f"{n}: {said}" for n, said in OUTPUTS.items())
        + ".",
        (next(iter(OUTPUTS)),),
        read=_outputs,
        multiple=True,
        metavar="NAME[,NAME]",
    )
    weights: dict[str, float] = option(
        "Weight of an output's errors: the inverse of their standard deviation, in 1/unit of the "
        "output. Can be repeated.  [default: from the residual of the output]",
        name="weight",
        read=by_names(
            _WEIGHT,
            "is not a weight. Write OUTPUT=NUMBER, the inverse of the standard deviation of the "
            "output's errors, as in position=2e5.",
            float,
        ),
        multiple=True,
        metavar="OUTPUT=NUMBER",
    )
    loss: str = option(
        "Loss function of the errors. " + "; ".join(f"{n}: {s}" for n, s in LOSSES.items()) + ".",
        next(iter(LOSSES)),
        type=click.Choice([*LOSSES]),
    )
    start: str = option(
        "Start of the search. instruments: estimate by instrumental variables; least-squares: "
        "estimate by least squares; nominal: nominal values. The nominal values are used instead "
        "of an estimate if the residual of the nominal values is smaller.",
        FIT_STARTS[0],
        type=click.Choice(FIT_STARTS),
    )
    starts: int = option(
        "Number of searches. The first search begins at the values of --start, every further "
        "search at random values near them. The search with the lowest loss gives the result.",
        1,
        type=click.IntRange(1, 1000),
        metavar="N",
    )
    bootstrap: int = option("", **BOOTSTRAP)
    horizon: float | None = option(
        "Length of the windows of an open-loop fit, s.  [default: 1, halved until there are 20 "
        "windows and the errors do not grow within a window]",
        type=click.FloatRange(0.0, min_open=True),
        metavar="S",
    )
    rests: str = option(
        "Keep or leave out samples near standstill and velocity reversals of the record or the "
        "simulated loop. These samples are always kept in an open-loop fit, for friction with "
        "internal state, and if the remaining samples are not enough to determine every parameter.",
        RESTS[0],
        type=click.Choice(RESTS),
    )
    bounds: dict[str, tuple[float | None, float | None]] = option(
        "Lower and upper bound of a parameter, SI, in addition to the declared bounds. Can be "
        "repeated.",
        name="bound",
        read=by_names(
            _BOUND,
            "is not a bound. Write NAME=LOW..HIGH in SI units. Either LOW or HIGH can be omitted, "
            "as in Fv=0..",
            lambda low, high: (float(low) if low else None, float(high) if high else None),
        ),
        multiple=True,
        metavar="NAME=LOW..HIGH",
    )
    prior: dict[str, tuple[float, float]] = option(
        "Prior value of a parameter with its standard deviation, SI. The fit weighs the prior "
        "against the record. Can be repeated.",
        read=by_names(
            _PRIOR,
            "has no standard deviation. Write NAME=VALUE+-SD, or --fix NAME=VALUE if the value is "
            "exact.",
            lambda v, sd: (float(v), float(sd)),
        ),
        multiple=True,
        metavar="NAME=VALUE+-SD",
    )
    free: tuple[str, ...] = option(
        "Further unknowns that are fitted together with the parameters. For a gain of the control "
        "law, write the name of this gain, such as kp. For the drive, write gain (its force "
        "constant), lag or delay. For the initial state of each simulated loop, write "
        "start_position, start_velocity, or start for both. Can be repeated.",
        read=lambda texts: names_in(",".join(texts)),
        multiple=True,
        metavar="NAME[,NAME]",
    )


def is_log(file: str) -> bool:
    """Return whether an argument names a log or a run.toml, by its ending."""
    return Path(file).suffix.lower() in stages.log_endings() or stages.log_of(file) != Path(file)


def _roles(text: str | None) -> dict[str, str]:
    """Return the columns by role in a text such as ``time=t,position=qm:mm``; empty for None."""
    found: dict[str, str] = {}
    for pair in next(csv.reader([text], skipinitialspace=True)) if text else ():
        role, equals, column = (part.strip() for part in pair.partition("="))
        if not equals or not role or not column or role in found:
            raise click.BadParameter(
                f"{pair!r} is not ROLE=NAME or ROLE=NAME:UNIT, or its role is given twice. Write "
                "each role once, as in time=t,position=qm:mm. Quote a pair whose name has a comma: "
                'time=t,"control=I, raw"'
            )
        found[role] = column
    return found


def _rate(text: str | None) -> float | str | None:
    """Return the rate in Hz if the text is a number; otherwise the text, such as ``auto``."""
    try:
        return None if text is None else float(text)
    except ValueError:
        return text


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading(Options):
    """Options that describe a log."""

    columns: dict[str, str] = option(key="columns", read=_roles)
    windows: tuple[str, ...] = option(
        "Use only this part of the log, s. Each part is filtered and simulated separately. Can be "
        "repeated.",
        key="windows",
        multiple=True,
    )
    resample: float | str | None = option(key="resample", read=_rate)
    gaps: str | None = option(key="gaps")

    def record(self, file: str, axis: "stages.GeneratedAxis") -> "stages.Record":
        """Return the record of an axis that a log contains."""
        return stages.read_record(file, axis, **self.settings())

    def settings(self) -> dict[str, Any]:
        """Return the options as arguments of `read_record`."""
        given = self.arguments()
        repairs = {key: given.pop(key) for key in [*given] if LOG_KEYS[key].is_repair}
        return {**given, "repairs": stages.Repairs(**repairs)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """An axis with its records, as the command line names them.

    Without logs, the record is that of the axis's twin.

    Attributes
    ----------
    axis : GeneratedAxis
    records : tuple of Record
    used : tuple of int
        For each record, the index of its log on the command line, from 0.
    set_aside : mapping of str to str
        Logs that could not be read and are skipped, with the reason.
    shared : mapping
        Arguments of `identify`: local parameters and known values of the records.
    """

    axis: "stages.GeneratedAxis"
    records: "tuple[stages.Record, ...]"
    used: tuple[int, ...]
    set_aside: Mapping[str, str]
    shared: Mapping[str, Any]

    def say_set_aside(self) -> None:
        """Print each log that could not be read, with the reason."""
        for name, why in self.set_aside.items():
            click.echo(f"axisid: skipped {name}: {why}", err=True)


def read_known(texts: Iterable[str]) -> dict[str, tuple[tuple[float, float], ...]]:
    """Return (value, standard deviation) of each record by name, from ``m_add=0,20+-0.01``.

    The standard deviation is 0 if the text has none.

    Raises
    ------
    UsageError
        A text has another form.
    """
    found: dict[str, tuple[tuple[float, float], ...]] = {}
    for text in texts:
        match = _KNOWN.fullmatch(text)
        entries = [_ENTRY.fullmatch(part) for part in match[2].split(",")] if match else []
        if match is None or not all(entries):
            wrong = [i for i, entry in enumerate(entries, 1) if entry is None]
            detail = f": value number {wrong[0]} is not a number" if wrong else ""
            raise UsageError(
                f"{text!r} does not give one value per record{detail}. Write NAME=V1,V2,... in SI "
                "units, one value for each record in the order of the records. Add +-SD to a value "
                "with a standard deviation: m_add=0,20+-0.01.",
                code="parameters",
            )
        found[match[1]] = tuple((float(e[1]), float(e[2] or 0.0)) for e in entries if e)
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class Sharing(Options):
    """Settings of several records: local parameters, known values, records to skip."""

    local: tuple[str, ...] = option(
        "Parameters that have a separate value for each record. At least two records are needed.",
        read=names_in,
        metavar="NAME[,NAME]",
    )
    known: Mapping[str, tuple[tuple[float, float], ...]] = option(
        "Known values of a parameter (a payload, an angle, a temperature) or of a gain of the "
        "control law, SI: one value for each record in the order of the records. Add +-SD, the "
        "standard deviation, to an uncertain value. Can be repeated.",
        read=read_known,
        multiple=True,
        metavar="NAME=V1,V2+-SD,...",
    )
    skip_bad: bool = option(
        "Skip records that cannot be used. The output counts and names the skipped records. The "
        "option has no effect with one record.",
        False,
    )


def axis_and_records(
    axis: str,
    logs: Sequence[str],
    reading: Reading,
    sharing: Sharing,
    further: Sequence[str] = (),
    *,
    fixed: tuple[str, ...] = (),
    left_out: tuple[str, ...] = (),
) -> Inputs:
    """Return an axis with the records of its logs; without logs, with the record of its twin.

    Parameters
    ----------
    axis : str
        Name or file of the axis.
    logs : sequence of str
        Files of the records.
    reading : Reading
        Settings of the logs.
    sharing : Sharing
        Settings of several records.
    further : sequence of str
        Logs for validation, which `reading` describes too.
    fixed, left_out : tuple of str
        Values of ``--fix`` and ``--leave-out``.

    Raises
    ------
    UsageError
        The number of known values differs from the number of logs.
    AxisidError
        A log cannot be read; the message names all such logs.
    """
    with progress_line(f"reading {' and '.join(logs) or f'the twin of {axis}'}"):
        if is_log(axis):
            raise UsageError(f"{axis} is a log. Name the axis before the log: AXIS RECORD.")
        whole = stages.fix(stages.load_axis(axis), **stages.read_fixed(fixed))
        generated = stages.build(stages.leave_out(whole, *left_out))
        found: dict[int, stages.Record] = {}
        bad: dict[str, str] = {}
        for i, log in enumerate(logs):
            try:
                found[i] = reading.record(log, generated)
            except AxisidError as error:
                if len(logs) == 1:
                    raise
                bad[log if log not in bad else f"{log} ({i + 1})"] = str(error)
        stages.check_usable(bad, len(logs), skip_bad=sharing.skip_bad)
        if not logs:
            given = [name for name in reading.names().values() if name in given_options()]
            if given and not further:
                describes = "describes" if len(given) == 1 else "describe"
                raise UsageError(
                    f"{' and '.join(given)} {describes} a record, but no record is given. Name its "
                    "file."
                )
            # The twin has every parameter, also those that are not identified.
            found[0] = stages.twin_record(stages.build(whole) if left_out else generated)
    stages.known_of(sharing.known, max(len(logs), 1))
    records, used = tuple(found.values()), tuple(found)
    shared: dict[str, Any] = {
        "local": () if bad and len(used) == 1 else sharing.local,
        "known": stages.known_of_used(used, sharing.known),
    }
    return Inputs(axis=generated, records=records, used=used, set_aside=bad, shared=shared)
