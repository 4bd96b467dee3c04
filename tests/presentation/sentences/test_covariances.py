"""What is said of standard errors has every number of their note, and nothing else."""

import pytest

from axisid.estimation.regression import CovarianceNote
from axisid.presentation.sentences import (
    covariance_in_short,
    covariance_text,
    iid_text,
    shared_covariance_text,
)

HAC = CovarianceNote(kind="hac", lags=7, lag_rule="plug-in", is_prewhitened=True, is_corrected=True)


def replicas(count: int, *noise: str) -> CovarianceNote:
    return CovarianceNote(kind="hac", lags=9, lag_rule="given", replicas=count, noise=noise)


@pytest.mark.parametrize(
    ("note", "parts"),
    [
        (CovarianceNote(kind="published", degrees=41), ["i.i.d.", "n - 1 = 41"]),
        (CovarianceNote(kind="classical"), ["i.i.d.", "n - k"]),
        (CovarianceNote(kind="robust", is_corrected=True), ["robust", "times n/(n - k)"]),
        (HAC, ["prewhitened", "7 lags (plug-in rule)", "times n/(n - k)"]),
        (replicas(32, "1 um of noise"), ["9 lags (as given)", "32", "1 um of noise"]),
        (replicas(32, "a", "b"), ["record 1: a", "record 2: b"]),
        (CovarianceNote(kind="ar1", is_at_least_ar1=True), ["AR(1)", "few scores"]),
        (CovarianceNote(kind="other", label="as in the file"), ["as in the file"]),
        (CovarianceNote(kind="other", label="own", is_corrected=True), ["own", "times n/(n - k)"]),
        (CovarianceNote(kind="robust", no_replicas="no loop"), ["no loop"]),
    ],
)
def test_every_number_and_reason_is_in_the_text(note: CovarianceNote, parts: list[str]) -> None:
    text = covariance_text(note)
    assert [part for part in parts if part not in text] == []


def test_methods_share_a_text_with_the_lags_of_each_and_their_own_replicas() -> None:
    other = CovarianceNote(kind="hac", lags=12, lag_rule="given", no_replicas="no loop")
    text = shared_covariance_text({"idm-iv": replicas(32, "noise"), "idm-ls": other})
    assert "9 lags (as given) for IDM-IV, 12 lags (as given) for IDM-LS" in text
    assert "IDM-IV: the standard errors are calibrated with 32 simulated replicas" in text
    assert "have this noise: noise" in text
    assert "IDM-LS: the standard errors are not calibrated" in text
    assert "no loop" in text
    assert "IDM-IV" not in shared_covariance_text({"idm-iv": HAC, "didim": HAC})


def test_the_iid_text_has_the_degrees_of_freedom() -> None:
    assert "n - 1 = 41" in iid_text(CovarianceNote(kind="published", degrees=41))
    assert "as in the file" in iid_text(CovarianceNote(kind="other", label="as in the file"))


def test_in_short_there_are_replicas_or_why_there_are_none() -> None:
    assert "32 simulated replicas" in covariance_in_short(replicas(32, "noise"))
    assert "no loop" in covariance_in_short(CovarianceNote(kind="hac", no_replicas="no loop"))
    assert covariance_in_short(HAC) == "HAC"
