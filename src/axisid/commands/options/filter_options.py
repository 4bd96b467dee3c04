"""Options of every command that filters a record, collected into one object."""

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from axisid.estimation.signals import Prefilter


@dataclass(frozen=True, slots=True)
class Filtering:
    """The filter that the command line asks for, as far as it does."""

    given: Mapping[str, Any]

    def prefilter(self, period: float | None = None) -> "Prefilter":
        """The filter; what is left open suits the sampling period, if that is known."""
        from axisid.estimation.signals import Prefilter

        return Prefilter(**self.given) if period is None else Prefilter.suited(period, **self.given)


_OPTIONS: dict[str, dict[str, Any]] = {
    "cutoff": {"type": float, "metavar": "HZ"},
    "order": {"type": int, "metavar": "N"},
    "decimate": {"type": int, "metavar": "N"},
    "decimation": {"type": click.Choice(["matlab", "scipy"])},
    "drop": {"type": int, "nargs": 2, "metavar": "START END"},
    "hold": {"type": click.Choice(["raw", "zoh"])},
    "reversals": {"type": click.Choice(["keep", "leave-out"])},
}

#: Names of all of them on the command line.
FILTER_OPTIONS = tuple(f"--{name}" for name in _OPTIONS)


def filter_options(
    *only: str, **helps: str
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Add the options; the command takes them as one `filtering`.

    Parameters
    ----------
    *only : str
        The options that the command has, all by default.
    **helps : str
        What an option says of itself where that is not "As in identify."
    """
    names = only or tuple(_OPTIONS)

    def add(command: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(command)
        def collected(**values: Any) -> None:
            options = {name: values.pop(name) for name in names}
            if options.get("decimate") == 1 and options.get("decimation") is not None:
                raise click.UsageError(
                    "--decimation aligns rows of which some are left out, and --decimate 1 keeps "
                    "all; leave one of them out."
                )
            given = {name: value for name, value in options.items() if value is not None}
            command(filtering=Filtering(given), **values)

        for name in reversed(names):
            said = helps.get(name, "As in identify.")
            collected = click.option(f"--{name}", **_OPTIONS[name], help=said)(collected)
        return collected

    return add
