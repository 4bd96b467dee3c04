"""A fresh library's functions are called once before it is used.

Each has one point, at which the virtual machine says what is expected: enough to see a compiler or
a library that does not serve on this machine. That what is generated is right, for any axis and
anywhere, is the affair of the tests.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from axisid.support.arrays import Array

from .compiler import NativeUnavailableError
from .library import NativeLibrary

_PERIOD = 1e-3
#: Of a size, or of what a change of all arguments by `_LITTLE` moves, up to which results agree.
_ALLOWED, _LITTLE, _MAGNIFIED = 1e-9, 1e-15, 1e3


def check_values(library: NativeLibrary, functions: Mapping[str, Any], text: str) -> None:
    """Call each function of a C text, and compare with the virtual machine.

    Raises
    ------
    NativeUnavailableError
        One computes wrong values.
    """
    for name, function in functions.items():
        if f"void {name}_rows(" not in text:
            continue
        point = _point(function)
        wanted, moved = (
            [out.full().ravel() for out in function.call([scale * x for x in point])]
            for scale in (1.0, 1 + _LITTLE)
        )
        for found, here, there in zip(library.evaluate(name, point), wanted, moved, strict=True):
            with np.errstate(invalid="ignore"):
                near = _ALLOWED * (1 + np.abs(here)) + _MAGNIFIED * np.abs(there - here)
                wrong = ~(np.abs(found[0] - here) <= near) & np.isfinite(near)
            if wrong.any():
                raise NativeUnavailableError(f"the compiled {name} computes wrong values")


def _point(function: Any) -> list[Array]:
    """Arguments about 1, of either side, and a step of a sampling period."""
    rng = np.random.default_rng(0)
    scales = {"step": _PERIOD, "sides": 0.0}
    names = function.name_in()
    sizes = {name: rng.uniform(0.5, 1.5, function.size1_in(name)) for name in names}
    return [scales.get(name, 1.0) * sizes[name] + (name == "sides") for name in names]
