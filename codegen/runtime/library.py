"""A loaded library and its functions, called with NumPy arrays.

Long calls are divided into parts or can be stopped, so that Ctrl-C acts at once.
"""

import ctypes
from _thread import allocate_lock, start_new_thread
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from threading import local
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from axisid.codegen.lowering import BLOCK, GAINS, SIGNALS, LoopSettings, LoopStart
from axisid.support.arrays import Array

from .casadi_functions import FunctionShape, checked_arguments

_PART = 65_536  # samples at which any function is evaluated within a tenth of a second
_WAIT = 0.05  # s
#: Steps of a loop that end quickly on any machine, so that threads do not pay off.
_FEW_STEPS = 50_000


def slices(samples: int) -> Iterator[slice]:
    """Divide samples into parts, between which signals of the operating system are handled."""
    for begin in range(0, samples, _PART):
        yield slice(begin, min(begin + _PART, samples))


def stoppable(runs: Sequence[Callable[[NDArray[np.int32]], int]], steps: int) -> list[int]:
    """Run loops so that Ctrl-C ends them: in parallel threads, or directly if they are short.

    Parameters
    ----------
    runs : sequence of callable
        Each takes a flag, (1,), and ends soon after the flag is no longer 0.
    steps : int
        Steps of all runs together.

    Returns
    -------
    list of int
        The returned values.
    """
    stop = np.zeros(1, dtype=np.int32)
    if len(runs) == 1 and steps <= _FEW_STEPS:
        return [runs[0](stop)]
    # Each loop has its own thread; this one waits where Ctrl-C reaches it. An interrupt may come
    # between any two steps of Python. If a lock that both threads take were held then, as in a
    # pool's futures, the other would wait for it forever: here only one thread ever takes it.
    results, errors = [0] * len(runs), list[BaseException]()
    ended = [allocate_lock() for _ in runs]

    def work(i: int) -> None:
        try:
            results[i] = runs[i](stop)
        except BaseException as error:  # raised below
            errors.append(error)
            stop[0] = 1
        finally:
            ended[i].release()

    try:
        for i, lock in enumerate(ended):
            lock.acquire()
            start_new_thread(work, (i,))
        for lock in ended:
            # Short waits: a signal that another thread gets does not wake this one.
            while not lock.acquire(timeout=_WAIT):
                pass
    except BaseException:
        stop[0] = 1  # running calls hold all memory that they write to, and end soon
        raise
    if errors:
        raise errors[0]
    return results


class LoadedLibrary:
    """A library in this process.

    Parameters
    ----------
    path : Path
        Loading executes it, so it must come from the cache.
    having : str
        A function that it contains.

    Raises
    ------
    OSError
        It does not load, or is not the library of an axis.
    """

    def __init__(self, path: Path, having: str = "direct_dynamics_rows") -> None:
        self._library = ctypes.CDLL(str(path))
        self._typed: dict[str, Any] = {}
        self._own = local()
        if not hasattr(self._library, having):
            raise OSError(f"{path} is not the library of an axis")

    def __call__(self, function: str, *arguments: int | float | NDArray[Any] | None) -> int:
        """Call a function; the interpreter's lock is released."""
        call = self._typed.get(function)
        if call is None:
            # A new object each time, with its own types: a given place always has the same type.
            call = self._library[function]
            call.argtypes = [_type_in_c(each) for each in arguments]
            self._typed[function] = call  # now typed: another thread may call it
        given = [each.ctypes.data if isinstance(each, np.ndarray) else each for each in arguments]
        return int(call(*given))

    def memory(self, size: int, most: int | None = None) -> Array:
        """Return floats as workspace; each thread has its own, and keeps up to this number."""
        kept: Array | None = getattr(self._own, "memory", None)
        if kept is None or len(kept) < size:
            kept = np.empty(size)
            if most is None or size <= most:
                self._own.memory = kept
        return kept

    def has(self, function: str) -> bool:
        """Return whether the library evaluates a function at many samples."""
        return hasattr(self._library, f"{function}_rows")


