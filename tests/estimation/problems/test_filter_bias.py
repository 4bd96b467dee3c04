"""What the prefilter alone does to an estimate, found on the simulated loop."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Identification,
    Prefilter,
    Record,
    build,
    identify,
    load_axis,
    sweep,
    twin_record,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.checks import Check
from axisid.estimation.diagnostics.estimates.filter_bias import filter_bias
from axisid.estimation.estimates import Value
from axisid.estimation.methods import METHODS
from axisid.support.arrays import Array


@pytest.fixture(scope="module")
def valve() -> Identification:
    """A twin that reverses so often that no reversal can be left out."""
    axis = build(load_axis("valve"))
    return identify(axis, twin_record(axis))


def _truth(result: Identification) -> Array:
    truth = result.record.provenance.truth or {}
    return np.array([truth[name] for name in result.axis.names])


KEPT = Prefilter(reversals="keep")  # where the filter moves estimates most


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("hold", ["zoh", "raw"])
def test_on_a_noise_free_twin_it_is_the_whole_error(
    emps2015: GeneratedAxis, method: str, hold: str
) -> None:
    prefilter = Prefilter(hold=hold)  # type: ignore[arg-type]
    record = twin_record(emps2015, position_noise=0.0)
    estimate = identify(emps2015, record, prefilter, [method])[method]
    error = estimate.physical - np.array([100.2, 236.9, 24.8])
    assert estimate.filter_bias == pytest.approx(error, rel=0.2, abs=0.02)


def test_intervals_hold_the_truth_since_they_are_less_it(emps2015: GeneratedAxis) -> None:
    """By instruments, under the default filter, where those about the value miss the mass."""
    held = {"about the value": 0, "given": 0}
    for seed in range(20):
        record = twin_record(emps2015, seed=seed)
        mass = identify(emps2015, record, KEPT, "idm-iv")["idm-iv"].parameters["M"]
        assert mass.filter_bias is not None
        low, high = mass.interval
        assert (low + high) / 2 == pytest.approx(mass.corrected, rel=1e-12)
        held["about the value"] += low < 100.2 - mass.filter_bias < high
        held["given"] += low < 100.2 < high
    assert held["about the value"] < 5
    assert held["given"] > 17


def test_direct_parameters_and_functions_are_less_it_too(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    estimate = identify(emps2015, twin)["ddm-iv"]
    M, Fv, Fc = estimate.corrected
    expected = [1 / M, Fv / M, Fc / M]
    corrected = [value.corrected for value in estimate.ddm_parameters.values()]
    assert corrected == pytest.approx(expected, rel=1e-9)
    assert estimate.derive("Fv/M").corrected == pytest.approx(Fv / M, rel=1e-5)
    drawn = estimate.propagate("M")
    mass = estimate.parameters["M"]
    assert drawn.median == pytest.approx(mass.corrected, abs=0.05 * mass.sd_hac)


def test_it_is_not_told_without_a_loop(emps2015: GeneratedAxis, twin: Record) -> None:
    alone = identify(emps2015, replace(twin, reference=None), methods="idm-ls")
    assert alone["idm-ls"].filter_bias is None
    assert alone["idm-ls"].parameters["M"].filter_bias is None
    (check,) = (c for c in alone.verdict if c.name == "filter bias")
    assert check.status == "not evaluated"


def test_check_and_notes_name_what_is_moved(emps2015: GeneratedAxis, twin: Record) -> None:
    result = identify(emps2015, twin, KEPT)
    (check,) = (c for c in result.verdict if c.name == "filter bias")
    assert check.status == "note"  # 0.1 % of the mass, and the intervals are free of it
    assert "moves M by +0.1" in check.meaning
    lines = result.summary().splitlines()
    (place,) = (
        i for i, line in enumerate(lines) if line.startswith("M  ") and "IDM" in lines[i - 2]
    )
    corrected = [f"{result[m].parameters['M'].corrected:.4f}" for m in ("idm-ls", "idm-iv")]
    assert lines[place + 1].split() == ["without", "filter", "bias", *corrected]
    low, high = result["idm-iv"].parameters["M"].interval
    assert low < result["idm-iv"].parameters["M"].corrected < high
    moved = result["idm-iv"].derive("M/Fv").filter_bias
    mass, viscous = (result["idm-iv"].parameters[n] for n in ("M", "Fv"))
    assert mass.filter_bias is not None
    assert viscous.filter_bias is not None
    expected = (mass.value + mass.filter_bias) / (viscous.value + viscous.filter_bias)
    assert moved == pytest.approx(expected - mass.value / viscous.value, rel=1e-2)


def test_a_correction_that_the_corrected_loop_confirms_is_no_fault(valve: Identification) -> None:
    """The mass is moved by 2 %, and its interval holds the truth."""
    estimate, truth = valve.preferred, valve.record.provenance.truth
    mass, quiet = estimate.parameters["m"], estimate.noise_free
    assert truth is not None
    assert quiet is not None
    assert quiet.again is not None
    assert mass.shift > 3
    assert mass.interval[0] < truth["m"] < mass.interval[1]
    assert estimate.physical - quiet.again == pytest.approx(_truth(valve), rel=0.02)
    (check,) = (c for c in valve.verdict if c.name == "filter bias")
    assert check.status == "note"
    assert "as the loop at the corrected values confirms" in check.meaning
    assert str(check.note).endswith("raise the cut-off")  # leaving out would hide the mass


def test_a_correction_that_is_another_at_the_corrected_values_is_one(
    valve: Identification,
) -> None:
    estimate, quiet = valve.preferred, valve.preferred.noise_free
    assert quiet is not None
    for again in (2 * quiet.bias, None):
        doubtful = replace(estimate, noise_free=replace(quiet, again=again))
        check = filter_bias(doubtful, has_reversals=True)
        assert isinstance(check, Check)
        assert check.status == "fail"
        assert "leave out the reversals" in str(check.note)


def test_residuals_are_free_of_the_filter_where_it_moves_the_estimate_too(
    valve: Identification,
) -> None:
    """Loops of an estimate that is 2 % off leave something else behind the filter."""
    estimate = valve.preferred
    tests = estimate.residual_tests
    assert estimate.net_residuals.std() < 0.03 * estimate.residuals.std()
    assert tests.cross_z <= tests.cross_limit
    (check,) = (c for c in valve.verdict if c.name == "normal residuals")
    assert tests.excess_kurtosis > 6  # of what noise there is at reversals, a fortieth of all
    assert check.status == "note"


def test_force_column_and_partially_known_models_are_taken_alike(twin: Record) -> None:
    axis = load_axis("emps2015")
    assert twin.control is not None
    measured = replace(twin, force=35.15 * twin.control)
    by_force = identify(axis, measured, Prefilter(hold="zoh"), "idm-iv")["idm-iv"]
    by_control = identify(axis, twin, Prefilter(hold="zoh"), "idm-iv")["idm-iv"]
    assert by_force.filter_bias == pytest.approx(by_control.filter_bias, rel=1e-9)


def test_sweep_recommends_where_it_is_small(emps2015: GeneratedAxis, twin: Record) -> None:
    result = sweep(emps2015, twin, (20.0, 40.0, 80.0, 160.0), methods=["idm-ls", "idm-iv"])
    assert "prefilter's own bias" in result.reason


@pytest.mark.parametrize(
    ("bias", "shown"), [(0.6, True), (0.4, False), (0.0, False), (None, False)]
)
def test_a_printed_value_says_what_its_interval_is_about_where_that_is_not_the_value(
    bias: float | None, *, shown: bool
) -> None:
    value = Value(
        value=10.0, unit="kg", deviations={"hac": 1.0}, interval=(7.4, 11.4), filter_bias=bias
    )
    assert ("(9.4 without filter bias)" in str(value)) is shown
    assert str(value).startswith("10 +- 1 kg")
    assert str(value).endswith("95 %: 7.4 to 11.4 kg")


def test_residuals_of_a_sensed_force_are_free_of_the_filter_too(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """A sensor sees the mean of what is held before and after a sample."""
    assert twin.control is not None
    held = emps2015.axis.drive.gain * twin.control
    sensed = replace(twin, force=(held + np.append(held[:1], held[:-1])) / 2)
    estimate = identify(emps2015, sensed, methods="idm-iv")["idm-iv"]
    assert estimate.residual_tests.cross_z <= estimate.residual_tests.cross_limit
    assert estimate.filter_bias == pytest.approx(np.zeros(3), abs=0.5)
