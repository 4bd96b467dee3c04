"""Generated functions compute what the symbolic model says."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import sympy
from hypothesis import given, strategies as st

from axisid import build, derive, load_axis
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.modeling import LIBRARY
from axisid.modeling.declaration.drive import Drive
from axisid.modeling.derivation.model import AxisModel
from axisid.modeling.quantities.names import RESERVED
from axisid.modeling.quantities.symbols import DIRECTION, FORCE
from axisid.support.errors import Missing

NUMBERS = st.one_of(st.just(0.0), st.floats(-1e3, 1e3, allow_nan=False))
POSITIVE = st.floats(1e-3, 1e3)
#: Axes whose direct model is not linear in parameters, so that nothing is mapped.
NOT_LINEAR_DIRECTLY = {"crank", "linear_motor"}
MOTION = st.tuples(st.floats(-10, 10), NUMBERS, NUMBERS, st.floats(-1, 1))
# What cancels in a column or a force, as a share of what is added up; nothing does in the EMPS.
CANCELLED = {"emps2015": 0.0, "emps": 0.0}


@cache
def model_of(name: str) -> AxisModel:
    return derive(load_axis(name))


@cache
def axis_of(name: str) -> GeneratedAxis:
    return build(load_axis(name))


@cache
def evaluator(name: str, what: str) -> Callable[..., list[float]]:
    """SymPy's own evaluation in floating point, apart from our lowering."""
    model = model_of(name)
    q, parameters = model.axis.coordinate, [p.symbol for p in model.axis.parameters]
    third = q.acceleration if what in ("force", "idm") else FORCE
    expressions = {
        "force": [model.force],
        "idm": list(model.idm.columns),
        "acceleration": [model.acceleration],
        "ddm": [] if isinstance(model.ddm, Missing) else list(model.ddm.regressor.columns),
    }[what]
    arguments = [q.symbol, q.velocity, third, DIRECTION, *model.axis.signal_symbols, *parameters]
    return sympy.lambdify(arguments, expressions, "math")  # type: ignore[no-any-return]


@pytest.mark.slow
@pytest.mark.parametrize("name", LIBRARY)
@given(motion=MOTION, data=st.data())
def test_functions_equal_the_symbolic_model_at_random_points_and_at_zero(
    name: str, motion: tuple[float, ...], data: st.DataObject
) -> None:
    model, axis = model_of(name), axis_of(name)
    theta = [data.draw(POSITIVE if i == 0 else NUMBERS) for i in range(len(axis.parameters))]
    beside = [data.draw(NUMBERS) for _ in axis.axis.signals]
    still, motion = motion[:2], (*motion, *beside)

    row, known = axis.evaluate("idm_regressor", *motion)
    lost = CANCELLED.get(name, 1e-10) * (1 + np.abs(motion).max() ** 2)
    assert row.ravel() == pytest.approx(
        evaluator(name, "idm")(*motion, *theta), rel=1e-12, abs=lost
    )
    (force,) = axis.evaluate("inverse_dynamics", *motion, theta)
    added = np.abs(row.ravel() * theta).sum() + np.abs(known).sum()
    lost = CANCELLED.get(name, 1e-10) * (1 + added)
    expected = evaluator(name, "force")(*motion, *theta)
    assert force.ravel() == pytest.approx(expected, rel=1e-12, abs=lost)
    assert row.ravel() @ theta + known.ravel() == pytest.approx(
        force.ravel(), rel=1e-9, abs=1e-9 + 1e-12 * added
    )
    (acceleration,) = axis.evaluate("direct_dynamics", *motion, theta)
    push, rest = (
        axis.evaluate("direct_dynamics", *still, f, 0.0, *beside, theta)[0] for f in (1.0, 0.0)
    )
    lost = 1e-9 + 1e-10 * added * np.abs(push - rest).max()
    expected = evaluator(name, "acceleration")(*motion, *theta)
    assert acceleration.ravel() == pytest.approx(expected, rel=1e-9, abs=lost)
    if isinstance(model.ddm, Missing):
        return
    row, known = axis.evaluate("ddm_regressor", *motion)
    lost = CANCELLED.get(name, 1e-10) * (1 + np.abs(motion).max() ** 2)
    assert row.ravel() == pytest.approx(
        evaluator(name, "ddm")(*motion, *theta), rel=1e-12, abs=lost
    )
    theta_ddm, _ = axis.mapped("ddm_from_physical", theta)
    assert row.ravel() @ theta_ddm + known.ravel() == pytest.approx(
        acceleration.ravel(), rel=1e-9, abs=1e-9 * np.abs(row.ravel() * theta_ddm).sum() + 1e-300
    )


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
        for name, function in axis.functions.items():
            if name != "drive_response":  # which takes no name of a user's beside its own
                assert {*function.name_in(), *function.name_out()} - motion <= RESERVED
