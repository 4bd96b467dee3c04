"""Least squares and instrumental variables against independent solutions."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, strategies as st

from axisid import Prefilter
from axisid.estimation import delta_method
from axisid.estimation.regression.linear import factor, instrumental_variables, least_squares
from axisid.estimation.signals import SampledFilter
from tests.refusals import refuses

NAMES = ["a", "b", "c"]


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
            "3 rows are left for 3",
            lambda y, X: least_squares(y[:3], factor(X[:3], NAMES)),
        ),
        ("not-finite", "", lambda _, X: factor(X * [1, np.inf, 1], NAMES)),
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


def test_orthogonal_instruments_are_refused() -> None:
    X = np.repeat([[1.0], [-1.0]], 10, axis=0)
    with refuses("not-shown", says="instruments together with the record"):
        instrumental_variables(X[:, 0], factor(X, ["a"]), factor(np.ones_like(X), ["a"]))


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
        says=rf"^the regressor of the log reaches {largest} in the columns of {named}, whose",
    ):
        factor(X, NAMES, "the log")


def test_delta_method_is_exact_for_linear_maps(rng: np.random.Generator) -> None:
    root, J = rng.normal(size=(3, 3)), rng.normal(size=(2, 3))
    mapped = delta_method(root @ root.T, J)
    assert mapped == pytest.approx(J @ root @ root.T @ J.T)
    assert np.array_equal(mapped, mapped.T)
