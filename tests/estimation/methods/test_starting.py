"""Where instruments start: at least squares where its loop follows the record, or as published."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, identify, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from tests.estimation.methods.test_instrumental import white
from tests.refusals import refuses

IV = ["idm-iv", "ddm-iv"]
STARTS = ("least-squares", "nominal")


@pytest.mark.slow
def test_instruments_start_at_least_squares_and_end_where_the_published_start_does(
    library_axis: GeneratedAxis,
) -> None:
    record = twin_record(library_axis)
    found = {start: identify(library_axis, record, start=start) for start in STARTS}
    for method in (method for method in IV if method in found["nominal"]):
        here, there = (found[start][method] for start in STARTS)
        deviations = np.sqrt(np.diag(here.covariance))
        assert np.abs(here.physical - there.physical).max() <= 1e-4 * deviations.max()
        assert here.started == "least-squares"
        assert here.iterates[0].physical == pytest.approx(found["nominal"]["idm-ls"].physical)
        assert len(here.iterates) <= len(there.iterates)
        if library_axis.is_linear:
            assert there.started == "nominal"
            assert there.iterates[0].physical.tolist() == library_axis.nominal.tolist()


def test_least_squares_whose_loop_does_not_follow_is_no_start_and_it_is_said(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """Noise of 0.2 mm leaves least squares a tenth of the mass."""
    rng = np.random.default_rng(3)
    noisy = replace(twin, position=twin.position + rng.normal(0.0, 2e-4, len(twin)))
    result = identify(emps2015, noisy)
    for method in IV:
        estimate = result[method]
        assert estimate.started == "nominal"
        assert estimate.iterates[0].physical.tolist() == emps2015.nominal.tolist()
        (said,) = [str(r) for r in estimate.remarks if "starts from the nominal values" in str(r)]
        assert "least squares" in said
    assert result["ddm-iv"].physical == pytest.approx(result["idm-iv"].physical, rel=1e-6)


@pytest.mark.parametrize("start", ["best", 3, None])
def test_another_start_is_refused(emps2015: GeneratedAxis, twin: Record, start: object) -> None:
    with refuses("method", says=r"choose from least-squares, nominal"):
        identify(emps2015, twin, start=start)  # type: ignore[arg-type]


def test_the_nominal_values_serve_where_least_squares_leads_to_no_end() -> None:
    """A white reference: from least squares the first iterate's loop diverges."""
    axis, record = white("belt_axis", 1e-3, 0, noisy=True)
    found, usual = (
        identify(axis, record, methods=["idm-iv"], start=start)["idm-iv"] for start in STARTS
    )
    assert found.started == "nominal"
    assert "comes to no end" in str(found.remarks[0])
    assert found.physical.tolist() == usual.physical.tolist()
