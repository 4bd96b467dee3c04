"""How the estimates of the paper's tables are distributed."""

from pathlib import Path

import pytest

from axisid.paper.study import (
    DISTRIBUTION_FILES,
    distributions_document,
    run_distributions,
    write_distributions,
)
from axisid.presentation.blocks import plain_text


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
