"""Options of fits, collected into one object."""

import functools
import re
from collections.abc import Callable
from typing import Any

import click

from axisid.estimation.choices import FIT_STARTS, LOSSES, OUTPUTS, RESTS

from .estimator_options import bootstrap_option, levels_options
from .option_checks import with_options
from .several_options import names_in

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_BOUND = re.compile(rf"\s*(\w+)\s*=\s*({_NUMBER})?\s*\.\.\s*({_NUMBER})?\s*")
_WEIGHT = re.compile(rf"\s*([\w-]+)\s*=\s*({_NUMBER})\s*")


def _output(name: str) -> str:
    if name not in OUTPUTS:
        raise click.BadParameter(
            f"there is no output {name!r}; choose from {', '.join(OUTPUTS)}.",
            param_hint="--output",
        )
    return name


def _priors(texts: tuple[str, ...]) -> dict[str, tuple[float, float]]:
    from axisid.modeling.declaration import read_fixed

    found = read_fixed(texts)
    if exact := [text for text in texts if not any(sd for _, sd in read_fixed((text,)).values())]:
        raise click.BadParameter(
            f"{exact[0]!r} has no standard deviation; write NAME=VALUE+-SD, or --fix {exact[0]} "
            "where it is exact.",
            param_hint="--prior",
        )
    return found


def _bound(text: str) -> tuple[str, tuple[float | None, float | None]]:
    match = _BOUND.fullmatch(text)
    if match is None or not (match[2] or match[3]):
        raise click.BadParameter(
            f"{text!r} bounds nothing; write NAME=LOW..HIGH, SI, one of them left out for none, as "
            "in Fv=0..",
            param_hint="--bound",
        )
    low, high = (float(x) if x else None for x in (match[2], match[3]))
    return match[1], (low, high)


def _weight(text: str) -> tuple[str, float]:
    match = _WEIGHT.fullmatch(text)
    if match is None:
        raise click.BadParameter(
            f"{text!r} weighs nothing; write OUTPUT=NUMBER, the inverse of the deviation of its "
            "errors, as in position=2e5.",
            param_hint="--weight",
        )
    return match[1], float(match[2])


_AS_GIVEN = ("loss", "starts", "bootstrap", "horizon", "rests")
_OPTIONS = (
    click.option(
        "--output",
        multiple=True,
        default=(next(iter(OUTPUTS)),),
        show_default=True,
        metavar="NAME[,NAME]",
        help="What is followed, several together: "
        + ", ".join(f"{n} {said}" for n, said in OUTPUTS.items())
        + ".",
    ),
    click.option(
        "--weight",
        multiple=True,
        metavar="OUTPUT=NUMBER",
        help="By which an output's errors count: the inverse of their deviation, in its unit; "
        "again for each.  [default: of what is left of it]",
    ),
    click.option(
        "--loss",
        type=click.Choice([*LOSSES]),
        default=next(iter(LOSSES)),
        show_default=True,
        help="How errors count: " + ", ".join(f"{n} {said}" for n, said in LOSSES.items()) + ".",
    ),
    click.option(
        "--start",
        "started_at",
        type=click.Choice(FIT_STARTS),
        default=FIT_STARTS[0],
        show_default=True,
        help="Where the search starts; nominal values where they leave less.",
    ),
    click.option(
        "--starts",
        type=click.IntRange(1, 1000),
        default=1,
        show_default=True,
        metavar="N",
        help="Searches, the others from about the start; the lowest end is taken.",
    ),
    bootstrap_option,
    click.option(
        "--horizon",
        type=click.FloatRange(0.0, min_open=True),
        metavar="S",
        help="Length of the windows of an open loop, s.  [default: 1, or as its motion allows]",
    ),
    click.option(
        "--rests",
        type=click.Choice(RESTS),
        default=RESTS[0],
        show_default=True,
        help="Samples near rests and reversals of the record or of its loop. They are kept all the "
        "same where the others show too little, and in an open loop.",
    ),
    click.option(
        "--bound",
        multiple=True,
        metavar="NAME=LOW..HIGH",
        help="Bounds of a parameter, SI, within the declared ones; again for each.",
    ),
    click.option(
        "--prior",
        multiple=True,
        metavar="NAME=VALUE+-SD",
        help="What was known of a parameter before, SI, which is weighed; again for each.",
    ),
    click.option(
        "--free",
        multiple=True,
        metavar="NAME[,NAME]",
        help="Gains of the control law that are searched with the parameters, the drive's gain, "
        "its lag or its delay, or the start of the loops: start_position, start_velocity, or start "
        "for both.",
    ),
    levels_options,
)


def fit_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options; the command takes them as one `asked`, the arguments of `fit`.

    An output that is unknown, and a bound or a prior that cannot be read, are usage errors.
    """

    @functools.wraps(command)
    def collected(
        *,
        output: tuple[str, ...],
        weight: tuple[str, ...],
        bound: tuple[str, ...],
        prior: tuple[str, ...],
        free: tuple[str, ...],
        started_at: str,
        levels: dict[str, Any],
        **others: Any,
    ) -> None:
        asked = {
            "output": tuple(_output(name) for text in output for name in names_in(text)),
            "weights": dict(map(_weight, weight)) or None,
            "start": started_at,
            "bounds": dict(map(_bound, bound)),
            "prior": _priors(prior),
            "free": tuple(each for text in free for each in names_in(text)),
            **levels,
            **{name: others.pop(name) for name in _AS_GIVEN},
        }
        command(asked=asked, **others)

    return with_options(collected, _OPTIONS)
