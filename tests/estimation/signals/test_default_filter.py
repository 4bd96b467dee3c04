"""What a filter leaves open follows the record's rate, in Python as from the command line."""

import copy
import pickle
from dataclasses import replace

import pytest

from axisid import Prefilter, Record, identify
from axisid.codegen.artefacts import GeneratedAxis
from axisid.commands.options.filter_options import Filtering
from axisid.estimation import FilteredRecord


@pytest.mark.parametrize(
    ("rate", "cutoff", "decimate"),
    [(100, 20.0, 10), (250, 50.0, 10), (300, 60.0, 10), (1000, 60.0, 10), (4000, 60.0, 27)],
)
def test_the_default_filter_serves_every_rate(rate: int, cutoff: float, decimate: int) -> None:
    found = Prefilter().at_rate_of(1 / rate)
    assert (found.cutoff, found.decimate) == (pytest.approx(cutoff), decimate)
    assert found == Prefilter.suited(1 / rate) == Filtering({}).prefilter(1 / rate)


@pytest.mark.parametrize("cutoff", [5.0, 10.0, 45.0, 180.0])
def test_a_cutoff_alone_chooses_the_decimation_that_the_command_line_does(
    emps2015: GeneratedAxis, twin: Record, cutoff: float
) -> None:
    by_command = Filtering({"cutoff": cutoff}).prefilter(twin.period)
    result = identify(emps2015, twin, Prefilter(cutoff=cutoff), ["idm-ls"])
    assert result.prefilter.decimate == by_command.decimate
    assert result.requested == by_command
    bound = FilteredRecord.bind(emps2015, twin, Prefilter(cutoff=cutoff))
    assert bound.prefilter == result.prefilter


def test_what_is_given_stays() -> None:
    given = Prefilter(cutoff=60.0, decimate=10)
    assert given.at_rate_of(0.01) == given
    assert Prefilter(decimate=3).at_rate_of(0.01).decimate == 3


def test_what_is_open_stays_open_in_copies() -> None:
    for made in (
        copy.deepcopy(Prefilter()),
        pickle.loads(pickle.dumps(Prefilter())),  # noqa: S301
        replace(Prefilter(), hold="raw"),
    ):
        assert made.at_rate_of(0.01).cutoff == pytest.approx(20.0)
    assert repr(Prefilter()).startswith("Prefilter(cutoff=60.0, order=4, decimate=10,")


def test_a_log_of_100_hertz_is_identified_unasked(emps2015: GeneratedAxis, twin: Record) -> None:
    rows = slice(0, None, 10)
    columns = {role: values[rows] for role, values in twin.channels().items()}
    slow = Record(**columns, sample_period=0.01)  # type: ignore[arg-type]
    result = identify(emps2015, slow)
    assert result.prefilter.cutoff == pytest.approx(20.0)
    assert result["idm-ls"].parameters["M"].value == pytest.approx(100.0, rel=0.03)
