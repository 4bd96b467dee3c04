"""Options of commands that take several records, collected into one object."""

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import click

from .inputs import Inputs
from .option_checks import check_needed, with_options


@dataclass(frozen=True, slots=True, kw_only=True)
class Sharing:
    """What several records share and what is each one's own, as the command line says it."""

    local: tuple[str, ...] = ()
    known: Mapping[str, tuple[tuple[float, float], ...]] = field(default_factory=dict)
    gain: str = "identified"

    def check_validates(self, like: int | None) -> None:
        """Refuse to hold estimates against a record of which nothing says what is its own."""
        if (self.local or self.known) and like is None:
            raise click.UsageError(
                "--validate holds parameters against another record, of which nothing says what "
                "--local and --known say of each; name the record that it is like: "
                "--validate-like 1."
            )

    def of(self, inputs: Inputs, logs: int) -> tuple[Inputs, dict[str, Any]]:
        """The inputs, with what is not identified without logs that are set aside; and arguments.

        The arguments are those of `identify` for the logs that are used.

        Raises
        ------
        UsageError
            There are not as many known values as logs, or something is each log's own of one.
        """
        from axisid.estimation.identification import (
            layout_for,
            layout_without,
            tells_gain,
        )
        from axisid.estimation.parameters import known_of

        check_needed(("--gain",), ("--known",))
        known_of(self.known, max(logs, 1))
        if not inputs.set_aside:
            return inputs, {"local": self.local, "known": self.known, "gain": self.gain}
        declared = {p.name for p in inputs.axis.declared.parameters}
        own = [name for name in self.local if name in declared]  # others are refused later
        commanded = tells_gain(inputs.records, self.gain)
        whole = layout_for(inputs.axis, logs, own, self.known, commanded=commanded)
        _, _, known, aside = layout_without(
            inputs.axis,
            whole,
            inputs.used,
            inputs.set_aside,
            own,
            self.known,
            commanded=commanded,
        )
        told = replace(inputs, set_aside=aside)
        local = self.local if len(inputs.used) > 1 else ()
        return told, {"local": local, "known": known, "gain": self.gain}


_OPTIONS = (
    click.option(
        "--local",
        metavar="NAME[,NAME]",
        help="Parameters that each of several records, two or more, has for itself.",
    ),
    click.option(
        "--known",
        multiple=True,
        metavar="NAME=V1,V2+-SD,...",
        help="What is known of each record, SI: a parameter (a payload, an angle, a temperature) "
        "or a gain of the control law, a value for each in their order; again for each name.",
    ),
    click.option(
        "--gain",
        type=click.Choice(["identified", "declared"]),
        default="identified",
        show_default=True,
        help="Of the drive, where a known force tells it.",
    ),
)


def names_in(text: str) -> tuple[str, ...]:
    """The names of a list as options take it, ``M,Fv``."""
    return tuple(name.strip() for name in text.split(",") if name.strip())


def sharing_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options; the command takes them as one `sharing`."""

    @functools.wraps(command)
    def collected(*, local: str | None, known: tuple[str, ...], gain: str, **others: Any) -> None:
        from axisid.estimation.parameters import read_known

        names = names_in(local or "")
        command(sharing=Sharing(local=names, known=read_known(known), gain=gain), **others)

    return with_options(collected, _OPTIONS)


skip_bad_option = click.option(
    "--skip-bad",
    is_flag=True,
    help="Go on without those of several records that cannot be used; they are counted and named, "
    "and what is not identified without them is told. With one record it changes nothing.",
)
columns_of_option = click.option(
    "--columns-of",
    "columns_of",
    type=(click.IntRange(min=1), str),
    multiple=True,
    metavar="N ROLE=NAME[:UNIT],...",
    help="Columns of the record number N alone, in place of --columns; again for each.",
)


def columns_by_place(given: Sequence[tuple[int, str]], logs: int) -> dict[int, str]:
    """Columns by the place of their log, from 0.

    Raises
    ------
    click.BadParameter
        There is no such log, or it is given twice.
    """
    found: dict[int, str] = {}
    for number, columns in given:
        if number > logs or number - 1 in found:
            there = f"there {'is 1 record' if logs == 1 else f'are {logs} records'}"
            why = "is given twice" if number - 1 in found else f"is none: {there}"
            raise click.BadParameter(f"record {number} {why}", param_hint="--columns-of")
        found[number - 1] = columns
    return found