class NativeLibrary(LoadedLibrary):
    """A compiled axis.

    Parameters
    ----------
    path : Path
        Path of the library.
    functions : mapping of str to casadi.Function
        The same functions in the virtual machine; their shapes are the library's.
    gains : (g,) array, optional
        Gains of the law, for functions that take them; the time loop takes them after the
        parameters.
    """

    def __init__(
        self,
        path: Path,
        functions: Mapping[str, Any],
        gains: Array | None = None,
    ) -> None:
        super().__init__(path)
        self.path, self._gains = path, gains
        self._shapes = {name: FunctionShape.of(each) for name, each in functions.items()}
        self._by_gains = {n for n, each in functions.items() if GAINS in each.name_in()}

    def evaluate(self, function: str, arguments: Sequence[ArrayLike]) -> tuple[Array, ...]:
        """Evaluate a function at N samples: one (N, elements) array per output.

        Vectors are the same for every sample, (p,), or have one row per sample, (N, p).
        """
        shape = self._shapes[function]
        if self._gains is not None and function in self._by_gains:
            arguments = (*arguments, self._gains)
        checked, samples = checked_arguments(shape, arguments)
        outputs = tuple(np.empty((samples, elements)) for elements in shape.results)
        called = f"{function}_rows"
        for part in slices(samples):
            given: list[Array | int] = []
            for array, vector in zip(checked, shape.vectors, strict=True):
                shared = vector and array.ndim == 1
                given.append(array if shared else array[part])
                if vector:
                    given.append(0 if shared else array.shape[1])
            self(called, part.stop - part.start, *given, *[out[part] for out in outputs])
        return outputs

    def from_rest(self, position: Array, signals: Array, parameters: Array) -> tuple[Array, Array]:
        """Return accelerations (B, 4) and rates (B, 2) at rest, to check the starts of loops.

        The accelerations are those under a force of 1, under none, and under none with friction
        that holds forward and backward; the rates, of damping and stiffness, are those in backward
        and forward direction, and empty if the loop itself computes them during the run.

        Parameters
        ----------
        position : (B,) array
        signals : (B, s) array
            Recorded ones, contiguous.
        parameters : (B, p) array
            Contiguous.
        """
        lanes = len(position)
        accelerations, rates = np.empty((lanes, 4)), np.zeros((lanes, 2))
        self(
            "from_rest_rows",
            lanes,
            position,
            signals,
            parameters,
            parameters.shape[1],
            accelerations,
            rates,
        )
        return accelerations, rates

    def later(
        self, motion: tuple[Array, Array], held: Array, span: Array, step: float, parameters: Array
    ) -> tuple[Array, Array, Array]:
        """Return motions some time after a law was evaluated, before it is evaluated again.

        Parameters
        ----------
        motion : tuple of (n,) array
            Positions and velocities at the evaluations, contiguous.
        held : (n, h) array
            The force since then, and value and rate of each recorded signal; contiguous.
        span : (n,) array
            Times since then, s, contiguous.
        step : float
            The longest, s.
        parameters : (p,) array

        Returns
        -------
        tuple of (n,) array
            Positions, velocities and friction directions; NaN where a motion comes to no end.
        """
        found = np.empty((3, len(span)))
        self("later_rows", len(span), *motion, held, span, float(step), parameters, *found)
        return found[0], found[1], found[2]

    def simulate(
        self,
        reference: Array,
        noise: Array | None,
        injected: Array | None,
        parameters: Array,
        start: LoopStart,
        settings: LoopSettings,
        recorded: Array | None = None,
    ) -> tuple[int, int, dict[str, Array]]:
        """Run one simulation, with a test signal added to the control or without.

        Recorded signals, (N, 2 s), are value and rate of each in turn; None for an axis without.

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
        parameters = self._with_gains(parameters)

        def run(stop: NDArray[np.int32]) -> int:
            return self(
                "simulate",
                len(reference),
                *(reference, noise, injected),
                *(() if recorded is None else (np.ascontiguousarray(recorded),)),
                parameters,
                float(settings.period),
                float(start.position),
                float(start.velocity),
                start.memory,
                float(settings.resolution),
                float(settings.allowed),
                int(settings.substeps),
                *signals,
                stopped,
                stop,
            )

        (status,) = stoppable([run], len(reference) * settings.substeps)
        return status, int(stopped[0]), dict(zip(SIGNALS, signals, strict=True))

    def simulate_batch(
        self,
        reference: Array,
        noise: Array | None,
        injected: Array | None,
        parameters: Array,
        start: LoopStart,
        settings: LoopSettings,
        wanted: Sequence[str],
        threads: int,
        recorded: Array | None = None,
    ) -> tuple[NDArray[np.int32], NDArray[np.int64], dict[str, Array]]:
        """Run many simulations in parallel lanes.

        Parameters
        ----------
        reference : (N,) or (N, B) array
        noise : (N, B) array or None
        injected : (N,) or (N, B) array or None
            Added to the control.
        parameters : (B, p) array, contiguous
        start : LoopStart
            By lane, its arrays contiguous.
        settings : LoopSettings
        wanted : sequence of str
            Names of `SIGNALS`; the others take no memory.
        threads : int
            Number of threads that share the lanes.
        recorded : (N, 2 s) or (N, 2 s, B) array or None
            Recorded signals, value and rate of each in turn.

        Returns
        -------
        status : (B,) array
        stopped : (B,) array
        signals : dict of str to (N, B) array
        """
        samples, lanes = len(reference), len(parameters)
        parameters = self._with_gains(parameters)
        names = [name for name in SIGNALS if name in wanted]
        arrays = [np.empty((samples, lanes)) for _ in names]
        signals = dict(zip(names, arrays, strict=True))
        status = np.zeros(lanes, dtype=np.int32)
        stopped = np.zeros(lanes, dtype=np.int64)
        blocks = -(-lanes // BLOCK)
        edges = [BLOCK * (blocks * i // threads) for i in range(threads)] + [lanes]

        def run(first: int, last: int, stop: NDArray[np.int32]) -> int:
            return self(
                "simulate_batch",
                samples,
                last - first,
                *_strided(reference, first),
                *_strided(noise, first),
                *_strided(injected, first),
                *(() if recorded is None else _strided(recorded, first, 2)),
                parameters[first:],
                start.position[first:],
                start.velocity[first:],
                None if start.memory is None else start.memory[first:],
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
        stoppable(runs, samples * lanes * settings.substeps)
        return status, stopped, signals

    def _with_gains(self, parameters: Array) -> Array:
        """Return parameters (p,) or (B, p), followed by the given gains."""
        return parameters if self._gains is None else beside(parameters, self._gains)


def beside(parameters: Array, gains: Array) -> Array:
    """Return parameters (p,) or (B, p), each followed by gains (g,) or (B, g), contiguous."""
    if parameters.ndim > 1:
        gains = np.broadcast_to(gains, (*parameters.shape[:-1], gains.shape[-1]))
    return np.concatenate([parameters, gains], axis=-1)


def _type_in_c(argument: int | float | NDArray[Any] | None) -> Any:
    if argument is None or isinstance(argument, np.ndarray):
        return ctypes.c_void_p
    return ctypes.c_double if isinstance(argument, float) else ctypes.c_ssize_t


def _strided(signal: Array | None, first: int, axes: int = 1) -> tuple[Array | int | None, ...]:
    """Return a signal from a lane on, and its strides in values.

    The axes before that of the lanes are time and, for recorded signals, the axis over signals,
    whose stride comes first; the last stride is over lanes, 0 if all share one signal.
    """
    if signal is None:
        return None, 0, 0
    over_time, *others = (stride // signal.itemsize for stride in signal.strides)
    if signal.ndim == axes:
        return signal, *others, over_time, 0
    return signal[..., first:], *others[:-1], over_time, others[-1]
