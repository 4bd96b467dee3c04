"""Members that a result and its document share by name are written and read back alike."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from axisid.presentation.documents.same_members import number, read_as, written_as
from axisid.presentation.schema import JsonObject
from axisid.support.arrays import Array


@dataclass(frozen=True, kw_only=True)
class Figures:
    name: str
    size: float
    strength: float
    period: float | None
    times: Array
    by: tuple[str, ...]


class WrittenFigures(JsonObject, frozen=True, kw_only=True):
    size: float | None
    strength: float | None
    period: float | None
    times: tuple[float, ...]
    by: tuple[str, ...]
    more: str


def test_what_is_alike_is_copied_both_ways_and_what_differs_is_named() -> None:
    here = Figures(
        name="a", size=math.nan, strength=math.inf, period=None, times=np.arange(2.0), by=("b",)
    )
    written = written_as(WrittenFigures, here, more="c")
    assert written == WrittenFigures(
        size=None, strength=None, period=None, times=(0.0, 1.0), by=("b",), more="c"
    )
    back = read_as(Figures, written, {"strength": math.inf}, name="a")
    assert (back.name, back.strength, back.period, back.by) == ("a", math.inf, None, ("b",))
    assert math.isnan(back.size)
    assert back.times.tolist() == [0.0, 1.0]
    with pytest.raises(ValueError, match="read-only"):
        back.times[0] = 1.0


def test_a_member_that_is_not_there_is_an_error_of_the_program() -> None:
    with pytest.raises(AttributeError):
        written_as(WrittenFigures, 1.0, more="c")


def test_a_number_that_was_not_written_is_not_a_number() -> None:
    assert number(2.0) == 2.0
    assert math.isnan(number(None))
    assert number(None, 3.0) == 3.0
