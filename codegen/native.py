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
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from axisid.modeling import UsageError

from .compiler import NativeUnavailableError, find_compiler
from .library_cache import build_library, cached_library, compiled_library

Array = NDArray[np.float64]

#: Signals of a simulation, in the order of the C functions' results.
SIGNALS = ("position", "velocity", "acceleration", "force", "control", "direction", "before")
#: What a simulation ended with, by the status that the C functions return.
STATUSES = ("done", "out of range", "not finite", "chatter")

#: Arguments that are vectors; every other one is a scalar.
VECTORS = frozenset({"parameters", "ddm_parameters", "state", "held"})

_LANES = 32  # of a block in loop.c
_SIZE, _REAL = ctypes.c_ssize_t, ctypes.c_double
_TEST_SAMPLES, _TEST_TOLERANCE = 32, 1e-12


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopSettings:
    """What a simulation needs beside its signals.

    Attributes
    ----------
    period : float
        Sampling period, s.
    resolution : float
        Of the encoder, in the coordinate's unit; 0 for none.
    allowed : float or (B,) array
        Distance from the reference at which a simulation ends as out of range; by lane for a batch.
    substeps : int
        Runge-Kutta steps in a sample.
    """

    period: float
    resolution: float
    allowed: Any
    substeps: int


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
        blocks = -(-lanes // _LANES)
        edges = [_LANES * (blocks * i // threads) for i in range(threads)] + [lanes]

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
            self._compare(NativeLibrary(path, self._functions))
        except (OSError, AttributeError) as error:
            raise NativeUnavailableError(f"the compiled library does not load: {error}") from error

    def _compare(self, library: NativeLibrary) -> None:
        rng = np.random.default_rng(0)
        for name, function in self._functions.items():
            if f"void {name}_rows(" not in self._text:
                continue
            arguments = [
                rng.uniform(
                    0.5,
                    1.5,
                    (function.size1_in(i), _TEST_SAMPLES if _is_scalar(function, i) else 1),
                )
                for i in range(function.n_in())
            ]
            if "step" in function.name_in():  # a long step would magnify rounding without bound
                arguments[function.index_in("step")] *= 1e-3
            expected = [
                by_sample(out.full(), _TEST_SAMPLES)
                for i, out in enumerate(function.call(arguments))
            ]
            for got, wanted in zip(library.rows(name, arguments), expected, strict=True):
                if not np.allclose(
                    got, wanted, rtol=_TEST_TOLERANCE, atol=_TEST_TOLERANCE, equal_nan=True
                ):
                    raise NativeUnavailableError(f"the compiled {name} computes wrong values")
        self._check_loop(library)

    def _check_loop(self, library: NativeLibrary) -> None:
        """Compare one lane of a batch, and a sample of a simulation, with what they are made of."""
        if "void simulate_batch(" not in self._text:
            return
        step = self._functions["closed_loop_step"]
        parameters = np.full(step.size1_in("parameters"), 1.0)
        reference = 1e-3 * np.arange(1.0, _TEST_SAMPLES + 1)
        settings = LoopSettings(period=1e-3, resolution=0.0, allowed=np.inf, substeps=1)
        status, _, one = library.simulate(reference, None, parameters, 0.0, settings)
        lanes = _LANES + 1
        many = LoopSettings(period=1e-3, resolution=0.0, allowed=np.full(lanes, np.inf), substeps=1)
        statuses, _, batch = library.simulate_batch(
            reference, None, np.tile(parameters, (lanes, 1)), np.zeros(lanes), many, SIGNALS, 1
        )
        start = self._functions["control_start"](reference[0], 0.0)
        first = step(0.0, 0.0, start, reference[0], 0.0, 0.0, 0.0, parameters, 1e-3)
        expected = {"position": 0.0, "velocity": 0.0, "force": first[4], "control": first[5]}
        same = bool(np.all(statuses == status)) and (
            status != 0
            or (
                all(
                    np.allclose(batch[name], one[name][:, None], rtol=1e-9, atol=1e-12)
                    for name in SIGNALS
                )
                and all(np.isclose(one[n][0], float(v), rtol=1e-12) for n, v in expected.items())
            )
        )
        if not same:
            raise NativeUnavailableError("the compiled time loop computes wrong values")


def by_sample(values: Array, samples: int) -> Array:
    """CasADi puts the results of many samples side by side; here each gets a row."""
    height, width = values.shape[0], values.shape[1] // samples
    columns = values.reshape(height, samples, width).swapaxes(0, 1)
    return columns.reshape(samples, height * width)


def _is_scalar(function: Any, index: int) -> bool:
    return function.name_in(index) not in VECTORS


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


def checked_arguments(
    name: str, function: Any, arguments: Sequence[ArrayLike]
) -> tuple[list[Array], int]:
    """Arguments of a function at many samples, each of its length, and how many samples.

    Raises
    ------
    UsageError
        There are too few or too many, or one has another length.
    """
    if len(arguments) != function.n_in():
        raise UsageError(f"{name} takes {function.n_in()} arguments, not {len(arguments)}.")
    given = [np.ascontiguousarray(a, dtype=float).ravel() for a in arguments]
    samples = max((len(a) for i, a in enumerate(given) if _is_scalar(function, i)), default=1)
    for i, array in enumerate(given):
        wanted = samples if _is_scalar(function, i) else function.size1_in(i)
        if _is_scalar(function, i) and len(array) == 1 != wanted:
            given[i] = np.full(wanted, array[0])
        elif len(array) != wanted:
            raise UsageError(
                f"{name}: {function.name_in(i)} has {len(array)} values, not {wanted}."
            )
    return given, samples
