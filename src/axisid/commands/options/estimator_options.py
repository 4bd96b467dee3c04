"""Options of how a record is estimated from, each by itself and all collected into one object."""

import functools
from collections.abc import Callable
from typing import Any

import click

from axisid.estimation.choices import (
    ROW_LOSSES,
    assumptions,
    covariance_names,
    is_iteration,
    method_names,
    takes_lags,
)
from axisid.estimation.thresholds import LEAST_SHARE, LEVEL

from .option_checks import check_idle, with_options
from .start_option import start_option

method_option = click.option(
    "--method",
    "methods",
    type=click.Choice([*method_names(), "all"]),
    multiple=True,
    default=("all",),
    show_default="all",
    help="Estimator, again for each: ls least squares, iv instruments, idm and ddm of the inverse "
    "and the direct model, didim output error of the force by the simulated loop, where the "
    "control law is right; all runs what axis and record allow, and says what it left out.",
)
covariance_option = click.option(
    "--covariance",
    type=click.Choice(covariance_names()),
    default=covariance_names()[0],
    show_default=True,
    help=f"What intervals, draws and tests assume of the residuals: {assumptions()}.",
)
lags_option = click.option(
    "--lags",
    type=click.IntRange(min=0),
    metavar="N",
    help="Rows over which the HAC deviations take residuals as alike.  [default: from the data]",
)
loss_option = click.option(
    "--loss",
    type=click.Choice(ROW_LOSSES),
    default=ROW_LOSSES[0],
    show_default=True,
    help="How rows count: by squares, or for less the larger their residual is.",
)
bounded_option = click.option(
    "--bounded",
    is_flag=True,
    help="Hold a parameter that the judged method would have beyond its declared bound at that "
    "bound; else it is reported and fails a check.",
)
draws_option = click.option(
    "--draws",
    type=click.IntRange(2, 1_000_000),
    metavar="N",
    help="Add intervals from N draws of each estimate, which do without the delta method.",
)
bootstrap_option = click.option(
    "--bootstrap",
    type=click.IntRange(0, 100_000),
    default=32,
    show_default=True,
    metavar="N",
    help="Bias and deviations from N simulated twins of the records, with their noise as it is "
    "measured; 0 for none.",
)
start_of_instruments = start_option(
    "Of instruments: least squares where its simulated loop follows the record, or the nominal "
    "values, as published."
)


def levels_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add ``--level`` and ``--least-share``; the command takes them as one `levels`, arguments."""

    @functools.wraps(command)
    def collected(*, level: float, least_share: float, **others: Any) -> None:
        command(levels={"level": level, "least_share": least_share}, **others)

    return with_options(collected, _LEVELS)


def fix_option(said: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Add ``--fix``, which the command takes as `fix`."""
    return click.option("--fix", multiple=True, metavar="NAME=VALUE[+-SD]", help=said)


def drive_time_option(said: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Add ``--drive-time``, which the command takes as `drive_time`."""
    return click.option("--drive-time", type=click.Choice(["lag", "delay"]), help=said)


def check_estimator(methods: tuple[str, ...], covariance: str) -> None:
    """Refuse options that the others leave without effect."""
    if "all" in methods and len(methods) > 1:
        raise click.UsageError("--method all is by itself; name those that are wanted, or none.")
    if "all" not in methods and not any(map(is_iteration, methods)):
        named = " and ".join(methods)
        check_idle("--start", f"is of instruments, which --method {named} does without")
    if not takes_lags(covariance):
        check_idle("--lags", f"is of HAC deviations, which --covariance {covariance} leaves out")


_LEVELS = (
    click.option(
        "--level",
        type=float,
        default=LEVEL.value,
        show_default=True,
        help="Chance that a check speaks against a right model, over all that it looks for.",
    ),
    click.option(
        "--least-share",
        type=float,
        default=LEAST_SHARE.value,
        show_default=True,
        help="Part of the force, or of a parameter, from which that matters; so does what the "
        "model lacks where it moves a parameter by more than its interval.",
    ),
)
_AS_GIVEN = ("lags", "loss", "bounded")
_OPTIONS = (
    method_option,
    covariance_option,
    lags_option,
    start_of_instruments,
    loss_option,
    bounded_option,
    levels_options,
    draws_option,
)


def estimator_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options; the command takes them as one `estimating`, with the draws of the result."""

    @functools.wraps(command)
    def collected(
        *,
        methods: tuple[str, ...],
        covariance: str,
        started_at: str,
        draws: int | None,
        levels: dict[str, Any],
        **others: Any,
    ) -> None:
        check_estimator(methods, covariance)
        estimating = {
            "methods": None if "all" in methods else methods,
            "covariance": covariance,
            "start": started_at,
            "draws": draws or 0,
            **levels,
            **{name: others.pop(name) for name in _AS_GIVEN},
        }
        command(estimating=estimating, **others)

    return with_options(collected, _OPTIONS)
