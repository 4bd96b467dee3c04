"""Options of commands that take several records."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import click

from . import stages
from .groups import Options, option
from .inputs import Inputs
from .option_checks import check_needed
from .record_options import roles


def names_in(text: str | None) -> tuple[str, ...]:
    """The names of a list as options take it, ``M,Fv``."""
    return tuple(name.strip() for name in (text or "").split(",") if name.strip())


def _known(texts: tuple[str, ...]) -> dict[str, tuple[tuple[float, float], ...]]:

    return stages.read_known(texts)


def _columns(given: tuple[tuple[int, str], ...]) -> dict[int, dict[str, str]]:
    found: dict[int, dict[str, str]] = {}
    for number, columns in given:
        if number in found:
            raise click.BadParameter(f"record {number} is given twice")
        found[number] = roles(columns)
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class Sharing(Options):
    """What several records share and what is each one's own, as the command line says it."""

    columns_of: Mapping[int, dict[str, str]] = option(
        "Columns of the record number N alone, in place of --columns; again for each.",
        read=_columns,
        type=(click.IntRange(min=1), str),
        multiple=True,
        metavar="N ROLE=NAME[:UNIT],...",
    )
    local: tuple[str, ...] = option(
        "Parameters that each of several records, two or more, has for itself.",
        read=names_in,
        metavar="NAME[,NAME]",
    )
    known: Mapping[str, tuple[tuple[float, float], ...]] = option(
        "What is known of each record, SI: a parameter (a payload, an angle, a temperature) "
        "or a gain of the control law, a value for each in their order; again for each name.",
        read=_known,
        multiple=True,
        metavar="NAME=V1,V2+-SD,...",
    )
    gain: str = option(
        "Of the drive, where a known force tells it.",
        "identified",
        type=click.Choice(["identified", "declared"]),
    )
    skip_bad: bool = option(
        "Go on without those of several records that cannot be used; they are counted and named, "
        "and what is not identified without them is told. With one record it changes nothing.",
        False,
    )

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
        check_needed(("--gain",), ("--known",))
        stages.known_of(self.known, max(logs, 1))
        if not inputs.set_aside:
            return inputs, {"local": self.local, "known": self.known, "gain": self.gain}
        declared = {p.name for p in inputs.axis.declared.parameters}
        own = [name for name in self.local if name in declared]  # others are refused later
        commanded = stages.tells_gain(inputs.records, self.gain)
        whole = stages.layout_for(inputs.axis, logs, own, self.known, commanded=commanded)
        _, _, known, aside = stages.layout_without(
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

    def own_columns(self, logs: int) -> dict[int, dict[str, str]]:
        """Columns by the place of their log, from 0.

        Raises
        ------
        click.BadParameter
            There is no such log.
        """
        for number in self.columns_of:
            if number > logs:
                there = f"there {'is 1 record' if logs == 1 else f'are {logs} records'}"
                raise click.BadParameter(
                    f"record {number} is none: {there}", param_hint="--columns-of"
                )
        return {number - 1: columns for number, columns in self.columns_of.items()}
