"""A loaded library and its functions, called with NumPy arrays.

Long calls are divided into parts, or can be stopped, so that Ctrl-C is handled at once.
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

_PART = 65_536  # samples; any function is evaluated at so many within a tenth of a second
_WAIT = 0.05  # s between looks at whether a thread has ended
#: Steps of a loop that is too short for threads to be useful, on any machine.
_FEW_STEPS = 50_000


def slices(samples: int) -> Iterator[slice]:
    """Yield consecutive slices of at most 65,536 samples.

    Between the calls for two slices, signals of the operating system such as Ctrl-C are handled.
    """
    for begin in range(0, samples, _PART):
        yield slice(begin, min(begin + _PART, samples))


def stoppable(runs: Sequence[Callable[[NDArray[np.int32]], int]], steps: int) -> list[int]:
    """Run loops in parallel threads so that Ctrl-C ends them; a short one runs directly.

    Parameters
    ----------
    runs : sequence of callable
        Function that runs a loop. Its argument is a flag, (1,); it ends soon after the flag is no
        longer 0.
    steps : int
        Number of steps of all runs together.

    Returns
    -------
    list of int
        The value that each run returns.
    """
    stop = np.zeros(1, dtype=np.int32)
    if len(runs) == 1 and steps <= _FEW_STEPS:
        return [runs[0](stop)]
    # Each loop has its own thread; this thread waits, so that Ctrl-C can interrupt it. An interrupt
    # may come between any two steps of Python. If it came while this thread held a lock that
    # another thread needs, as in the futures of a pool, the other thread would wait forever. Here
    # the other threads only release locks.
    results, errors = [0] * len(runs), list[BaseException]()
    ended = [allocate_lock() for _ in runs]

    def work(i: int) -> None:
        """Run loop number i and store its value; an error stops all loops."""
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
            # Short waits, because a signal that another thread receives does not end a wait.
            while not lock.acquire(timeout=_WAIT):
                pass
    except BaseException:
        stop[0] = 1  # the loops end soon; until then they keep the memory that they write to
        raise
    if errors:
        raise errors[0]
    return results


class LoadedLibrary:
    """A compiled library, loaded into this process.

    Parameters
    ----------
    path : Path
        Path of the library. Loading executes code, so the library must come from the cache.
    having : str
        A function that the library must contain.

    Raises
    ------
    OSError
        The library does not load, or does not contain the function.
    """

    def __init__(self, path: Path, having: str = "direct_dynamics_rows") -> None:
        self._library = ctypes.CDLL(str(path))
        self._typed: dict[str, Any] = {}
        self._own = local()
        if not hasattr(self._library, having):
            raise OSError(f"{path} is not the library of an axis")

    def __call__(self, function: str, *arguments: int | float | NDArray[Any] | None) -> int:
        """Call a C function without the interpreter's lock, and return its status."""
        call = self._typed.get(function)
        if call is None:
            # A new object, whose argument types follow from this call: they are always the same.
            call = self._library[function]
            call.argtypes = [_type_in_c(each) for each in arguments]
            self._typed[function] = call  # stored after the types, because other threads use it
        given = [each.ctypes.data if isinstance(each, np.ndarray) else each for each in arguments]
        return int(call(*given))

    def memory(self, size: int, most: int | None = None) -> Array:
        """Return a workspace of at least `size` floats, which belongs to the calling thread.

        The workspace is kept for the next call if `size` is at most `most`; None means always.
        """
        kept: Array | None = getattr(self._own, "memory", None)
        if kept is None or len(kept) < size:
            kept = np.empty(size)
            if most is None or size <= most:
                self._own.memory = kept
        return kept

    def has(self, function: str) -> bool:
        """Return True if the library can evaluate a function at many samples."""
        return hasattr(self._library, f"{function}_rows")


