"""The drive as generated functions, and that nothing else makes a force of a control."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from axisid import build, derive, load_axis
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import feed_forward
from axisid.codegen.printers.python import print_python
from axisid.modeling import LIBRARY
from tests.axes.drives import BRAKE, braked
from tests.axes.lagging import TRUTH, lagging
from tests.recipes import recipe_blocks


def states(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    first, q, dq = rng.normal(size=(3, 50))
    return 20 * first, q, dq


@pytest.mark.parametrize("name", LIBRARY)
def test_control_that_makes_a_force_makes_it(name: str, rng: np.random.Generator) -> None:
    axis = build(load_axis(name), native=False)
    control, q, dq = states(rng)
    beside = [rng.normal(size=len(q)) for _ in axis.axis.signals]
    force = axis.evaluate("drive_force", control, q, dq, *beside)[0][:, 0]
    np.testing.assert_array_equal(force, axis.axis.drive.gain * control)
    # What the gain does to an estimate has no rounding of its own then.
    np.testing.assert_array_equal(axis.force_by_gain(control, q, dq, beside), force)
    back = axis.evaluate("drive_control", force, q, dq, *beside)[0][:, 0]
    np.testing.assert_allclose(back, control, rtol=1e-15)


@pytest.mark.parametrize("native", [False, True])
def test_force_by_the_motion_is_generated_too(
    emps2015: GeneratedAxis, native: bool, rng: np.random.Generator
) -> None:
    axis = build(braked(emps2015.declared), native=native)
    control, q, dq = states(rng)
    force = axis.evaluate("drive_force", control, q, dq)[0][:, 0]
    slope = axis.force_by_gain(control, q, dq)
    np.testing.assert_array_equal(slope, axis.axis.drive.gain * control)
    np.testing.assert_allclose(force, slope - BRAKE * dq, rtol=1e-13)
    back = axis.evaluate("drive_control", force, q, dq)[0][:, 0]
    np.testing.assert_allclose(back, control, rtol=1e-12, atol=1e-12)


def test_the_recipes_drive_makes_the_force_that_it_says(rng: np.random.Generator) -> None:
    names: dict[str, Any] = {"__name__": "recipe"}
    (recipe,) = recipe_blocks("Add a drive")
    exec(recipe, names)
    drive = names["Magnet"](gain=-3.0, unit="A", relative_sd=0.01)
    axis = build(replace(load_axis("emps2015"), drive=drive), native=False)
    control, q, dq = states(rng)
    force = axis.evaluate("drive_force", control, q, dq)[0][:, 0]
    np.testing.assert_allclose(force, -3.0 * control * np.abs(control), rtol=1e-15)
    back = axis.evaluate("drive_control", force, q, dq)[0][:, 0]
    np.testing.assert_allclose(back, control, rtol=1e-14)
    np.testing.assert_allclose(axis.force_by_gain(control, q, dq), force, rtol=1e-15)


def test_an_exported_control_goes_over_the_dead_band() -> None:
    declared = lagging(deadband=0.3)
    export = feed_forward(derive(declared), {name: (x, "") for name, x in TRUTH.items()})
    made: dict[str, Any] = {}
    exec(print_python(export), made)  # what the program printed
    for motion in ((0.0, 0.1, 0.5), (0.0, -0.1, -0.5), (0.0, 0.0, 0.0)):
        force, control = (made[name](*motion) for name in export.functions)
        assert control == pytest.approx(force / 35.0 + 0.3 * np.sign(force))
    assert "over the dead band of 0.3" in export.control.summary
