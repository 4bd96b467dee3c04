"""Generated functions compute what the symbolic model says."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import sympy
from hypothesis import given, strategies as st

from axisid import build, load_axis
from axisid.codegen.generated_axes import law_functions
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.modeling import LIBRARY
from axisid.modeling.declaration.drive import Drive
from axisid.modeling.quantities.names import RESERVED

POSITIVE = st.floats(1e-3, 1e3)
#: Axes whose direct model is not linear in parameters, so that nothing is mapped.
NOT_LINEAR_DIRECTLY = {"crank", "linear_motor"}


@cache
def axis_of(name: str) -> GeneratedAxis:
    return build(load_axis(name))


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted({*LIBRARY} - NOT_LINEAR_DIRECTLY))
@given(data=st.data())
def test_parameter_maps_are_inverse_to_each_other_and_so_are_their_jacobians(
    name: str, data: st.DataObject
) -> None:
    axis = axis_of(name)
    values = st.floats(-300, 300)
    theta = [data.draw(POSITIVE if i == 0 else values) for i in range(len(axis.parameters))]
    theta_ddm, forward = axis.mapped("ddm_from_physical", theta)
    back, backward = axis.mapped("physical_from_ddm", theta_ddm)
    assert back == pytest.approx(theta, rel=1e-12)
    size = np.abs(backward) @ np.abs(forward)
    assert np.abs(backward @ forward - np.eye(len(theta))).max() <= 1e-12 * size.max()


@pytest.mark.slow
def test_signature_follows_the_declaration_not_the_number_type() -> None:
    axis = load_axis("emps")
    marks = {
        build(replace(axis, drive=Drive(gain=gain, limit=10.0))).signature
        for gain in (35, 35.0, np.float64(35), sympy.Integer(35))
    }
    assert len(marks) == 1
    assert build(axis).signature == build(axis).signature
    assert build(replace(axis, title="other")).signature != build(axis).signature


def test_every_argument_and_result_of_a_function_is_a_reserved_name() -> None:
    """So that no coordinate can bear it."""
    for axis in map(axis_of, LIBRARY):
        motion = {str(s) for s in (axis.axis.coordinate.symbol, axis.axis.coordinate.velocity)}
        motion.add(str(axis.axis.coordinate.acceleration))
        motion |= {f"{name}_next" for name in motion} | {s.name for s in axis.axis.signals}
        of_law = law_functions(axis.axis.control, axis.axis.signal_symbols)
        for name, function in (*axis.functions.items(), *of_law.items()):
            if name != "drive_response":  # which takes no name of a user's beside its own
                assert {*function.name_in(), *function.name_out()} - motion <= RESERVED
