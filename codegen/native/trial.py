"""A fresh library is called once, in a process of its own, before any process loads it.

Each function has one point, at which the virtual machine says what is expected: enough to see a
compiler or a library that does not serve on this machine. That what is generated is right, for any
axis and anywhere, is the affair of the tests.
"""

import signal
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from axisid.codegen.lowering import BLOCK, SIGNALS, LoopSettings, LoopStart
from axisid.codegen.runtime import VirtualLoop, by_sample, is_continuous, recorded_values
from axisid.support.arrays import Array

from .child import run_child
from .errors import NativeUnavailableError, WrongLibraryError
from .lanes import Decimation, LaneLibrary
from .library import NativeLibrary

_PERIOD, _SAMPLES = 1e-3, 4
#: Of a size, or of what a change of all arguments by `_LITTLE` moves, up to which results agree.
_ALLOWED, _LITTLE, _MAGNIFIED = 1e-9, 1e-15, 1e3
_AROUND = (1.0, 1 + _LITTLE)
# In a step, and in all, that are followed; thousands, as of a force that is NaN, take minutes.
_EVENTS, _STEPS = 64, 512
_EVERY, _ROWS, _LANES = 10, 6, 11


class Trial:
    """Calls of a library's functions, as a `Caller` collects them, and what they should give."""

    def __init__(self) -> None:
        self._calls: list[tuple[str, tuple[Any, ...]]] = []
        self._expected: list[tuple[str, Array, Array, Array]] = []

    def __call__(self, function: str, *arguments: int | float | NDArray[Any] | None) -> int:
        """Note a call; its arrays are filled when the trial is run."""
        self._calls.append((function, arguments))
        return 0

    def expect(
        self, what: str, found: Array, wanted: ArrayLike, moved: ArrayLike | None = None
    ) -> None:
        """Say what an array should hold, and what a little change of all arguments makes of it."""
        wanted = np.asarray(wanted, dtype=float)
        self._expected.append((what, found, wanted, wanted if moved is None else np.asarray(moved)))

    def run(self, library: Path, seconds: float) -> None:
        """Make the calls in a process that works in the library's folder.

        Raises
        ------
        NativeUnavailableError
            The library does not load.
        WrongLibraryError
            It crashes, hangs or computes wrong values, and would wherever it is built.
        """
        folder = library.parent
        calls = [
            (name, [a.tobytes() if isinstance(a, np.ndarray) else a for a in arguments])
            for name, arguments in self._calls
        ]
        try:
            code = run_child(folder, seconds, ("call", str(library), calls))
            how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
            reason = f"it ends its process ({how})"
        except TimeoutError as error:
            reason = str(error)
        if (folder / "refused").exists():
            reason = (folder / "refused").read_text()
        if not (folder / "loaded").exists():
            raise NativeUnavailableError(f"the compiled library does not load: {reason}")
        if not (folder / "reply").exists():
            raise WrongLibraryError(f"the compiled library does not run: {reason}")
        self._read((folder / "reply").read_bytes())
        for what, found, wanted, moved in self._expected:
            with np.errstate(invalid="ignore"):
                near = _ALLOWED * (1 + np.abs(wanted)) + _MAGNIFIED * np.abs(moved - wanted)
                wrong = ~(np.abs(found - wanted) <= near) & np.isfinite(near)
            if wrong.any():
                raise WrongLibraryError(f"the compiled {what} computes wrong values")

    def _read(self, reply: bytes) -> None:
        at = 0
        for array in (a for _, call in self._calls for a in call if isinstance(a, np.ndarray)):
            if array.flags.writeable:
                values = np.frombuffer(reply, array.dtype, array.size, at)
                array[...] = values.reshape(array.shape)
            at += array.nbytes


def trial_of(functions: Mapping[str, Any], text: str) -> Trial:
    """One call of each function of a C text, and what the virtual machine gives."""
    trial = Trial()
    library = NativeLibrary(trial, functions)
    for name, function in functions.items():
        if f"void {name}_rows(" in text:
            point = _point(function)
            wanted, moved = (function.call([scale * x for x in point]) for scale in _AROUND)
            for out, here, there in zip(library.evaluate(name, point), wanted, moved, strict=True):
                trial.expect(name, out[0], here.full().ravel(), there.full().ravel())
    if "void simulate_batch(" in text:
        _try_loop(trial, library, functions, later="HOLDS_FORCE 1" in text)
    return trial


def _point(function: Any) -> list[Array]:
    """Arguments about 1, of either side, and a step of a sampling period."""
    rng = np.random.default_rng(0)
    scales = {"step": _PERIOD, "sides": 0.0}
    names = function.name_in()
    sizes = {name: rng.uniform(0.5, 1.5, function.size1_in(name)) for name in names}
    return [scales.get(name, 1.0) * sizes[name] + (name == "sides") for name in names]


