"""Options of how a record is filtered and estimated from, and of fits."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import click

from axisid.estimation.choices import (
    FIT_STARTS,
    LOSSES,
    OUTPUTS,
    RESTS,
    ROW_LOSSES,
    fitted_output,
    method_names,
)

from . import stages
from .groups import Options, option, reading
from .inputs import names_in

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
bootstrap_option = click.option("--bootstrap", show_default=True, **BOOTSTRAP)
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_BOUND = rf"\s*(\w+)\s*=(?=.*\d)\s*({_NUMBER})?\s*\.\.\s*({_NUMBER})?\s*"
_PRIOR = rf"\s*(\w+)\s*=\s*({_NUMBER})\s*(?:\+-|\+/-|±)\s*({_NUMBER})\s*"
_WEIGHT = rf"\s*([\w-]+)\s*=\s*({_NUMBER})\s*"
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
