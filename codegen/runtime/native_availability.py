"""Availability of an axis's native functions: compiled on demand and checked, or refused.

Arguments and results are memory that NumPy owns; a contiguous array of floats is not copied. Time
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

_PERIOD = 1e-3
#: Tolerance: share of a size, or of the change due to a change of all arguments by `_LITTLE`.
_ALLOWED, _LITTLE, _MAGNIFIED = 1e-9, 1e-15, 1e3


def check_values(library: NativeLibrary, functions: Mapping[str, Any], text: str) -> None:
    """Compare each function of a compiled C text with the virtual machine at one point.

    Parameters
    ----------
    library : NativeLibrary
    functions : mapping of str to casadi.Function
        The functions in the virtual machine.
    text : str
        The C text, which shows which functions are compiled.

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
    """Return a test point of a function: arguments about 1, a step of about 1 ms, sides of 1."""
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
        The same functions in the virtual machine.
    enabled : bool
        Whether native code may be used; otherwise the virtual machine computes everything.
    gains : (g,) array, optional
        Gains of the law, for functions that take them; the time loop takes them after the
        parameters.

    Attributes
    ----------
    enabled : bool
    text : str
        The C source, with the time loop that it includes.
    refusal : str
        Reason why there is no library; empty if none is known.
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
        #: Reason why there is no library, once it is known.
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
            # Other errors of this kind are due to the cache folder, and advise another folder.
            raise NativeUnavailableError(
                f"the compiled library cannot be loaded: {error}"
            ) from error
        check_values(fresh, self._functions, self.text)

    @cached_property
    def lanes(self) -> LaneLibrary | None:
        """Return the compiled functions for the regression rows of many simulations side by side.

        None if they are unavailable. They exist only for an axis without recorded signals.
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
        """Warn that the virtual machine runs instead of native code, with the reason, only once."""
        if self.refusal and self._to_warn:
            self._to_warn = False
            warnings.warn(
                f"no native code: {self.refusal}. The CasADi virtual machine simulates instead, "
                "which is slower.",
                RuntimeWarning,
                stacklevel=3,
            )

    def evaluator(self, function: str) -> NativeLibrary | None:
        """Return the library if it is loaded or cached and has a function; None otherwise.

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
