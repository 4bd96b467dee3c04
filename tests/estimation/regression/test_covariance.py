"""Least squares, instruments and covariances against statsmodels, linearmodels, NIST's digits."""

from collections.abc import Callable

import numpy as np
import pytest
import statsmodels.api as sm
from hypothesis import given, strategies as st
from linearmodels.iv import IV2SLS
from scipy import stats
from scipy.signal import lfilter
from statsmodels.stats.sandwich_covariance import S_hac_simple

from axisid import Prefilter
from axisid.estimation import delta_method
from axisid.estimation.regression import hotelling_p_value
from axisid.estimation.regression.covariance import (
    Classical,
    Hac,
    PublishedCovariance,
    Robust,
    lags_of,
    plug_in_lags,
)
from axisid.estimation.regression.linear import (
    CovarianceEstimate,
    Solution,
    factor,
    instrumental_variables,
    least_squares,
)
from axisid.estimation.signals import RowTimes, SampledFilter
from axisid.estimation.thresholds import MAX_AUTOREGRESSION
from tests.estimation.nist import FILIP, LONGLEY, NORRIS, PONTIUS, Dataset
from tests.refusals import refuses

NAMES = ("a", "b", "c")


@pytest.fixture
def data(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Autocorrelated, heteroscedastic residuals and endogenous regressors of unlike sizes."""
    n = 400
    shocks = rng.normal(size=n)
    e = np.zeros(n)
    for i in range(1, n):
        e[i] = 0.7 * e[i - 1] + shocks[i]
    Z = rng.normal(size=(n, 3))
    e *= 1 + 0.5 * np.abs(Z[:, 0])
    X = (Z + 0.3 * rng.normal(size=(n, 3)) + 0.2 * e[:, None]) * [1.0, 100.0, 1e-3]
    return X @ [1.0, 0.02, 3e3] + e, X, Z * [1.0, 100.0, 1e-3]


def by_ls(data: tuple[np.ndarray, ...]) -> Solution:
    return least_squares(data[0], factor(data[1], NAMES))


def test_classical_and_robust_are_those_of_statsmodels(data: tuple[np.ndarray, ...]) -> None:
    y, X, _ = data
    ols = sm.OLS(y, X)
    solution = by_ls(data)
    assert solution.theta == pytest.approx(ols.fit().params, rel=1e-9)
    assert Classical().matrix(solution) == pytest.approx(ols.fit().cov_params(), rel=1e-7)
    published = PublishedCovariance().matrix(solution)
    assert published == pytest.approx(Classical().matrix(solution) * 397 / 399, rel=1e-9)
    hc1 = ols.fit(cov_type="HC1").cov_params()
    assert Robust().matrix(solution) == pytest.approx(hc1, rel=1e-7)
    for covariance in (PublishedCovariance(), Classical(), Robust()):
        assert covariance.applied(solution).freedom.tolist() == 3 * [ols.fit().df_resid]


@pytest.mark.parametrize("lags", [0, 1, 7, 30])
def test_hac_is_that_of_statsmodels(data: tuple[np.ndarray, ...], lags: int) -> None:
    y, X, _ = data
    options = {"maxlags": lags, "use_correction": True}
    expected = sm.OLS(y, X).fit(cov_type="HAC", cov_kwds=options).cov_params()
    assert Hac(lags).matrix(by_ls(data)) == pytest.approx(expected, rel=1e-7)


def test_instrumental_variables_are_those_of_linearmodels(data: tuple[np.ndarray, ...]) -> None:
    y, X, Z = data
    model = IV2SLS(y, None, X, Z)
    solution = instrumental_variables(y, factor(X, NAMES), factor(Z, NAMES))
    cases = {
        "unadjusted": (Classical(), {}),
        "robust": (Robust(), {}),
        "kernel": (Hac(7), {"kernel": "bartlett", "bandwidth": 7}),
    }
    for kind, (covariance, options) in cases.items():
        result = model.fit(cov_type=kind, debiased=True, **options)
        assert solution.theta == pytest.approx(result.params.to_numpy(), rel=1e-9)
        assert covariance.matrix(solution) == pytest.approx(result.cov.to_numpy(), rel=1e-7)


def long_run(
    scores: np.ndarray, hac: Hac | None = None, missing: float = 0.0
) -> CovarianceEstimate:
    """Of scores (n, k), of which a part is missing."""
    kept = np.random.default_rng(0).random(len(scores)) >= missing
    order = RowTimes.consecutive(len(scores))[kept]
    return (hac or Hac()).long_run(scores[kept], order)


def whitened(scores: np.ndarray, hac: Hac | None = None) -> tuple[int, np.ndarray]:
    """Lags that count of scores (n, k), and their autoregression."""
    chosen = hac or Hac()
    white, colour = chosen.whitened(scores, RowTimes.consecutive(len(scores)))
    lags = plug_in_lags(white, len(scores)) if chosen.lags is None else chosen.lags
    return lags, colour


def autoregressive(rng: np.random.Generator, rows: int, kept: float) -> np.ndarray:
    return lfilter([1.0], [1.0, -kept], rng.normal(size=(rows, 1)), axis=0)


@pytest.mark.parametrize("kept", [-0.5, 0.3, 0.9])
def test_the_plug_in_rule_is_that_of_andrews_for_an_autoregression(kept: float) -> None:
    asked = 1.1447 * (4 * kept**2 / (1 - kept**2) ** 2 * 5000) ** (1 / 3)
    assert lags_of(list(kept ** np.arange(400.0)), 5000) == int(asked)


@pytest.mark.parametrize("kept", [-0.8, 0.0, 0.5, 0.9])
def test_long_run_of_an_autoregression_is_what_theory_says(
    rng: np.random.Generator, kept: float
) -> None:
    rows = 200_000
    scores = autoregressive(rng, rows, kept)
    assert whitened(scores)[1] == pytest.approx([kept], abs=0.01)
    assert long_run(scores).matrix[0, 0] / rows == pytest.approx(1 / (1 - kept) ** 2, rel=0.06)


def test_scores_are_whitened_by_their_own_autocorrelation(rng: np.random.Generator) -> None:
    """Of each parameter by itself, away from a root of one; scores that are 0 have none."""
    scores = rng.normal(size=(400, 4)).cumsum(axis=0)
    scores[:, 1] = rng.normal(size=400)
    scores[1:, 2] = scores[1:, 1] - 0.6 * scores[:-1, 1]
    scores[:, 3] = 0.0
    _, colour = Hac().whitened(scores, RowTimes.consecutive(400))
    own = np.array([s[1:] @ s[:-1] / (s @ s) for s in scores[:, 1:3].T])
    assert own[1] < -0.3
    assert colour[1:3] == pytest.approx(own, abs=1e-12)
    assert (colour[0], colour[3]) == (MAX_AUTOREGRESSION.value, 0.0)


def test_whitened_products_are_those_of_whitened_scores(rng: np.random.Generator) -> None:
    scores = np.cumsum(rng.normal(size=(300, 2)), axis=0)
    found, (lags, colour) = long_run(scores), whitened(scores)
    padded = np.vstack([np.zeros((1, 2)), scores, np.zeros((1, 2))])
    white = padded[1:] - colour * padded[:-1]
    assert max(colour) == 0.97  # it would else recolour without end
    expected = sum(
        (1 - abs(lag) / (lags + 1))
        * white[max(lag, 0) : len(white) + min(lag, 0)].T
        @ white[max(-lag, 0) : len(white) + min(-lag, 0)]
        for lag in range(-lags, lags + 1)
    )
    gain = 1 / (1 - colour)
    assert found.matrix == pytest.approx(expected * np.outer(gain, gain), rel=1e-9)


@pytest.mark.parametrize("kept", [0.0, 0.6, 0.9])
def test_freedom_is_that_of_the_scatter_of_the_variance(kept: float) -> None:
    rng = np.random.default_rng(5)
    found = [long_run(autoregressive(rng, 1000, kept)) for _ in range(600)]
    variances = np.array([each.matrix[0, 0] for each in found])
    scatter = 2 * variances.mean() ** 2 / variances.var()
    assert np.median([each.freedom[0] for each in found]) == pytest.approx(scatter, rel=0.35)


@pytest.mark.parametrize("lags", [0, 1, 7, 30])
def test_missing_rows_count_as_rows_without_a_score(
    data: tuple[np.ndarray, ...], rng: np.random.Generator, lags: int
) -> None:
    """As Parzen has it: against statsmodels, with zeros in place of what is missing."""
    places = np.flatnonzero(rng.random(500) < 0.8)[:300]
    kept = tuple(each[: len(places)] for each in data)
    solution = least_squares(kept[0], factor(kept[1], NAMES, neighbours=RowTimes(places)))
    scores = np.zeros((places[-1] + 1, 3))
    scores[places] = solution.influence * solution.residuals[:, None]
    expected = len(places) / (len(places) - 3) * S_hac_simple(scores, nlags=lags)
    assert Hac(lags).matrix(solution) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("dataset", "digits"),
    [(FILIP, 7.5), (LONGLEY, 10.5), (NORRIS, 12.0), (PONTIUS, 12.0)],
    ids=["Filip", "Longley", "Norris", "Pontius"],
)
def test_least_squares_reaches_the_certified_digits(dataset: Dataset, digits: float) -> None:
    names = [f"b{i}" for i in range(dataset.X.shape[1])]
    solution = least_squares(dataset.y, factor(dataset.X, names))
    deviations = np.sqrt(np.diag(Classical().matrix(solution)))
    for got, certified in ((solution.theta, dataset.values), (deviations, dataset.deviations)):
        error = np.abs(got / np.array(certified) - 1).max()
        assert -np.log10(max(error, 1e-16)) >= digits


@pytest.mark.parametrize("lags", [5, 400])
@pytest.mark.parametrize("missing", [False, True])
def test_products_of_rows_with_gaps_are_those_of_the_pairs(
    rng: np.random.Generator, lags: int, missing: bool
) -> None:
    n = 9_000
    scores = lfilter([1.0], [1.0, -0.9], rng.standard_normal((n, 2)), axis=0)
    places = np.cumsum(rng.choice([1, 1, 3, 2000], n)) if missing else np.arange(n)
    order = RowTimes(places)
    found = order.autocovariances(scores, lags)
    for lag in (0, 1, 3, lags):
        late, early = order.pairs(lag)
        pairs = scores[late].T @ scores[early]
        assert found[lag] == pytest.approx(pairs, rel=0, abs=1e-12 * np.abs(found[0]).max())


@pytest.mark.parametrize("freedom", [3.7, 40.0, 900.0])
def test_one_parameter_is_students_test(freedom: float) -> None:
    expected = 2 * stats.t.sf(2.3, freedom)
    for one_variance in (False, True):
        found = hotelling_p_value(2.3**2, 1, freedom, one_variance=one_variance)
        assert found == pytest.approx(expected, rel=1e-9)
    three = hotelling_p_value(9.0, 3, freedom, one_variance=True)
    assert three == pytest.approx(stats.f.sf(3.0, 3, freedom))


@pytest.mark.parametrize(("restrictions", "samples"), [(2, 12), (4, 12), (4, 60)])
def test_it_rejects_as_often_as_it_says(
    rng: np.random.Generator, restrictions: int, samples: int
) -> None:
    """Means of normal samples with the covariance of the samples: Hotelling's own case."""
    drawn = rng.normal(size=(2000, samples, restrictions))
    means = drawn.mean(axis=1)
    chances = [
        hotelling_p_value(
            float(m @ np.linalg.solve(np.cov(s.T) / samples, m)), restrictions, samples - 1
        )
        for m, s in zip(means, drawn, strict=True)
    ]
    assert np.mean(np.array(chances) < 0.05) == pytest.approx(0.05, abs=0.015)


TURNING = np.repeat([[1.0], [-1.0]], 30, axis=0)  # orthogonal to what does not change


def problem(rng: np.random.Generator, n: int = 60) -> tuple[np.ndarray, np.ndarray]:
    X = rng.normal(size=(n, 3)) * [1.0, 1e4, 1e-5] + [0.5, 0.0, 1e-5]
    return X @ [3.0, -2e-4, 7e5] + 0.1 * rng.normal(size=n), X


@given(exponents=st.lists(st.integers(-12, 12), min_size=3, max_size=3))
def test_units_of_the_columns_do_not_matter(exponents: list[int]) -> None:
    y, X = problem(np.random.default_rng(1))
    scale = 10.0 ** np.array(exponents)
    assert least_squares(y, factor(X * scale, NAMES)).theta * scale == pytest.approx(
        least_squares(y, factor(X, NAMES)).theta, rel=1e-11
    )


@pytest.mark.parametrize(
    ("code", "says", "solved"),
    [
        (
            "not-shown",
            r"change of a -0\.0004, c \+1|a -0.0004",
            lambda y, X: least_squares(
                y, factor(np.column_stack([X[:, :2], 4e-4 * X[:, 0]]), NAMES)
            ),
        ),
        (
            "not-shown",
            "simulated loop",
            lambda _, X: factor(X**0, NAMES, "the simulated loop"),
        ),
        ("not-shown", "cannot show b", lambda _, X: factor(X * [1, 0, 1], NAMES)),
        (
            "too-short",
            r"3 rows are too few for 3 parameters\. .*axisid fit.*fit\(axis, record\)",
            lambda y, X: least_squares(y[:3], factor(X[:3], NAMES)),
        ),
        ("not-finite", "", lambda _, X: factor(X * [1, np.inf, 1], NAMES)),
        (
            "not-shown",
            "instruments together with the record",
            lambda y, _: instrumental_variables(
                y, factor(TURNING, ["a"]), factor(np.ones_like(TURNING), ["a"])
            ),
        ),
    ],
)
def test_what_has_no_solution_is_refused(
    rng: np.random.Generator, code: str, says: str, solved: Callable[..., object]
) -> None:
    y, X = problem(rng)
    with refuses(code, says=says):
        solved(y, X)


def test_rounding_of_filtered_columns_does_not_hide_their_dependence(
    rng: np.random.Generator,
) -> None:
    """Heavy decimation leaves few rows, and more rounding than their number would excuse."""
    q = np.cumsum(rng.normal(size=20_000))
    f = SampledFilter(Prefilter(cutoff=1.0, decimate=100, drop=(0, 0)), 1e-3)
    X = f.reduce(np.column_stack([q, q - 0.0213, np.ones_like(q)]))
    with refuses("not-shown", says="change of a"):
        factor(X, NAMES)


@pytest.mark.parametrize(
    ("sizes", "named"), [((1.0, 1e160, 1.0), "b"), ((-1e200, 1.0, 1e300), "a, c")]
)
def test_columns_whose_squares_no_number_holds_are_refused_by_name(
    rng: np.random.Generator, sizes: tuple[float, ...], named: str
) -> None:
    _, X = problem(rng)
    X = X / np.abs(X).max(axis=0) * sizes
    largest = f"{max(map(abs, sizes)):.3g}".replace("+", r"\+")
    with refuses(
        "not-finite",
        says=rf"^the regressor of the log reaches {largest} in the columns of {named}, and their",
    ):
        factor(X, NAMES, "the log")


def test_delta_method_is_exact_for_linear_maps(rng: np.random.Generator) -> None:
    root, J = rng.normal(size=(3, 3)), rng.normal(size=(2, 3))
    mapped = delta_method(root @ root.T, J)
    assert mapped == pytest.approx(J @ root @ root.T @ J.T)
    assert np.array_equal(mapped, mapped.T)
