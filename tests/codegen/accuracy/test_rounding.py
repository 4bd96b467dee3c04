"""Running error bounds: they hold, they are not idle, and they know where nothing can be told."""

import casadi
import mpmath
import numpy as np
import pytest

from axisid.codegen.accuracy.rounding import rounding_bounds

X, Y = casadi.SX.sym("x"), casadi.SX.sym("y")
CASES = {
    "cancellation": (X + 1e8 - Y - 1e8, lambda x, y: x + 10**8 - y - 10**8),
    "power": ((X - 2) ** 12, lambda x, _: (x - 2) ** 12),
    "multiplied out": (
        X**3 - 6 * X**2 + 12 * X - 8,
        lambda x, _: x**3 - 6 * x**2 + 12 * x - 8,
    ),
    "fast wave": (casadi.sin(3000 * X) * Y, lambda x, y: mpmath.sin(3000 * x) * y),
    "quotient": (X / (Y * Y + 0.1), lambda x, y: x / (y * y + mpmath.mpf(0.1))),
    "root": (casadi.sqrt(X * X + Y * Y), lambda x, y: mpmath.sqrt(x * x + y * y)),
}


@pytest.mark.parametrize("name", CASES)
def test_bounds_hold_against_fifty_digits_and_are_not_idle(
    name: str, rng: np.random.Generator
) -> None:
    expression, exact = CASES[name]
    function = casadi.Function("f", [X, Y], [expression])
    points = rng.uniform(-3, 3, (2, 1, 200))
    points[0, 0, 100:] = 2 + 1e-3 * points[0, 0, 100:]
    (bound,) = rounding_bounds(function, points)
    with mpmath.workdps(50):
        truth = [exact(*map(mpmath.mpf, point)) for point in points[:, 0].T]
        values = function(*points).full()[0]
        off = np.array([float(abs(v - t)) for v, t in zip(values, truth, strict=True)])
    assert np.all(off <= bound[:, 0])
    assert np.median(bound[:, 0]) < 100 * max(np.median(off), 1e-15 * np.median(np.abs(values)))


@pytest.mark.parametrize(
    ("expression", "at", "known"),
    [
        (casadi.sign(X + 1 - Y), (0.5, 1.5), False),
        (casadi.sign(X - Y), (0.5, 1.5), True),
        (casadi.if_else(X * 3 < Y, X, -X), (0.1, 0.30000000000000004), False),
        (casadi.if_else(X < Y, X, -X), (0.1, 0.3), True),
        (casadi.sqrt(X * X - Y * Y), (0.3, 0.3), False),
        (casadi.sign(casadi.sqrt(X)), (-1.0, 0.0), False),
        (casadi.sqrt(X), (-1.0, 0.0), True),
        (casadi.exp(X * Y), (709.782712893384 / 3, 3.0), False),
        (casadi.exp(X), (800.0, 0.0), True),
    ],
)
def test_results_that_rounding_decides_of_are_known(
    expression: casadi.SX, at: tuple[float, float], known: bool
) -> None:
    function = casadi.Function("f", [X, Y], [expression])
    (bound,) = rounding_bounds(function, [np.array([[value]]) for value in at])
    size = abs(float(function(*at)))
    told = bound[0, 0] <= 1e-12 * size if np.isfinite(size) and size else bound[0, 0] == 0
    assert told == known


def test_outputs_come_element_by_element_row_by_row() -> None:
    matrix = casadi.vertcat(casadi.horzcat(X, 2 * X), casadi.horzcat(0, Y))
    function = casadi.Function("f", [X, Y], [matrix, Y * Y * Y])
    first, second = rounding_bounds(function, [np.array([[1.0, 10.0]]), np.array([[3.0, 3.0]])])
    assert first.shape == (2, 4)
    assert second.shape == (2, 1)
    assert np.all(first[:, [0, 2, 3]] == 0)
    assert np.all(second > 0)
