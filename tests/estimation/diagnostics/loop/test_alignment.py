"""The delay between force and motion, on twins whose delay is known and on the real record."""

import re
from dataclasses import replace

import numpy as np
import pytest

from axisid import Prefilter, Record, build, identify, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.diagnostics.loop.alignment import Alignment, estimate_delay

FINE = Prefilter(cutoff=180.0, decimate=3, drop=(50, 50))


def delay_of(axis: GeneratedAxis, record: Record, prefilter: Prefilter) -> Alignment:
    """The delay by least squares, of a record that tells it."""
    return estimate_delay(axis, record, prefilter)


def test_held_force_of_a_noise_free_twin_is_half_a_sample_late(emps2015: GeneratedAxis) -> None:
    record = twin_record(emps2015, position_noise=0.0)
    assert delay_of(emps2015, record, FINE).best == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize("early", [-1, 1, 2])
def test_whole_samples_of_delay_are_found(emps2015: GeneratedAxis, early: int) -> None:
    """A control that is written down early has to be taken from earlier rows."""
    record = twin_record(emps2015, position_noise=0.0)
    shifted = replace(record, control=np.roll(record.control, -early))
    best = delay_of(emps2015, shifted, FINE).best
    assert best == pytest.approx(0.5 + early, abs=0.05)


def test_real_record_moves_viscous_friction_by_four_and_a_half_per_half_sample(
    emps: GeneratedAxis, emps_record: Record
) -> None:
    found = delay_of(emps, emps_record, Prefilter(cutoff=100.0, drop=(49, 0), reversals="keep"))
    assert 0.1 < found.best < 0.5
    assert found.sensitivity[1] / 2 == pytest.approx(4.4, abs=0.2)


@pytest.mark.slow
def test_deviation_of_the_delay_is_the_scatter_of_its_estimates(emps2015: GeneratedAxis) -> None:
    record = twin_record(emps2015, position_noise=0.0)
    rng = np.random.default_rng(8)
    found = []
    for _ in range(60):
        noise = rng.normal(0.0, 1.0, len(record))
        noisy = replace(record, control=record.control + noise)
        found.append(delay_of(emps2015, noisy, Prefilter()))
    scatter = float(np.std([p.best for p in found], ddof=1))
    assert np.mean([p.deviation for p in found]) == pytest.approx(scatter, rel=0.3)


@pytest.mark.slow
def test_delay_beyond_the_range_is_said_to_be_there(emps2015: GeneratedAxis) -> None:
    record = twin_record(emps2015, position_noise=0.0)
    late = replace(record, control=np.roll(record.control, -5))
    found = delay_of(emps2015, late, FINE)
    assert found.at_the_end
    (check,) = (
        c for c in identify(emps2015, late, FINE, "idm-ls").verdict if c.name == "alignment"
    )
    assert check.status == "fail"
    assert "best 3 samples, the end" in check.meaning


@pytest.mark.slow
@pytest.mark.parametrize(
    ("declared", "says"),
    [
        (1e-3, r"is 0.00\d* s too long: declare none"),
        (3e-3, r"is 0.00[23]\d* s too long: declare none"),
        (2e-2, r"is at least .*: declare .* or less"),
    ],
)
def test_a_declared_delay_that_is_not_there_is_said_to_be_too_long(
    emps2015: GeneratedAxis, twin: Record, declared: float, says: str
) -> None:
    axis = emps2015.axis
    late = build(replace(axis, drive=replace(axis.drive, delay=declared)))
    verdict = {c.name: c for c in identify(late, twin, methods="idm-ls").verdict}
    assert verdict["alignment"].status == "fail"
    assert re.search(says, verdict["alignment"].meaning)
    assert verdict["missing terms"].status != "fail"


@pytest.mark.slow
def test_delay_that_the_record_does_not_tell_is_not_judged(emps2015: GeneratedAxis) -> None:
    record = twin_record(emps2015, position_noise=0.0)
    noise = np.random.default_rng(8).normal(0.0, 30.0, len(record))
    noisy = replace(record, control=record.control + noise)
    verdict = identify(emps2015, noisy, methods="idm-ls").verdict
    (check,) = (c for c in verdict if c.name == "alignment")
    assert check.status == "not evaluated"
    assert "samples only" in check.meaning
