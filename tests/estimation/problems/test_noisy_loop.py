"""What noise in a loop moves an output error by; nothing where it shakes nothing."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Prefilter, Record, build, identify, read_record, simulate, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.control import cascade_pd_difference
from axisid.estimation.estimates import solver_of
from axisid.estimation.identification import Identification
from axisid.estimation.problems import rows_as_measured, with_loop_noise
from axisid.estimation.problems.filter_bias import NoiseFree, noise_free_at
from benchmarks.machines import Machine, records, white

KEPT = Prefilter(reversals="keep")


def found(result: Identification) -> tuple[NoiseFree, NoiseFree]:
    """What the filter does to DIDIM, and what noise in its loop does with it."""
    estimate, problem = result["didim"], result.problem
    solver = solver_of(estimate)
    own = (estimate.form, problem, estimate.physical)
    quiet = noise_free_at(*own, solver=solver)
    assert quiet is not None
    return quiet, with_loop_noise(quiet, *own, solver)


def rows(result: Identification) -> int:
    estimate = result["didim"]
    return sum(1 for _ in rows_as_measured(estimate.form, result.problem, estimate.physical))


def test_a_record_without_noise_has_none_in_its_loop(emps2015: GeneratedAxis) -> None:
    quiet, noisy = found(
        result := identify(emps2015, twin_record(emps2015, position_noise=0.0), methods="didim")
    )
    assert not noisy.has_noise or np.allclose(noisy.bias, quiet.bias, atol=1e-9)
    assert rows(result) in (0, 8)


def test_noise_moves_little_where_it_is_small_beside_friction(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    result = identify(emps2015, twin, KEPT, "didim")
    _, noisy = found(result)
    assert noisy.has_noise
    assert noisy.hidden is not None
    assert noisy.halves is not None
    assert np.all(np.linalg.eigvalsh(noisy.hidden) > -1e-9)
    assert noisy.halves.shape == (2, len(result["didim"].y))
    assert np.all(np.abs(noisy.bias) < 0.1 * np.sqrt(np.diag(result["didim"].covariance)))
    kept = result["didim"].noise_free
    assert kept is not None
    assert not kept.has_noise, "the first draw showed that it is no matter"


@pytest.mark.slow
def test_noise_is_told_with_its_sign_and_about_its_size(emps2015: GeneratedAxis) -> None:
    """Encoder differences make much force of it: the mean of runs is off by what is told."""
    axis = build(
        replace(emps2015.axis, control=cascade_pd_difference(kp=160.18, kv=243.45, period=1e-3))
    )
    time = 1e-3 * np.arange(8000)
    waves = 0.02 * np.sin(2 * np.pi * 0.3 * time) + 0.004 * np.sin(2 * np.pi * 1.1 * time)
    reference = np.minimum(1.0, time / 0.5) * waves
    told, off = [], []
    for size in (1e-6, 3e-6):
        machine = Machine(mass=100.2, viscous=236.9, coulomb=24.8, position_noise=white(size))
        runs = [
            identify(axis, read_record(columns, axis), KEPT, "didim")
            for columns in records(machine, reference, 6, seed=3)
        ]
        told.append(float(np.mean([found(run)[1].bias[1] for run in runs])))
        off.append(float(np.mean([run["didim"].physical[1] - 236.9 for run in runs])))
    assert off[1] > 2
    assert told[1] == pytest.approx(off[1], rel=0.3)
    assert 0 <= told[0] < 0.5 * told[1]


def test_an_encoders_steps_are_no_noise(emps2015: GeneratedAxis, twin: Record) -> None:
    assert twin.reference is not None
    loop = simulate(emps2015, [100.2, 236.9, 24.8], twin.reference, 1e-3, resolution=2e-5)
    coarse = replace(twin, position=loop.measured_position, control=loop.control)
    result = identify(build(emps2015.axis), coarse, KEPT, "didim")
    quiet, noisy = found(result)
    assert noisy is quiet
    assert rows(result) == 10, "one for each place where the steps may begin"
