"""The paper's twin: what least squares and instruments make of noise inside the loop."""

from pathlib import Path

import numpy as np
import pytest

from axisid import Identification
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.paper import (
    DISTRIBUTION_FILES,
    distributions_document,
    run_distributions,
    run_study,
    study_document,
    write_distributions,
)
from axisid.presentation.documents import blocks_html, plain_text

Study = dict[str, Identification]


@pytest.fixture(scope="module")
def study() -> Study:
    return run_study()


def test_one_noise_level_gives_the_errors_of_tables_1_and_6_at_once(study: Study) -> None:
    assert f"{study['appropriate']['idm-ls'].equation_error_percent:.1f}" == "4.9"
    assert 50 < study["inappropriate"]["idm-ls"].physical[0] < 60
    for result in study.values():  # instruments hold the mass
        assert result["idm-iv"].physical[0] == pytest.approx(100.2, rel=0.01)


@pytest.mark.parametrize("method", ["ddm-ls", "ddm-iv"])
def test_delta_method_agrees_with_monte_carlo(
    emps2015: GeneratedAxis, study: Study, method: str
) -> None:
    estimate = study["appropriate"][method]
    rng = np.random.default_rng(2000)
    draws = rng.multivariate_normal(estimate.theta_ddm, estimate.ddm_covariances["iid"], 2000)
    mapped = np.array([emps2015.mapped("physical_from_ddm", draw)[0] for draw in draws])
    sampled = np.std(mapped, axis=0, ddof=1)
    assert np.sqrt(np.diag(estimate.covariances["iid"])) == pytest.approx(sampled, rel=0.05)


@pytest.mark.slow
def test_study_prints_the_eight_tables_with_published_and_own_figures(study: Study) -> None:
    text = plain_text(study_document(study))
    assert blocks_html(study_document(study)).count("<table>") == 8
    for published in ("54.9", "234.9", "48.7", "24.4", "4.64"):
        assert published in text
    assert "theta1 is then at most 0.0139, and the M of table 8 at least 72" in " ".join(
        text.split()
    )


def without(columns: np.ndarray, others: np.ndarray) -> np.ndarray:
    """What a regression on other columns leaves."""
    left: np.ndarray = columns - others @ np.linalg.lstsq(others, columns, rcond=None)[0]
    return left


def test_inverse_mass_times_direct_theta1_is_the_squared_partial_correlation(study: Study) -> None:
    for result in study.values():
        inverse, direct = result["idm-ls"], result["ddm-ls"]
        force, acceleration = without(
            np.column_stack([inverse.y, inverse.X[:, 0]]), inverse.X[:, 1:]
        ).T
        squared = (force @ acceleration) ** 2 / (force @ force) / (acceleration @ acceleration)
        assert inverse.physical[0] * direct.theta[0] == pytest.approx(squared, rel=1e-9)
        most = 1 - (inverse.equation_error_percent / 100) ** 2
        assert squared <= most < 1


@pytest.mark.slow
def test_least_squares_is_biased_where_the_filter_lets_noise_through(tmp_path: Path) -> None:
    found = run_distributions(6)
    wrong = found["inappropriate"]
    assert wrong.of("idm-ls", "M").raw_bias.value < -30  # kg of 100
    assert abs(wrong.of("idm-ls", "M").bias.value) < 1
    assert abs(wrong.of("idm-iv", "M").bias.value) < 1
    assert abs(found["appropriate"].of("idm-ls", "M").bias.value) < 1
    text = plain_text(distributions_document(found))
    assert "6 twins, inappropriate filter, 180 Hz" in text
    assert {path.name for path in write_distributions(found, tmp_path)} == set(DISTRIBUTION_FILES)
