"""What commands are given: how a log is read, filtered and estimated from; the axis, its records.

Few options are of a log; all else of it is said in its run.toml.
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

#: Of the option ``--bootstrap``.
BOOTSTRAP: dict[str, Any] = {
    "help": "Bias and deviations from N simulated twins of the records, with their noise as it is "
    "measured; 0 for none, else 8 at least.",
    "default": 32,
    "type": click.IntRange(0, 100_000),
    "metavar": "N",
}


def one_or_all(methods: tuple[str, ...]) -> tuple[str, ...]:
    """Methods, of which all stand by themselves, but for fits."""
    if "all" in methods and any(each != "all" and not fitted_output(each) for each in methods):
        raise click.UsageError("--method all is by itself; name those that are wanted, or none.")
    return methods


method_option = click.option(
    "--method",
    "methods",
    type=click.Choice(["all", *method_names()]),
    multiple=True,
    default=("all",),
    show_default="all",
    callback=reading(one_or_all),
    help="Estimator, again for each: ls least squares, iv instruments, idm and ddm of the inverse "
    "and the direct model, didim output error of the force by the simulated loop, where the "
    "control law is right; all runs what axis and record allow, and says what it left out.",
)
bounded_option = click.option(
    "--bounded",
    is_flag=True,
    help="Hold a parameter that the judged method would have beyond its declared bound at that "
    "bound; else it is reported and fails a check.",
)
loss_option = click.option(
    "--loss",
    type=click.Choice(ROW_LOSSES),
    default=ROW_LOSSES[0],
    show_default=True,
    help="How rows count: by squares, or for less the larger their residual is.",
)
leave_out_option = click.option(
    "--leave-out",
    "left_out",
    multiple=True,
    metavar="NAME",
    help="A parameter that is not identified, as the record does not show it: held at what --fix "
    "says, else at 0 (at its nominal value if it enters nonlinearly); again for each.",
)
bootstrap_option = click.option("--bootstrap", show_default=True, **BOOTSTRAP)
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_BOUND = rf"\s*(\w+)\s*=(?=.*\d)\s*({_NUMBER})?\s*\.\.\s*({_NUMBER})?\s*"
_PRIOR = rf"\s*(\w+)\s*=\s*({_NUMBER})\s*(?:\+-|\+/-|±)\s*({_NUMBER})\s*"
_WEIGHT = rf"\s*([\w-]+)\s*=\s*({_NUMBER})\s*"
_KNOWN = re.compile(r"\s*(\w+)\s*=(.*)", re.DOTALL)
_ENTRY = re.compile(rf"\s*({_NUMBER})\s*(?:(?:\+-|\+/-|±)\s*({_NUMBER})\s*)?")
#: A value of a name, or of none, and whether it is in per cent.
VALUE = rf"(?:\s*(\w+)\s*=)?\s*({_NUMBER})\s*(%)?"


@dataclass(frozen=True, slots=True, kw_only=True)
class Filtering(Options):
    """The filter that the command line asks for, as far as it does."""

    cutoff: float | None = option(
        "Butterworth low-pass.  [default: 60, or a fifth of the log's rate if that is less]",
        type=float,
        metavar="HZ",
    )
    decimate: int | None = option(
        "Keep one row in N.  [default: 10, or more where the cut-off asks for it]",
        type=int,
        metavar="N",
    )
    hold: str | None = option(
        "zoh pairs motion with the mean of the forces held around a sample; raw with the one "
        "after it.  [default: zoh for a control that a drive holds, else raw]",
        type=click.Choice(["raw", "zoh"]),
    )
    reversals: str | None = option(
        "Samples near a reversal or a rest, where the low-pass rounds what friction does at once.  "
        "[default: leave-out for axes with friction, unless that hides a parameter]",
        type=click.Choice(["keep", "leave-out"]),
    )

    def prefilter(self, period: float | None = None) -> "stages.Prefilter":
        """The filter; what is left open suits the sampling period, if that is known."""
        given = {name: value for name, value in self.arguments().items() if value is not None}
        if period is None:
            return stages.Prefilter(**given)
        return stages.Prefilter.suited(period, **given)


def fix_option(said: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Add ``--fix``, which the command takes as `fix`."""
    return click.option("--fix", multiple=True, metavar="NAME=VALUE[+-SD]", help=said)


def names_in(text: str | None) -> tuple[str, ...]:
    """The names of a list as options take it, ``M,Fv``, none of them twice."""
    names = tuple(map(str.strip, text.split(","))) if text else ()
    for name in names:
        if not name or names.count(name) > 1:
            raise click.BadParameter(
                f"{text!r} has {f'{name!r} twice' if name else 'an empty name'}; name each once, "
                "as in M,Fv."
            )
    return names


