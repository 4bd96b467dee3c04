"""Axes that ship: one module each, each with one `Axis` named ``axis``.

In: a name. Out: its `Axis`. Knows nothing of what is derived of it.
"""

from importlib import import_module

from axisid.modeling.declaration.axis import Axis

#: Names of the library's axes, in the order of tables.
LIBRARY = (
    "emps2015",
    "emps",
    "pendulum",
    "vertical_screw",
    "belt_axis",
    "rotary_table",
    "valve",
    "crank",
    "linear_motor",
    "balanced_slide",
    "servo_joint",
)


def library_axis(name: str) -> Axis:
    """Return the library axis of one of the names."""
    axis: Axis = import_module(f"{__name__}.{name}").axis
    return axis
