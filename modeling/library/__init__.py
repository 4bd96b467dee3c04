"""Library of axes: one module per axis, with the `Axis` in the variable ``axis``.

In: a name. Out: the `Axis` of that name. Knows nothing of derived models.
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
    """Return the library axis with a name out of `LIBRARY`."""
    axis: Axis = import_module(f"{__name__}.{name}").axis
    return axis
