"""What keeps an integral from running away."""

import pytest
import sympy

from axisid.control import integral
from axisid.modeling.declaration import gain
from axisid.modeling.quantities import LIMITED_OUTPUT, PERIOD, UNLIMITED_OUTPUT

E, INTEGRAL = sympy.symbols("e integral", real=True)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("error", "after"), [(1.0, 10.0), (-1.0, 9.0)])
def test_a_clamped_integral_stands_still_where_it_drives_the_output_further(
    sign: int, error: float, after: float
) -> None:
    """Whatever the sign of its gain: beyond the limit only an error that leads back is added."""
    output = gain("ki") * INTEGRAL
    memory = integral(E, output, anti_windup="clamping")
    values = {gain("ki"): 2.0 * sign, E: error, INTEGRAL: 10.0, PERIOD: 1.0}
    outputs = {LIMITED_OUTPUT: 5.0 * sign, UNLIMITED_OUTPUT: 20.0 * sign}
    assert memory.following.subs(values | outputs) == pytest.approx(after)
