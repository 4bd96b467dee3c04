"""Options of how a record is estimated from."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import click

from axisid.estimation.choices import (
    ROW_LOSSES,
    STARTS,
    assumptions,
    covariance_names,
    is_iteration,
    method_names,
    takes_lags,
)
from axisid.estimation.thresholds import LEAST_SHARE, LEVEL

from .groups import Options, option
from .option_checks import check_idle

#: Of the option ``--bootstrap``.
BOOTSTRAP: dict[str, Any] = {
    "help": "Bias and deviations from N simulated twins of the records, with their noise as it is "
    "measured; 0 for none, else 8 at least.",
    "default": 32,
    "type": click.IntRange(0, 100_000),
    "metavar": "N",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimating(Options):
    """How rows are estimated from, arguments of `identify`."""

    covariance: str = option(
        f"What intervals, draws and tests assume of the residuals: {assumptions()}.",
        covariance_names()[0],
        type=click.Choice(covariance_names()),
    )
    lags: int | None = option(
        "Rows over which the HAC deviations take residuals as alike.  [default: from the data]",
        type=click.IntRange(min=0),
        metavar="N",
    )
    start: str = option(
        "Of instruments: least squares where its simulated loop follows the record, or the "
        "nominal values, as published.",
        STARTS[0],
        type=click.Choice(STARTS),
    )
    loss: str = option(
        "How rows count: by squares, or for less the larger their residual is.",
        ROW_LOSSES[0],
        type=click.Choice(ROW_LOSSES),
    )

    def check(self, methods: tuple[str, ...]) -> None:
        """Refuse options that the others leave without effect."""
        if "all" in methods and len(methods) > 1:
            raise click.UsageError(
                "--method all is by itself; name those that are wanted, or none."
            )
        if "all" not in methods and not any(map(is_iteration, methods)):
            named = " and ".join(methods)
            check_idle("--start", f"is of instruments, which --method {named} does without")
        if not takes_lags(self.covariance):
            check_idle(
                "--lags", f"is of HAC deviations, which --covariance {self.covariance} leaves out"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Judging(Options):
    """What checks are held to, arguments of what judges."""

    level: float = option(
        "Chance that a check speaks against a right model, over all that it looks for.",
        LEVEL.value,
        type=float,
    )
    least_share: float = option(
        "Part of the force, or of a parameter, from which that matters; so does what the "
        "model lacks where it moves a parameter by more than its interval.",
        LEAST_SHARE.value,
        type=float,
    )


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


start_option = click.option(
    "--start",
    "started_at",
    type=click.Choice(STARTS),
    default=STARTS[0],
    show_default=True,
    help="As in identify.",
)
bootstrap_option = click.option("--bootstrap", show_default=True, **BOOTSTRAP)


def fix_option(said: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Add ``--fix``, which the command takes as `fix`."""
    return click.option("--fix", multiple=True, metavar="NAME=VALUE[+-SD]", help=said)


def drive_time_option(said: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Add ``--drive-time``, which the command takes as `drive_time`."""
    return click.option("--drive-time", type=click.Choice(["lag", "delay"]), help=said)
