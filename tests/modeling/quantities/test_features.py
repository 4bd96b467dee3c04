"""Places at which functions change are found, however narrow they are."""

import mpmath
import pytest
import sympy

from axisid.modeling.quantities.features import crossings, features_of

GRID = [mpmath.mpf(x) for x in (-1e5, -1e3, -30, -3, -1, -0.3, 0, 0.3, 1, 3, 30, 1e3, 1e5)]
q = sympy.Symbol("q", real=True)


@pytest.mark.parametrize(
    ("value", "places"),
    [
        (lambda x: x - 737.25, [737.25]),
        (lambda x: (x - mpmath.mpf("0.37")) ** 2 - mpmath.mpf("1e-12"), [0.369999, 0.370001]),
        (lambda x: (x + 2) ** 2, [-2]),
        (lambda x: x**2 + 1, []),
        (lambda x: mpmath.sign(x - 5), [5]),
        (lambda x: x**3 - 8, [2]),
        (lambda x: mpmath.nan if x < 0 else x - 4, [4]),
    ],
)
def test_crossings_are_found_between_and_beside_the_grid(value, places) -> None:  # type: ignore[no-untyped-def]
    with mpmath.workdps(50):
        found = crossings(value, GRID)
    assert list(map(float, found)) == pytest.approx(places, rel=1e-12)


def test_features_are_told_by_kind() -> None:
    smooth = [f for f in features_of(sympy.tanh(q) + sympy.sin(q)) if not f.sharp]
    assert {f.node.func: f.needed for f in smooth} == {sympy.tanh: True, sympy.sin: False}
    (kink,) = features_of(sympy.Abs(q - 1))
    assert kink.sharp
    assert kink.needed
    assert len(list(features_of(sympy.Max(q, 1, -q)))) == 3
    assert not list(features_of(q**2 + sympy.sqrt(2) * q))
