"""A study that takes little: the paper's axis along a short way."""

from functools import cache
from typing import Any

from axisid import Prefilter, build, load_axis, monte_carlo
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation import MonteCarlo
from axisid.modeling.declaration import Move

MOVES = (
    Move(distance=0.1, speed=0.3, acceleration=3.0),
    Move(distance=-0.1, speed=0.2, acceleration=2.0),
)
FILTER = Prefilter(cutoff=60.0, decimate=10)


@cache
def axis() -> GeneratedAxis:
    return build(load_axis("emps2015"))


def study(runs: int = 4, methods: Any = ("idm-ls", "idm-iv"), **how: Any) -> MonteCarlo:
    """A study of some twins along a short way."""
    return monte_carlo(axis(), runs, methods, **{"prefilter": FILTER, "moves": MOVES, **how})


@cache
def judged() -> MonteCarlo:
    """One with a verdict, of all kinds of parameters."""
    return study(10, ("ddm-ls", "idm-iv"), checks=1)
