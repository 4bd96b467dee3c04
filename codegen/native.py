"""Native functions of an axis, called with NumPy arrays and the interpreter's lock released.

What goes in and out is memory that NumPy owns; a contiguous array of floats is not copied. Time is
the first axis of every array, lanes (simulations of a batch) the second.
"""

import contextlib
import ctypes
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .arguments import Array, checked_arguments
from .compiler import NativeUnavailableError, find_compiler
from .library_cache import build_library, cached_library, compiled_library
from .loop_settings import BLOCK, SIGNALS, LoopSettings
from .self_test import check_library

_SIZE, _REAL = ctypes.c_ssize_t, ctypes.c_double


class NativeLibrary:
    """A compiled axis.

    Parameters
    ----------
    path : Path
        The library. Loading executes it, so it must come from the cache.
    functions : mapping of str to casadi.Function
        The same functions in the virtual machine; their shapes are the library's.
    """

    def __init__(self, path: Path, functions: Mapping[str, Any]) -> None:
        self.path = path
        self._library = ctypes.CDLL(str(path))
        if not hasattr(self._library, "direct_dynamics_rows"):
            raise OSError(f"{path} is not the library of an axis")
        self._functions = functions

    def rows(self, function: str, arguments: Sequence[ArrayLike]) -> tuple[Array, ...]:
        """Evaluate a function at N samples: one (N, elements) array per output."""
        shapes = self._functions[function]
        given, samples = checked_arguments(function, shapes, arguments)
        outputs = tuple(np.empty((samples, shapes.numel_out(i))) for i in range(shapes.n_out()))
        call = self._library[f"{function}_rows"]
        call.restype = None
        call(_SIZE(samples), *map(_address, (*given, *outputs)))
        return outputs

    def simulate(
        self,
        reference: Array,
        noise: Array | None,
        parameters: Array,
        start: float,
        settings: LoopSettings,
    ) -> tuple[int, int, dict[str, Array]]:
        """Run one simulation.

        Returns
        -------
        status : int
            Index into `STATUSES`.
        stopped : int
            The sample that the status speaks of.
        signals : dict of str to (N,) array
            By name; not set from `stopped` on.
        """
        signals = np.empty((len(SIGNALS), len(reference)))
        stopped = _SIZE(0)
        status = self._library.simulate(
            _SIZE(len(reference)),
            *map(_address, (reference, noise, parameters)),
            _REAL(settings.period),
            _REAL(start),
            _REAL(settings.resolution),
            _REAL(settings.allowed),
            _SIZE(settings.substeps),
            *map(_address, signals),
            ctypes.byref(stopped),
        )
        return int(status), stopped.value, dict(zip(SIGNALS, signals, strict=True))

    def simulate_batch(
        self,
        reference: Array,
        noise: Array | None,
        parameters: Array,
        start: Array,
        settings: LoopSettings,
        wanted: Sequence[str],
        threads: int,
    ) -> tuple[NDArray[np.int32], NDArray[np.int64], dict[str, Array]]:
        """Run many simulations side by side.

        Parameters
        ----------
        reference : (N,) or (N, B) array
        noise : (N, B) array or None
        parameters : (B, p) array, contiguous
        start : (B,) array, contiguous
        settings : LoopSettings
        wanted : sequence of str
            Of `SIGNALS`; what is not wanted takes no memory.
        threads : int
            Lanes are shared out among so many.

        Returns
        -------
        status : (B,) array
        stopped : (B,) array
        signals : dict of str to (N, B) array
        """
        samples, lanes = len(reference), len(parameters)
        signals = {name: np.empty((samples, lanes)) for name in SIGNALS if name in wanted}
        status = np.zeros(lanes, dtype=np.int32)
        stopped = np.zeros(lanes, dtype=np.int64)
        blocks = -(-lanes // BLOCK)
        edges = [BLOCK * (blocks * i // threads) for i in range(threads)] + [lanes]

        def run(part: int) -> None:
            first, last = edges[part], edges[part + 1]
            if first == last:
                return
            self._library.simulate_batch(
                _SIZE(samples),
                _SIZE(last - first),
                *_strided(reference, first),
                *_strided(noise, first),
                _address(parameters[first:]),
                _address(start[first:]),
                _address(settings.allowed[first:]),
                _REAL(settings.period),
                _REAL(settings.resolution),
                _SIZE(settings.substeps),
                *(_address(signals[n][:, first:]) if n in signals else None for n in SIGNALS),
                _SIZE(lanes),
                _address(status[first:]),
                _address(stopped[first:]),
            )

        if threads == 1:
            run(0)
        else:
            with ThreadPoolExecutor(threads) as pool:
                list(pool.map(run, range(threads)))
        return status, stopped, signals


class Native:
    """The native library of an axis, compiled when it is first needed.

    Parameters
    ----------
    text : str
        C source.
    functions : mapping of str to casadi.Function
    enabled : bool
        False keeps to the virtual machine.
    """

    def __init__(self, text: str, functions: Mapping[str, Any], *, enabled: bool = True) -> None:
        self._text = text
        self._functions = functions
        self._library: NativeLibrary | None = None
        #: Why there is no library, once that is known.
        self.refusal = "" if enabled else "it was switched off"
        self._to_warn = enabled
        self._looked = False

    def library(self) -> NativeLibrary | None:
        """Return the library, compiling it if it is not cached; None where it cannot be had."""
        if self._library is None and not self.refusal:
            try:
                self._library = self._loaded()
            except (NativeUnavailableError, OSError) as error:
                self.refusal = str(error)
        return self._library

    def _loaded(self) -> NativeLibrary:
        path = compiled_library(self._text, self._check)
        try:
            return NativeLibrary(path, self._functions)
        except OSError:  # whole, but not for this machine: build it again
            path.unlink(missing_ok=True)
            return NativeLibrary(compiled_library(self._text, self._check), self._functions)

    def compile_afresh(self) -> None:
        """Compile and test the library in a folder of its own, cached or not.

        Raises
        ------
        NativeUnavailableError
            There is no compiler, or it fails.
        """
        with tempfile.TemporaryDirectory(prefix="axisid-") as folder:
            build_library(self._text, find_compiler(), Path(folder) / "native.so", self._check)

    def warn_once(self) -> None:
        """Say that the virtual machine runs in place of native code, and why."""
        if self.refusal and self._to_warn:
            self._to_warn = False
            warnings.warn(
                f"no native code: {self.refusal}; the CasADi virtual machine simulates, slower",
                RuntimeWarning,
                stacklevel=3,
            )

    def rows(self, function: str) -> NativeLibrary | None:
        """Return the library if it is loaded or cached and has the function; never compile."""
        if self._library is None and not self.refusal and not self._looked:
            self._looked = True
            path = cached_library(self._text)
            with contextlib.suppress(OSError):
                self._library = None if path is None else NativeLibrary(path, self._functions)
        return self._library if f"void {function}_rows(" in self._text else None

    def _check(self, path: Path) -> None:
        """Compare a fresh library with the virtual machine at random points."""
        try:
            check_library(NativeLibrary(path, self._functions), self._functions, self._text)
        except (OSError, AttributeError) as error:
            raise NativeUnavailableError(f"the compiled library does not load: {error}") from error


def _address(array: Array | NDArray[Any] | None) -> ctypes.c_void_p | None:
    return None if array is None else ctypes.c_void_p(array.ctypes.data)


def _strided(signal: Array | None, first: int) -> tuple[Any, ctypes.c_ssize_t, ctypes.c_ssize_t]:
    """Address of a signal's first lane, and its strides over time and lanes in values."""
    if signal is None:
        return None, _SIZE(0), _SIZE(0)
    over_time = _SIZE(signal.strides[0] // signal.itemsize)
    if signal.ndim == 1:
        return _address(signal), over_time, _SIZE(0)
    return _address(signal[:, first:]), over_time, _SIZE(signal.strides[1] // signal.itemsize)
