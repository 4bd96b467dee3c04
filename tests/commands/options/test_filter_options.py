"""Options of the filter: the same in every command that has them, explained once."""

from dataclasses import fields

import click
import pytest
from click.testing import CliRunner

from axisid.commands.main import cli
from axisid.commands.options.filter_options import _OPTIONS, Filtering, filter_options
from axisid.estimation.signals.prefilter import Prefilter

OF_THE_RECORD = {"segments", "masked", "silent"}


def test_every_setting_of_the_filter_is_an_option() -> None:
    assert set(_OPTIONS) == {field.name for field in fields(Prefilter)} - OF_THE_RECORD


@pytest.mark.parametrize(
    ("command", "elsewhere"),
    [("identify", set()), ("compare", set(_OPTIONS)), ("sweep", {"hold", "reversals"})],
)
def test_help_refers_to_identify_which_explains(command: str, elsewhere: set[str]) -> None:
    said = {p.name: p.help for p in cli.commands[command].params if isinstance(p, click.Option)}
    assert {name for name in _OPTIONS if said.get(name) == "As in identify."} == elsewhere


def test_a_command_has_the_options_it_names_and_gets_those_that_were_given() -> None:
    taken: list[Filtering] = []

    @click.command()
    @filter_options("order", "drop")
    def command(filtering: Filtering) -> None:
        taken.append(filtering)

    assert [p.name for p in command.params] == ["order", "drop"]
    CliRunner().invoke(command, ["--drop", "0", "7"], catch_exceptions=False)
    CliRunner().invoke(command, [], catch_exceptions=False)
    assert [dict(filtering.given) for filtering in taken] == [{"drop": (0, 7)}, {}]


def test_what_is_left_open_suits_the_sampling_period_once_that_is_known() -> None:
    filtering = Filtering({"cutoff": 30.0})
    assert filtering.prefilter() == Prefilter(cutoff=30.0)
    assert filtering.prefilter(1e-2) == Prefilter.suited(1e-2, cutoff=30.0)