def _outputs(texts: tuple[str, ...]) -> tuple[str, ...]:
    names = names_in(",".join(texts))
    for name in names:
        if name not in OUTPUTS:
            raise click.BadParameter(
                f"there is no output {name!r}; choose from {', '.join(OUTPUTS)}."
            )
    return names


def by_names(
    form: str, wrong: str, value: Callable[..., Value]
) -> Callable[[tuple[str, ...]], dict[str, Value]]:
    """What reads texts as values by name.

    Parameters
    ----------
    form : str
        Of each text, a regular expression whose first group is the name.
    wrong : str
        What is said of a text without it, after the text.
    value : callable
        Makes the value of the other groups; those without a text are empty.
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
    """What a fit is asked for, the arguments of `fit`."""

    output: tuple[str, ...] = option(
        "What is followed, several together: "
        + ", ".join(f"{n} {said}" for n, said in OUTPUTS.items())
        + ".",
        (next(iter(OUTPUTS)),),
        read=_outputs,
        multiple=True,
        metavar="NAME[,NAME]",
    )
    weights: dict[str, float] = option(
        "By which an output's errors count: the inverse of their deviation, in its unit; "
        "again for each.  [default: of what is left of it]",
        name="weight",
        read=by_names(
            _WEIGHT,
            "weighs nothing; write OUTPUT=NUMBER, the inverse of the deviation of its errors, as "
            "in position=2e5.",
            float,
        ),
        multiple=True,
        metavar="OUTPUT=NUMBER",
    )
    loss: str = option(
        "How errors count: " + ", ".join(f"{n} {said}" for n, said in LOSSES.items()) + ".",
        next(iter(LOSSES)),
        type=click.Choice([*LOSSES]),
    )
    start: str = option(
        "Where the search starts; nominal values where they leave less.",
        FIT_STARTS[0],
        type=click.Choice(FIT_STARTS),
    )
    starts: int = option(
        "Searches, the others from about the start; the lowest end is taken.",
        1,
        type=click.IntRange(1, 1000),
        metavar="N",
    )
    bootstrap: int = option("", **BOOTSTRAP)
    horizon: float | None = option(
        "Length of the windows of an open loop, s.  [default: 1, or as its motion allows]",
        type=click.FloatRange(0.0, min_open=True),
        metavar="S",
    )
    rests: str = option(
        "Samples near rests and reversals of the record or of its loop. They are kept all the "
        "same where the others show too little, and in an open loop.",
        RESTS[0],
        type=click.Choice(RESTS),
    )
    bounds: dict[str, tuple[float | None, float | None]] = option(
        "Bounds of a parameter, SI, within the declared ones; again for each.",
        name="bound",
        read=by_names(
            _BOUND,
            "bounds nothing; write NAME=LOW..HIGH, SI, one of them left out for none, as in Fv=0..",
            lambda low, high: (float(low) if low else None, float(high) if high else None),
        ),
        multiple=True,
        metavar="NAME=LOW..HIGH",
    )
    prior: dict[str, tuple[float, float]] = option(
        "What was known of a parameter before, SI, which is weighed; again for each.",
        read=by_names(
            _PRIOR,
            "has no standard deviation; write NAME=VALUE+-SD, or --fix NAME=VALUE where it is "
            "exact.",
            lambda v, sd: (float(v), float(sd)),
        ),
        multiple=True,
        metavar="NAME=VALUE+-SD",
    )
    free: tuple[str, ...] = option(
        "Gains of the control law that are searched with the parameters, the drive's gain, "
        "its lag or its delay, or the start of the loops: start_position, start_velocity, or start "
        "for both.",
        read=lambda texts: names_in(",".join(texts)),
        multiple=True,
        metavar="NAME[,NAME]",
    )


def is_log(file: str) -> bool:
    """Whether an argument is a log, by its ending, or a run.toml, which stands in its place."""
    return Path(file).suffix.lower() in stages.log_endings() or stages.log_of(file) != Path(file)


def _roles(text: str | None) -> dict[str, str]:
    """Columns by role."""
    found: dict[str, str] = {}
    for pair in next(csv.reader([text], skipinitialspace=True)) if text else ():
        role, equals, column = (part.strip() for part in pair.partition("="))
        if not equals or not role or not column or role in found:
            raise click.BadParameter(
                f"{pair!r} is not ROLE=NAME or ROLE=NAME:UNIT with each role once, as in "
                "time=t,position=qm:mm; quote a pair whose name has a comma: "
                'time=t,"control=I, raw"'
            )
        found[role] = column
    return found


def _rate(text: str | None) -> float | str | None:
    """Hertz, where it is a number."""
    try:
        return None if text is None else float(text)
    except ValueError:
        return text


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading(Options):
    """What the command line says of a log."""

    columns: dict[str, str] = option(key="columns", read=_roles)
    windows: tuple[str, ...] = option(key="windows", multiple=True)
    resample: float | str | None = option(key="resample", read=_rate)
    gaps: str | None = option(key="gaps")

    def record(self, file: str, axis: "stages.GeneratedAxis") -> "stages.Record":
        """Read a log as the record of an axis."""
        return stages.read_record(file, axis, **self.settings())

    def settings(self) -> dict[str, Any]:
        """Arguments of `read_record`."""
        said = self.arguments()
        repairs = {key: said.pop(key) for key in [*said] if LOG_KEYS[key].is_repair}
        return {**said, "repairs": stages.Repairs(**repairs)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """The axis that was named, and its records or its twin's.

    Attributes
    ----------
    axis : GeneratedAxis
    records : tuple of Record
    used : tuple of int
        Which of the logs they are.
    set_aside : mapping of str to str
        Logs that could not be read and were to be skipped, with the reason.
    shared : mapping
        Arguments of `identify`: what the records that are used have for themselves.
    """

    axis: "stages.GeneratedAxis"
    records: "tuple[stages.Record, ...]"
    used: tuple[int, ...]
    set_aside: Mapping[str, str]
    shared: Mapping[str, Any]

    def say_set_aside(self) -> None:
        """Tell of each log that could not be read."""
        for name, why in self.set_aside.items():
            click.echo(f"axisid: without {name}: {why}", err=True)


def read_known(texts: Iterable[str]) -> dict[str, tuple[tuple[float, float], ...]]:
    """Values by record from texts such as ``m_add=0,20+-0.01``.

    Raises
    ------
    UsageError
        A text is something else.
    """
    found: dict[str, tuple[tuple[float, float], ...]] = {}
    for text in texts:
        match = _KNOWN.fullmatch(text)
        entries = [_ENTRY.fullmatch(part) for part in match[2].split(",")] if match else [None]
        if match is None or not all(entries):
            wrong = next(
                (f", of which number {i} is no value" for i, e in enumerate(entries, 1) if not e),
                "",
            )
            raise UsageError(
                f"{text!r} says nothing of each record{wrong * (match is not None)}; write "
                "NAME=V1,V2,..., SI, one value for each record in their order, each with its "
                "deviation if it has one: m_add=0,20+-0.01.",
                code="parameters",
            )
        found[match[1]] = tuple((float(e[1]), float(e[2] or 0.0)) for e in entries if e)
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class Sharing(Options):
    """What several records share and what is each one's own, as the command line says it."""

    local: tuple[str, ...] = option(
        "Parameters that each of several records, two or more, has for itself.",
        read=names_in,
        metavar="NAME[,NAME]",
    )
    known: Mapping[str, tuple[tuple[float, float], ...]] = option(
        "What is known of each record, SI: a parameter (a payload, an angle, a temperature) "
        "or a gain of the control law, a value for each in their order; again for each name.",
        read=read_known,
        multiple=True,
        metavar="NAME=V1,V2+-SD,...",
    )
    skip_bad: bool = option(
        "Go on without those of several records that cannot be used; they are counted and named. "
        "With one record it changes nothing.",
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
    """The axis that was named, and its records or its twin's.

    Parameters
    ----------
    axis : str
    logs : sequence of str
    reading : Reading
    sharing : Sharing
    further : sequence of str
        Other logs that `reading` is of.
    fixed, left_out : tuple of str

    Raises
    ------
    UsageError
        There are not as many known values as logs.
    AxisidError
        What cannot be read; of several logs it is named with the others that cannot.
    """
    with progress_line(f"reading {' and '.join(logs) or f'the twin of {axis}'}"):
        if is_log(axis):
            raise UsageError(f"{axis} is a log; the axis comes first: AXIS RECORD.")
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
                raise UsageError(
                    f"{' and '.join(given)} {'describes' if len(given) == 1 else 'describe'} a "
                    "record; name its file."
                )
            # The twin has every term, as an axis does whatever is identified of it.
            found[0] = stages.twin_record(stages.build(whole) if left_out else generated)
    stages.known_of(sharing.known, max(len(logs), 1))
    records, used = tuple(found.values()), tuple(found)
    shared: dict[str, Any] = {
        "local": () if bad and len(used) == 1 else sharing.local,
        "known": stages.known_of_used(used, sharing.known),
    }
    return Inputs(axis=generated, records=records, used=used, set_aside=bad, shared=shared)