class NativeLibrary(LoadedLibrary):
    """The compiled functions and time loop of one axis.

    Parameters
    ----------
    path : Path
        Path of the library.
    functions : mapping of str to casadi.Function
        The same functions in the virtual machine, by name; they give the shapes of the arguments.
    gains : (g,) array, optional
        Gains of the law, for functions with gains as an argument; in the time loop they follow the
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
        """Return the results of a function at N samples: one (N, elements) array per output.

        A scalar argument has one value per sample, (N,). A vector argument is the same for every
        sample, (p,), or has one row per sample, (N, p).
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
        """Return accelerations (B, 4) and rates (B, 2) at rest, for checks at the start of loops.

        The accelerations are those under a force of 1, under no force, and under no force with
        friction as in forward and as in backward motion. The rates of damping and stiffness are for
        the backward and the forward direction, 1/s; they are 0 if the loop computes rates during
        the run.

        Parameters
        ----------
        position : (B,) array
        signals : (B, s) array
            Values of the recorded signals, contiguous.
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
        """Return motions some time after an evaluation of the law, with the force that it holds.

        Parameters
        ----------
        motion : tuple of (n,) array
            Positions and velocities at the evaluations, contiguous.
        held : (n, h) array
            The force since the evaluation, and value and rate of each recorded signal; contiguous.
        span : (n,) array
            Times since the evaluation, s, contiguous.
        step : float
            Longest step of the integration, s.
        parameters : (p,) array

        Returns
        -------
        tuple of (n,) array
            Positions, velocities and friction directions; NaN if a motion cannot be computed.
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
        """Return status, last sample and signals of one simulation.

        Parameters
        ----------
        reference : (N,) array
        noise : (N,) array or None
            Measurement noise of the position; None for none.
        injected : (N,) array or None
            Test signal added to the control; None for none.
        parameters : (p,) array
        start : LoopStart
        settings : LoopSettings
        recorded : (N, 2 s) array or None
            Value and rate of each recorded signal in turn; None for an axis without recorded
            signals.

        Returns
        -------
        status : int
            Index into `STATUSES`.
        stopped : int
            The sample at which the simulation ended.
        signals : dict of str to (N,) array
            Signals by name. Unless the simulation is complete, values from `stopped` on are
            undefined.
        """
        signals = np.empty((len(SIGNALS), len(reference)))
        stopped = np.zeros(1, dtype=np.int64)
        parameters = self._with_gains(parameters)

        def run(stop: NDArray[np.int32]) -> int:
            """Return the status of the simulation, which ends soon after `stop` is set."""
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
        """Return status, last sample and signals of B simulations, one in each lane.

        Parameters
        ----------
        reference : (N,) or (N, B) array
        noise : (N, B) array or None
            Measurement noise of the position; None for none.
        injected : (N,) or (N, B) array or None
            Test signal added to the control; None for none.
        parameters : (B, p) array, contiguous
        start : LoopStart
            One start for each lane, in contiguous arrays.
        settings : LoopSettings
        wanted : sequence of str
            Names of the `SIGNALS` to return; other signals take no memory.
        threads : int
            Number of threads that share the lanes.
        recorded : (N, 2 s) or (N, 2 s, B) array or None
            Value and rate of each recorded signal in turn; None for an axis without recorded
            signals.

        Returns
        -------
        status : (B,) array
            Indices into `STATUSES`.
        stopped : (B,) array
            The sample at which each simulation ended.
        signals : dict of str to (N, B) array
        """
        samples, lanes = len(reference), len(parameters)
        parameters = self._with_gains(parameters)
        names = [name for name in SIGNALS if name in wanted]
        arrays = [np.empty((samples, lanes)) for _ in names]
        signals = dict(zip(names, arrays, strict=True))
        status = np.zeros(lanes, dtype=np.int32)
        stopped = np.zeros(lanes, dtype=np.int64)
        # Each thread simulates whole blocks of lanes.
        blocks = -(-lanes // BLOCK)
        edges = [BLOCK * (blocks * i // threads) for i in range(threads)] + [lanes]

        def run(first: int, last: int, stop: NDArray[np.int32]) -> int:
            """Simulate lanes `first` to `last` - 1; end soon after `stop` is set."""
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
        """Return parameters (p,) or (B, p), followed by the gains of the law if there are any."""
        return parameters if self._gains is None else beside(parameters, self._gains)


def beside(parameters: Array, gains: Array) -> Array:
    """Return parameters (p,) or (B, p), each followed by gains (g,) or (B, g), contiguous."""
    if parameters.ndim > 1:
        gains = np.broadcast_to(gains, (*parameters.shape[:-1], gains.shape[-1]))
    return np.concatenate([parameters, gains], axis=-1)


def _type_in_c(argument: int | float | NDArray[Any] | None) -> Any:
    """Return the C type of an argument: a pointer, a double or an integer."""
    if argument is None or isinstance(argument, np.ndarray):
        return ctypes.c_void_p
    return ctypes.c_double if isinstance(argument, float) else ctypes.c_ssize_t


def _strided(signal: Array | None, first: int, axes: int = 1) -> tuple[Array | int | None, ...]:
    """Return a signal from lane `first` on, followed by its strides as numbers of values.

    The strides are, for recorded signals, the stride over signals; then the strides over time and
    over lanes. The stride over lanes is 0 if all lanes share the signal. Without a signal the
    result is (None, 0, 0).

    Parameters
    ----------
    signal : array or None
    first : int
    axes : int
        Number of axes before that of the lanes: time, and for recorded signals the axis of signals.
    """
    if signal is None:
        return None, 0, 0
    over_time, *others = (stride // signal.itemsize for stride in signal.strides)
    if signal.ndim == axes:
        return signal, *others, over_time, 0
    return signal[..., first:], *others[:-1], over_time, others[-1]
