"""Options of every command that filters a record."""

from dataclasses import dataclass

import click

from . import stages
from .groups import Options, option

_AS_IDENTIFY = "As in identify."


@dataclass(frozen=True, slots=True, kw_only=True)
class Filtering(Options):
    """The filter that the command line asks for, as far as it does."""

    cutoff: float | None = option(_AS_IDENTIFY, type=float, metavar="HZ")
    order: int | None = option(_AS_IDENTIFY, type=int, metavar="N")
    decimate: int | None = option(_AS_IDENTIFY, type=int, metavar="N")
    decimation: str | None = option(_AS_IDENTIFY, type=click.Choice(["matlab", "scipy"]))
    drop: tuple[int, int] | None = option(_AS_IDENTIFY, type=int, nargs=2, metavar="START END")
    hold: str | None = option(_AS_IDENTIFY, type=click.Choice(["raw", "zoh"]))
    reversals: str | None = option(_AS_IDENTIFY, type=click.Choice(["keep", "leave-out"]))

    def __post_init__(self) -> None:
        if self.decimate == 1 and self.decimation is not None:
            raise click.UsageError(
                "--decimation aligns rows of which some are left out, and --decimate 1 keeps "
                "all; leave one of them out."
            )

    def prefilter(self, period: float | None = None) -> "stages.Prefilter":
        """The filter; what is left open suits the sampling period, if that is known."""
        given = {name: value for name, value in self.arguments().items() if value is not None}
        if period is None:
            return stages.Prefilter(**given)
        return stages.Prefilter.suited(period, **given)
