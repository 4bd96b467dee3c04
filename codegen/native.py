"""Native functions of an axis, called with NumPy arrays and the interpreter's lock released.

What goes in and out is memory that NumPy owns; a contiguous array of floats is not copied. Time is
the first axis of every array, lanes (simulations of a batch) the second.
"""

import contextlib
import ctypes
import tempfile
import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .arguments import Array, checked_arguments, is_scalar
from .compiler import find_compiler
from .library_cache import build_library, cached_library, compiled_library
from .loop_settings import BLOCK, SIGNALS, LoopSettings
from .native_errors import NativeUnavailableError
from .self_test import check_library
from .slices import run_stoppable, slices
from .workshop import Workshop

#: Calls a function of a library by name with whole numbers, floats, arrays (their memory) and None.
Caller = Callable[..., int]


class LoadedLibrary:
    """A library in this process.

    Parameters
    ----------
    path : Path
        Loading executes it, so it must come from the cache.

    Raises
    ------
    OSError
        It does not load, or is not the library of an axis.
    """

    def __init__(self, path: Path) -> None:
        self._library = ctypes.CDLL(str(path))
        if not hasattr(self._library, "direct_dynamics_rows"):
            raise OSError(f"{path} is not the library of an axis")

    def __call__(self, function: str, *arguments: int | float | NDArray[Any] | None) -> int:
        """Call a function; the interpreter's lock is released."""
        return int(getattr(self._library, function)(*map(_as_c, arguments)))


class NativeLibrary:
    """A compiled axis.

    Parameters
    ----------
    call : callable
        Calls its functions.
    functions : mapping of str to casadi.Function
        The same functions in the virtual machine; their shapes are the library's.
    path : Path, optional
        Where it lies.
    """

    def __init__(
        self, call: Caller, functions: Mapping[str, Any], path: Path | None = None
    ) -> None:
        self.path = path
        self._call = call
        self._functions = functions

    def rows(self, function: str, arguments: Sequence[ArrayLike]) -> tuple[Array, ...]:
        """Evaluate a function at N samples: one (N, elements) array per output."""
        shapes = self._functions[function]
        given, samples = checked_arguments(function, shapes, arguments)
        outputs = tuple(np.empty((samples, shapes.numel_out(i))) for i in range(shapes.n_out()))
        call = partial(self._call, f"{function}_rows")
        for part in slices(samples):
            if part == slice(0, samples):
                call(samples, *given, *outputs)
                break
            cut = [a[part] if is_scalar(shapes, i) else a for i, a in enumerate(given)]
            call(part.stop - part.start, *cut, *(out[part] for out in outputs))
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
        stopped = np.zeros(1, dtype=np.int64)

        def run(stop: NDArray[np.int32]) -> int:
            return self._call(
                "simulate",
                len(reference),
                *(reference, noise, parameters),
                float(settings.period),
                float(start),
                float(settings.resolution),
                float(settings.allowed),
                int(settings.substeps),
                *signals,
                stopped,
                stop,
            )

        (status,) = run_stoppable([run], len(reference) * settings.substeps)
        return status, int(stopped[0]), dict(zip(SIGNALS, signals, strict=True))

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

        def run(first: int, last: int, stop: NDArray[np.int32]) -> int:
            return self._call(
                "simulate_batch",
                samples,
                last - first,
                *_strided(reference, first),
                *_strided(noise, first),
                parameters[first:],
                start[first:],
                settings.allowed[first:],
                float(settings.period),
                float(settings.resolution),
                int(settings.substeps),
                *(signals[n][:, first:] if n in signals else None for n in SIGNALS),
                lanes,
                status[first:],
                stopped[first:],
                stop,
            )

        runs = [partial(run, *edge) for edge in pairwise(edges) if edge[0] < edge[1]]
        run_stoppable(runs, samples * lanes * settings.substeps)
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
        self.enabled = enabled
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
            return self._load(path)
        except OSError:  # whole, but not for this machine: build it again
            path.unlink(missing_ok=True)
            return self._load(compiled_library(self._text, self._check))

    def _load(self, path: Path) -> NativeLibrary:
        return NativeLibrary(LoadedLibrary(path), self._functions, path)

    def compile_afresh(self) -> None:
        """Compile and test the library in a folder of its own, cached or not.

        Raises
        ------
        NativeUnavailableError
            There is no compiler, or it fails.
        """
        with tempfile.TemporaryDirectory(prefix="axisid-") as folder:
            build_library(self._text, find_compiler(), Path(folder), self._check)

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
                self._library = None if path is None else self._load(path)
        return self._library if f"void {function}_rows(" in self._text else None

    def _check(self, workshop: Workshop) -> None:
        """Compare a fresh library with the virtual machine, in the process that tries it."""
        library = NativeLibrary(workshop.call, self._functions)
        check_library(library, self._functions, self._text)


def _as_c(argument: int | float | NDArray[Any] | None) -> Any:
    if isinstance(argument, np.ndarray):
        return ctypes.c_void_p(argument.ctypes.data)
    if isinstance(argument, float):
        return ctypes.c_double(argument)
    return None if argument is None else ctypes.c_ssize_t(argument)


def _strided(signal: Array | None, first: int) -> tuple[Array | None, int, int]:
    """A signal from a lane on, and its strides over time and lanes in values."""
    if signal is None:
        return None, 0, 0
    over_time = signal.strides[0] // signal.itemsize
    if signal.ndim == 1:
        return signal, over_time, 0
    return signal[:, first:], over_time, signal.strides[1] // signal.itemsize
