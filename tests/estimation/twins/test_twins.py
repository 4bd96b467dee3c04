"""What twins tell of an estimate is what records of one machine scatter by."""

import numpy as np
import pytest

from axisid import identify, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis

METHODS = ["idm-ls", "idm-iv", "didim"]


@pytest.mark.slow
def test_what_several_parameters_make_together_is_as_sure_as_it_scatters(
    emps2015: GeneratedAxis,
) -> None:
    """Friction at 0.1 m/s: noise of the position moves viscous and Coulomb against each other."""
    away: dict[str, list[float]] = {method: [] for method in METHODS}
    told: dict[str, list[float]] = {method: [] for method in METHODS}
    by = np.array([0.0, 0.1, 1.0])
    for seed in range(8):
        record = twin_record(emps2015, seed=seed, position_noise=3e-5)
        truth = np.array([*record.provenance.truth.values()])
        for method, estimate in identify(emps2015, record, methods=METHODS).estimates.items():
            away[method].append(float(by @ (estimate.corrected - truth)))
            told[method].append(float(np.sqrt(by @ estimate.covariance @ by)))
    for method in METHODS:
        scatter = float(np.sqrt(np.mean(np.square(away[method]))))
        assert 0.4 < np.mean(told[method]) / scatter < 2.5


@pytest.mark.slow
def test_no_disturbance_is_simulated_that_is_not_there(emps2015: GeneratedAxis) -> None:
    for seed in range(4):
        record = twin_record(emps2015, seed=seed, position_noise=3e-5)
        (chain,) = identify(emps2015, record, methods="idm-iv").preferred.inference.chains
        assert not chain.likeliest.disturbances
        assert chain.likeliest.position == pytest.approx(3e-5, rel=0.05)
