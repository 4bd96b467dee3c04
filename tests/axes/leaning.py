"""A load on a slope, whose angle enters nonlinearly; one slope does not tell its weight."""

from functools import cache

import sympy

from axisid import Coordinate, Parameter, build, load_axis, newton
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis


@cache
def leaning() -> GeneratedAxis:
    """Weight and offset, which two angles tell apart."""
    mass, weight, offset, angle = (
        Parameter("m", "kg", nominal=1.0),
        Parameter("w", "N"),
        Parameter("f0", "N"),
        Parameter("angle", "rad", nominal=0.1),
    )
    base = load_axis("emps2015")
    return build(
        newton(
            "leaning",
            coordinate=Coordinate("q"),
            parameters=(mass, weight, offset, angle),
            inertia=mass,
            resistance=(weight * sympy.sin(angle.symbol) + offset.symbol,),
            drive=base.drive,
            control=base.control,
        )
    )
