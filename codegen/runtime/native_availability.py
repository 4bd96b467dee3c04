"""Native functions of an axis: compiled on demand and checked, or unavailable for a reason.

Arguments and results are memory of NumPy arrays; a contiguous array of floats is not copied. Time
is the first axis of every array, lanes (simulations of a batch) the second. Without native code,
the CasADi virtual machine computes the same functions.
"""

import contextlib
import warnings
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from axisid.codegen.printers import has_known_part, print_c_lanes, with_loop_header
from axisid.support.arrays import Array

from .batched_rows import LaneLibrary
from .library import NativeLibrary
from .library_cache import NativeUnavailableError, cached_library, compiled_library

_PERIOD = 1e-3  # s; the step of the test point
#: Tolerance of the check of values: `_ALLOWED` times (1 + size of the value), plus `_MAGNIFIED`
#: times the change of the value if all arguments change by the factor 1 + `_LITTLE`.
_ALLOWED, _LITTLE, _MAGNIFIED = 1e-9, 1e-15, 1e3


def check_values(library: NativeLibrary, functions: Mapping[str, Any], text: str) -> None:
    """Compare each function of a compiled C text with the virtual machine at one point.

    Parameters
    ----------
    library : NativeLibrary
    functions : mapping of str to casadi.Function
        The same functions in the virtual machine, by name.
    text : str
        The C text; functions that are not in it are not checked.

    Raises
    ------
    NativeUnavailableError
        A function computes wrong values.
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
    """Return the arguments of a function at a test point: about 1, steps about 1 ms, sides 1."""
    rng = np.random.default_rng(0)
    scales = {"step": _PERIOD, "sides": 0.0}
    names = function.name_in()
    sizes = {name: rng.uniform(0.5, 1.5, function.size1_in(name)) for name in names}
    return [scales.get(name, 1.0) * sizes[name] + (name == "sides") for name in names]


_MOTION = 4  # arguments of the inverse model without recorded signals


class Native:
    """The native library of an axis, compiled when it is first needed.

    Parameters
    ----------
    text : str
        C source.
    functions : mapping of str to casadi.Function
        The same functions in the virtual machine, by name.
    enabled : bool
        True if native code may be used; otherwise the virtual machine computes everything.
    gains : (g,) array, optional
        Gains of the law, for functions with gains as an argument; in the time loop they follow the
        parameters.

    Attributes
    ----------
    enabled : bool
    text : str
        The C source, with the time loop that it includes.
    refusal : str
        Reason why native code is unavailable; empty as long as no reason is known.
    """

    def __init__(
        self,
        text: str,
        functions: Mapping[str, Any],
        *,
        enabled: bool = True,
        gains: Array | None = None,
    ) -> None:
        """Store the C source and the functions; nothing is compiled or loaded yet.

        Parameters are those of the class.
        """
        self.enabled = enabled
        self._gains = gains
        #: The C source, with the time loop that it includes.
        self.text = with_loop_header(text)
        self._functions = functions
        #: Reason why native code is unavailable, once it is known.
        self.refusal = "" if enabled else "it was switched off"
        self._library: NativeLibrary | None = None
        self._to_warn = enabled
        self._looked = False

    def library(self) -> NativeLibrary | None:
        """Return the library, compiled now if it is not cached; None if it is unavailable."""
        if self._library is None and not self.refusal:
            try:
                self._library = NativeLibrary(
                    compiled_library(self.text, self._check), self._functions, self._gains
                )
            except (NativeUnavailableError, OSError) as error:
                self.refusal = str(error)
        return self._library

    def _check(self, path: Path) -> None:
        """Load a freshly compiled library and compare its values with the virtual machine.

        Raises
        ------
        NativeUnavailableError
            The library cannot be loaded, or computes wrong values.
        """
        try:
            fresh = NativeLibrary(path, self._functions)
        except OSError as error:
            # An OSError would be taken for an error of the cache folder, with another instruction.
            raise NativeUnavailableError(
                f"the compiled library cannot be loaded: {error}"
            ) from error
        check_values(fresh, self._functions, self.text)

    @cached_property
    def lanes(self) -> LaneLibrary | None:
        """Compiled functions for the regression rows of many simulations side by side.

        None if they are unavailable, or if the axis has recorded signals.
        """
        if self._functions["idm_regressor"].n_in() != _MOTION or self.library() is None:
            return None
        count = self._functions["direct_dynamics"].size1_in("parameters")
        with contextlib.suppress(NativeUnavailableError, OSError):
            return LaneLibrary(
                compiled_library(print_c_lanes(self.text, count)),
                count,
                known=has_known_part(self.text),
            )
        return None

    def warn_once(self) -> None:
        """Warn once that the virtual machine is used instead of native code, with the reason."""
        if self.refusal and self._to_warn:
            self._to_warn = False
            warnings.warn(
                f"no native code: {self.refusal}. The CasADi virtual machine simulates instead, "
                "which is slower.",
                RuntimeWarning,
                stacklevel=3,
            )

    def evaluator(self, function: str) -> NativeLibrary | None:
        """Return the library if it is loaded or in the cache, and has a function; otherwise None.

        Nothing is compiled.
        """
        if self._library is None and not self.refusal and not self._looked:
            self._looked = True
            path = cached_library(self.text)
            if path is not None:
                with contextlib.suppress(OSError):
                    self._library = NativeLibrary(path, self._functions, self._gains)
        library = self._library
        return None if library is None or not library.has(function) else library
