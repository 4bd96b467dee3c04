"""An axis that is given with a result's file has the drive that was identified."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest

from axisid import Parameter, load_axis
from axisid.elements import Drive
from axisid.presentation.saved.contradictions import refuse_other_drive
from axisid.presentation.schema import WrittenDriveTime, WrittenResponse
from tests.refusals import refuses


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"lag": 2e-3}, "lag 0.001"),
        ({"logged": "current"}, "logged command"),
        ({"lag": Parameter("Tc", "s", nominal=1e-3)}, "to be estimated"),
        ({"relative_sd": 0.02}, "relative_sd 0.005"),
        ({}, ""),
    ],
)
def test_an_axis_with_another_drive_is_refused(given: dict[str, Any], says: str) -> None:
    written = WrittenResponse(lag=1e-3, delay=0.0, logged="command")
    held = SimpleNamespace(drive=written, estimates=[SimpleNamespace(gain_relative_sd=0.005)])
    drive = Drive(**{"gain": 35.0, "lag": 1e-3, "relative_sd": 0.005, **given})
    axis = replace(load_axis("emps2015"), drive=drive)
    with refuses("other-saved-drive", says) if says else nullcontext():
        refuse_other_drive(cast(Any, held), "result.json", axis)


def test_the_start_of_a_found_lag_is_part_of_the_drive() -> None:
    found = WrittenDriveTime(
        name="Tc", of="lag", nominal=1e-4, value=1e-3, sd=1e-5, interval_95=(9e-4, 1.1e-3)
    )
    written = WrittenResponse(lag=1e-3, delay=0.0, logged="command", estimated=found)
    held = SimpleNamespace(drive=written, estimates=[SimpleNamespace(gain_relative_sd=0.0)])
    for lag, is_same in ((1e-4, True), (1e-3, True), (5e-4, False)):
        parameter = Parameter("Tc", "s", nominal=lag)
        axis = replace(load_axis("emps2015"), drive=Drive(gain=35.0, lag=parameter))
        with nullcontext() if is_same else refuses("other-saved-drive", "estimated from 0.0001"):
            refuse_other_drive(cast(Any, held), "result.json", axis)
