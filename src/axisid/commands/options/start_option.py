"""Where instruments start, an option of every command that iterates."""

from collections.abc import Callable

import click

from axisid.estimation.choices import STARTS


def start_option(
    says: str = "As in identify.",
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Add the option; the command takes it as `started_at`."""
    return click.option(
        "--start",
        "started_at",
        type=click.Choice(STARTS),
        default=STARTS[0],
        show_default=True,
        help=says,
    )