def _try_loop(
    trial: Trial, library: NativeLibrary, functions: Mapping[str, Any], *, later: bool
) -> None:
    """A few samples of one loop, alone and as every lane of a batch, and what starts it."""
    rng = np.random.default_rng(0)
    parameters = rng.uniform(0.5, 1.5, functions["closed_loop_step"].size1_in("parameters"))
    own = functions["plant_step"].size1_in("parameters")
    values = recorded_values(functions)
    recorded = rng.uniform(0.5, 1.5, (_SAMPLES, values)) if values else None
    signals = np.zeros(0) if recorded is None else recorded[0, ::2].copy()
    reference, noise, injected = (0.1 * rng.normal(size=_SAMPLES) for _ in range(3))
    gains = (parameters[own:],) if own < len(parameters) else ()
    memory = functions["control_start"](reference[0], 0.1, *signals, *gains).full().ravel()
    start = LoopStart(position=0.1, velocity=0.2, memory=memory)
    settings = LoopSettings(
        period=_PERIOD,
        resolution=0.0 if is_continuous(functions) else 1e-6,
        allowed=np.inf,
        substeps=1,
    )
    runs = [
        VirtualLoop(functions, scale * parameters, settings, _EVENTS, _STEPS).run(
            reference, noise, injected, start, recorded
        )
        for scale in _AROUND
    ]
    (*_, wanted), (*_, moved) = runs
    one = library.simulate(reference, noise, injected, parameters, start, settings, recorded)
    lanes = BLOCK + 1
    many = library.simulate_batch(
        reference,
        np.repeat(noise[:, None], lanes, axis=1),
        injected,
        np.tile(parameters, (lanes, 1)),
        LoopStart(
            position=np.full(lanes, start.position),
            velocity=np.full(lanes, start.velocity),
            memory=np.tile(memory, (lanes, 1)),
        ),
        replace(settings, allowed=np.full(lanes, np.inf)),
        SIGNALS,
        1,
        recorded,
    )
    still, plant = np.full(1, start.position), parameters[:own].copy()
    accelerations, _ = library.from_rest(still, signals[None], plant[None])
    at_rest = [
        float(functions["direct_dynamics"](start.position, 0.0, *case, *signals, plant))
        for case in ((1.0, 0.0), (0.0, 0.0), (0.0, 1.0), (0.0, -1.0))
    ]
    trial.expect("start of a loop", accelerations[0], at_rest)
    if any(status for status, *_ in runs):
        return  # it is called, and there is nothing to hold it against
    for name in SIGNALS:
        trial.expect("time loop", one[2][name], wanted[name], moved[name])
        trial.expect("time loop", many[2][name], wanted[name][:, None], moved[name][:, None])
    if later:
        motion = (wanted["position"][:1].copy(), wanted["velocity"][:1].copy())
        held = np.hstack([wanted["force"][0], [] if recorded is None else recorded[0]])[None]
        found = library.later(motion, held, np.full(1, _PERIOD), _PERIOD, parameters)
        for name, value in zip(("position", "velocity"), found, strict=False):
            trial.expect("motion between samples", value, wanted[name][1:2], moved[name][1:2])


def lanes_trial(functions: Mapping[str, Any], *, known: bool) -> Trial:
    """Rows that nothing filters, measured and simulated, of more lanes than a register has."""
    trial, rng = Trial(), np.random.default_rng(0)
    library = LaneLibrary(trial, functions["direct_dynamics"].size1_in("parameters"), known=known)
    shape, rows = (_EVERY * _ROWS, _LANES), slice(_EVERY - 1, None, _EVERY)
    q, dq, ddq, force = (rng.uniform(0.5, 1.5, shape) for _ in range(4))
    sets = rng.uniform(0.5, 1.5, (_LANES, functions["direct_dynamics"].size1_in("parameters")))
    kept = [each[rows].reshape(1, -1) for each in (q, dq, ddq, np.ones(shape))]
    wanted = by_sample(functions["idm_regressor"].call(kept)[0].full(), _ROWS * _LANES)
    wanted = wanted.reshape(_ROWS, _LANES, -1).transpose(0, 2, 1)
    decimation = Decimation(
        sizes=np.array(
            [0, len(q), 0, len(q), 0, _EVERY, _EVERY - 1, 0, _ROWS, _ROWS], dtype=np.int64
        ),
        powers=np.zeros((_EVERY + 1, 8)),
        gains=np.zeros(8),
        settled=np.zeros(8),
        ends=np.zeros((8, 8)),
        direct=1.0,
    )
    measured = library.measured(force, (q, dq, ddq), 0.0, None, decimation)
    simulated = library.simulated((q, dq, ddq, force, np.ones(shape)), None, sets, None, decimation)
    for found in (measured, simulated):
        trial.expect("rows of lanes", found[:, : wanted.shape[1]], wanted)
    return trial
