"""A fit held against another record: frozen parameters, windows that start where that record is."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from axisid import Record, build, fit, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.control import cascade_pd
from axisid.estimation import OutputFit, validate_fit
from tests.refusals import refuses

TRUTH = {"M": 100.2, "Fv": 236.9, "Fc": 24.8}


@pytest.fixture(scope="module")
def other(emps2015: GeneratedAxis) -> Record:
    return twin_record(emps2015, seed=7)


@pytest.fixture(scope="module")
def opened(emps2015: GeneratedAxis, twin: Record) -> OutputFit:
    return fit(emps2015, twin, "open-loop", start=TRUTH, horizon=1.0)


def test_its_own_record_is_left_what_the_fit_left(opened: OutputFit, twin: Record) -> None:
    found = validate_fit(opened, twin)
    assert found.error == pytest.approx(opened.error, rel=1e-6)
    assert found.percent == pytest.approx(opened.error_percent, rel=1e-6)
    # What noise moved the parameters by is taken off them, and makes hardly any of the errors.
    np.testing.assert_allclose(found.errors, opened.errors[0], atol=2e-3 * opened.error)
    np.testing.assert_array_equal(found.samples, opened.samples[0])
    assert found.horizon == opened.horizon == 1.0
    assert found.windows[-1].stop == len(found.errors)


def test_another_record_has_no_part_in_the_parameters(opened: OutputFit, other: Record) -> None:
    """The noise is all that is left of a twin, of whatever length the windows are."""
    for horizon in (0.5, 3.0):
        found = validate_fit(opened, other, horizon=horizon)
        assert found.horizon == horizon
        assert found.error == pytest.approx(3.8e-6, rel=0.05)


def test_wrong_parameters_leave_more(
    emps2015: GeneratedAxis, twin: Record, other: Record, opened: OutputFit
) -> None:
    wrong = fit(emps2015, twin, "open-loop", start=TRUTH, horizon=1.0, fixed={"Fc": 25.8})
    lost, held = (validate_fit(each, other) for each in (wrong, opened))
    assert lost.error > 5 * held.error
    assert held.believed


def test_a_loop_is_simulated_along_the_whole_record(
    emps2015: GeneratedAxis, twin: Record, other: Record
) -> None:
    followed = fit(emps2015, twin, "control", start=TRUTH, rests="keep")
    assert validate_fit(followed, twin).error == pytest.approx(followed.error, rel=1e-6)
    found = validate_fit(followed, other)
    assert found.horizon is None
    assert found.error == pytest.approx(followed.error, rel=0.05)
    with refuses("fit"):
        validate_fit(followed, other, horizon=1.0)


@pytest.mark.parametrize("horizon", [0.0, float("nan"), "long"])
def test_a_horizon_is_a_positive_time(opened: OutputFit, twin: Record, horizon: Any) -> None:
    with refuses("fit"):
        validate_fit(opened, twin, horizon=horizon)


def test_a_record_of_another_axis_is_told_by_what_it_shows(
    emps2015: GeneratedAxis, twin: Record, other: Record
) -> None:
    """By its law, its sample period and its signals; a record of the axis tells nothing of it."""
    followed = fit(emps2015, twin, "control", start=TRUTH)
    assert validate_fit(followed, other).notes == ()
    stiffer = twin_record(
        build(replace(emps2015.axis, control=cascade_pd(kp=200.0, kv=243.45, period=1e-3)))
    )
    assert validate_fit(followed, other).belief == "believed"
    found = validate_fit(followed, stiffer)
    assert found.belief == "not believed"
    (said,) = found.notes
    assert "not the law's" in said
    assert "kp" in said
    slower = validate_fit(followed, twin_record(emps2015, sample_period=2e-3)).notes
    assert "every 0.002 s, and what was fitted every 0.001 s" in slower[0]
    pressed = replace(other, signals={"pressure": np.ones(len(other.time))})
    with refuses("validation", "pressure"):
        validate_fit(followed, pressed)


@pytest.mark.slow
def test_parameters_of_each_record_are_no_others(
    emps2015: GeneratedAxis, twin: Record, other: Record
) -> None:
    local = fit(emps2015, [twin, other], "open-loop", start="nominal", local="Fc")
    with refuses("validation"):
        validate_fit(local, other)
