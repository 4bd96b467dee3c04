"""Several outputs, and several records, of one machine and of others."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, build, fit, load_axis, twin_record
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.diagnostics.pooling_findings import ComparedRecords
from axisid.estimation.model_validation import validate_fit
from axisid.estimation.output_error import OutputFit
from axisid.estimation.records import record_labels
from axisid.presentation.plots import output_plot
from tests.estimation.output_error.fits import TRUTH, off
from tests.refusals import refuses
from tests.verdicts import checks_of, finding_of

BOTH = ("control", "position")


@pytest.fixture(scope="module")
def both(emps2015: GeneratedAxis, twin: Record) -> OutputFit:
    return fit(emps2015, twin, BOTH)


@pytest.mark.slow
def test_each_output_counts_by_what_is_left_of_it(both: OutputFit) -> None:
    assert both.outputs == BOTH
    assert both.predictions.units == ("V", "m")
    for each in both.of_records:
        assert each.weight * each.error == pytest.approx(1.0, rel=0.02)
        assert each.noise == pytest.approx(each.error, rel=0.1)
    assert np.abs(off(both)).max() < 3
    assert both.believed
    assert both.output == "control and position"
    assert both.percent_beyond_noise < 5
    assert both.error == both.of_records[0].error


@pytest.mark.slow
def test_the_errors_of_a_record_have_a_column_for_each_output(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    found = fit(emps2015, [twin, twin], ("position", "control"), rests="keep")
    assert [each.output for each in found.of_records] == ["position", "control"] * 2
    for record, errors in enumerate(found.errors):
        assert errors.shape == (len(twin), 2)
        told = [each.error for each in found.of_records[2 * record :][:2]]
        np.testing.assert_allclose(np.sqrt(np.mean(errors**2, axis=0)), told)
    panels = output_plot(found, 1).panels
    assert len(panels) == 4
    np.testing.assert_allclose(panels[3].series[0].y, found.errors[1][:, 1])


@pytest.mark.slow
def test_an_output_alone_is_a_fit_of_it(emps2015: GeneratedAxis, twin: Record) -> None:
    alone, listed = fit(emps2015, twin), fit(emps2015, twin, ["control", "control"])
    np.testing.assert_array_equal(listed.physical, alone.physical)
    assert listed.errors[0].shape == (len(twin),)
    # What counts for nothing beside the other is as good as left out.
    heavy = fit(emps2015, twin, BOTH, weights={"control": 1e3, "position": 1.0})
    np.testing.assert_allclose(heavy.physical, alone.physical, rtol=1e-5)
    # Of twins with noise too, which know a deviation to 10 %, where that is more.
    ratio = heavy.deviations / alone.deviations
    assert np.all((ratio > 0.95) & (ratio < 1.2))


@pytest.mark.slow
def test_a_weight_that_is_given_is_the_one(
    emps2015: GeneratedAxis, twin: Record, both: OutputFit
) -> None:
    found = fit(emps2015, twin, BOTH, weights={"position": 1e4})
    assert found.of_records[1].weight == 1e4
    assert found.of_records[0].weight * found.of_records[0].error == pytest.approx(1.0, rel=0.02)
    control = fit(emps2015, twin)
    assert abs(found["Fv"].value - control["Fv"].value) < abs(
        both["Fv"].value - control["Fv"].value
    )


@pytest.mark.slow
def test_a_record_is_held_against_one_of_the_outputs(emps2015: GeneratedAxis, twin: Record) -> None:
    both = fit(emps2015, twin, BOTH, rests="keep")
    for output, left in zip(BOTH, both.of_records, strict=True):
        assert validate_fit(both, twin, output=output).error == pytest.approx(left.error, rel=1e-6)
    assert validate_fit(both, twin).output == "control"
    with refuses("method"):
        validate_fit(both, twin, output="force")


def _records(axis: GeneratedAxis, *changes: dict[str, float]) -> list[Record]:
    """Twins, each of a machine with some parameters changed."""
    declared, experiment = axis.declared, axis.declared.experiment
    return [
        twin_record(
            replace(declared, experiment=replace(experiment, truth={**experiment.truth, **each})),
            seed=seed,
        )
        for seed, each in enumerate(changes)
    ]


@pytest.mark.slow
@pytest.mark.parametrize("output", ["control", "position"])
def test_a_payload_that_nobody_told_is_named_with_its_size(
    emps2015: GeneratedAxis, output: str
) -> None:
    records = _records(emps2015, {"M": 100.0}, {"M": 105.0}, {"M": 100.0})
    found = fit(emps2015, records, output)
    check = checks_of(found)["records alike"]
    assert check.status == "fail"
    finding = finding_of(check, ComparedRecords)
    assert finding.odd is not None
    mass = finding.odd.parameters[0]
    assert finding.odd.name == record_labels(records)[1]
    assert (mass.name, mass.unit, mass.is_load) == ("M", "kg", True)
    assert (mass.own, mass.common) == pytest.approx((105.0, 100.0), abs=0.3)


@pytest.mark.slow
def test_of_two_records_one_is_told_beside_the_other_and_what_lets_them_differ(
    emps2015: GeneratedAxis,
) -> None:
    records = _records(emps2015, {}, {"Fc": 26.0})
    check = checks_of(fit(emps2015, records))["records alike"]
    assert check.status == "fail"
    finding = finding_of(check, ComparedRecords)
    assert finding.odd is not None
    (friction,) = finding.odd.parameters
    assert friction.name == "Fc"
    assert sorted((friction.own, friction.common)) == pytest.approx([24.8, 26.0], abs=0.3)
    own = fit(emps2015, records, local="Fc")
    assert own.local == {"Fc": ("Fc_1", "Fc_2")}
    truth = {"M": 100.2, "Fv": 236.9, "Fc_1": 24.8, "Fc_2": 26.0}
    assert np.abs(off(own, truth)).max() < 4
    assert own["M"].deviation < 0.9 * fit(emps2015, records[0])["M"].deviation
    assert checks_of(own)["records alike"].status == "pass"
    assert own.believed
    assert pickle.loads(pickle.dumps(own)).checks == own.checks  # noqa: S301


@pytest.mark.slow
@pytest.mark.parametrize("output", ["control", "position", BOTH])
def test_intervals_hold_the_truth_as_often_as_they_say(output: str) -> None:
    """95 % within what 50 runs leave to chance, each once back and forth at three speeds."""
    declared, held = load_axis("emps2015"), []
    moves = declared.experiment.moves
    once = replace(declared.experiment, moves=moves[: len(moves) // 3])
    axis = build(replace(declared, experiment=once))
    for seed in range(50):
        result = fit(axis, twin_record(axis, seed=seed), output, start=TRUTH)
        intervals = [(*result[name].interval, truth) for name, truth in TRUTH.items()]
        held.append([low <= truth <= high for low, high, truth in intervals])
    assert np.all(np.mean(held, axis=0) >= 0.86)
