"""Whether a compiled axis computes what the virtual machine computes."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.accuracy import rounding_bounds
from axisid.codegen.lowering import (
    BLOCK,
    HELD_REFERENCE,
    SIGNALS,
    STATUSES,
    LoopSettings,
    LoopStart,
)
from axisid.codegen.runtime import (
    VirtualLoop,
    by_sample,
    is_continuous,
    is_scalar,
    recorded_values,
)
from axisid.codegen.thresholds.generation import (
    MAX_FUNCTION_DIFFERENCE,
    MAX_LOOP_DIFFERENCE,
    MAX_MAGNIFIED_DIFFERENCE,
    MAX_ROUNDING_SHARE,
    MAX_TESTED_RATE,
)
from axisid.support.arrays import Array

from .errors import WrongLibraryError

if TYPE_CHECKING:
    from .library import NativeLibrary

_Result = tuple[int, int, dict[str, NDArray[np.float64]]]  # status, its sample, signals

_TEST_SAMPLES = 32
_LARGE, _SMALL = 0.5, -4  # how many of the samples have arguments about 1; decades of the others
# A model may be too fast for a step, or for a period: it then magnifies rounding, and would any
# fault, so that nothing could be told from the results. They are cut until it is not.
_STEP, _CUT, _MOST_CUTS = 1e-3, 0.1, 12
# Few samples, since an unstable loop magnifies rounding from each to the next; how much it does is
# seen from a start and parameters that are a little off.
_LOOP_SAMPLES, _LITTLE = 8, 1e-15
_RATE = 10.0  # of a recorded signal's size in a second
_NEWTON = 5  # steps to where a side changes
# In a step, and in all, that are followed; thousands, as of a force that is NaN, take minutes.
_EVENTS, _STEPS = 64, 512
_GIVEN_UP = ("chatter", "unresolved")
_TRIED = (0, 3, 11, 24, BLOCK)  # lanes; the last lies in the second block
_BOUNDED = 3  # the lane that soon leaves its range


def check_library(library: "NativeLibrary", functions: Mapping[str, Any], text: str) -> None:
    """Compare a fresh library with the virtual machine at random points.

    Raises
    ------
    WrongLibraryError
        They differ.
    """
    for name, function in functions.items():
        if f"void {name}_rows(" in text:
            _check_function(library, name, function)
    if "void from_rest_rows(" in text:
        _check_rest(library, functions)
    if "void simulate_batch(" in text:
        for substeps in (1, 3):
            _check_loop(library, functions, substeps, later="void later_rows(" in text)


def _check_function(library: "NativeLibrary", name: str, function: Any) -> None:
    arguments = _points(function)
    bounds = _resolved(function, arguments)
    expected = [
        by_sample(out.full(), _TEST_SAMPLES) for i, out in enumerate(function.call(arguments))
    ]
    results = library.evaluate(name, arguments)
    for got, wanted, bound in zip(results, expected, bounds, strict=True):
        with np.errstate(invalid="ignore"):
            allowed = bound + MAX_FUNCTION_DIFFERENCE.value * (1 + np.abs(wanted))
            same = (np.abs(got - wanted) <= allowed) | (got == wanted)
        same |= np.isnan(got) & np.isnan(wanted) | np.isinf(bound)
        if not same.all():
            raise WrongLibraryError(f"the compiled {name} computes wrong values")


def _check_rest(library: "NativeLibrary", functions: Mapping[str, Any]) -> None:
    """Compare what starts are judged by with the compiled functions, which were checked before."""
    motion = _points(functions["direct_dynamics"])
    position, parameters = motion[0][0], motion[-1][:, 0]
    recorded = [signal[0] for signal in motion[4:-1]]
    sets = np.tile(parameters, (len(position), 1))
    signals = np.ascontiguousarray(np.reshape(recorded, (len(recorded), len(position))).T)
    accelerations, _ = library.from_rest(position, signals, sets)
    still = np.zeros_like(position)
    for case, (force, direction) in enumerate(((1.0, 0.0), (0.0, 0.0), (0.0, 1.0), (0.0, -1.0))):
        pushed = (position, still, still + force, still + direction)
        (wanted,) = library.evaluate("direct_dynamics", (*pushed, *recorded, parameters))
        if not np.allclose(
            accelerations[:, case],
            wanted[:, 0],
            rtol=MAX_FUNCTION_DIFFERENCE.value,
            atol=MAX_FUNCTION_DIFFERENCE.value,
            equal_nan=True,
        ):
            raise WrongLibraryError("the compiled start of a loop computes wrong values")


def _points(function: Any) -> list[Array]:
    """Arguments at which a function is tried: about 1, then of both signs and many sizes."""
    rng = np.random.default_rng(0)
    arguments = []
    for i in range(function.n_in()):
        samples = _TEST_SAMPLES if is_scalar(function, i) else 1
        values = rng.uniform(0.5, 1.5, (function.size1_in(i), samples))
        others = slice(int(_LARGE * samples), samples) if samples > 1 else slice(0)
        if function.name_in(i) == "step":
            values *= _STEP
        elif function.name_in(i) == "sides":
            values = rng.choice([-1.0, 1.0], values.shape)
        else:
            count = values[:, others].shape
            values[:, others] *= rng.choice([-1, 1], count) * 10 ** rng.uniform(_SMALL, 0, count)
        arguments.append(values)
    return arguments


def _resolved(function: Any, arguments: list[Array]) -> list[Array]:
    """Cut the steps that a function's model is too fast for; how far rounding moves its results."""
    bounds = list(rounding_bounds(function, arguments))
    if "step" not in function.name_in():
        return bounds
    place = function.index_in("step")
    least = [*arguments[:place], _STEP * _CUT**_MOST_CUTS, *arguments[place + 1 :]]
    finite = np.isfinite(_side_by_side(function, least)).all(axis=1)
    for _ in range(_MOST_CUTS):
        sizes = np.abs(_side_by_side(function, arguments))
        blurred = (
            np.hstack(bounds) > MAX_ROUNDING_SHARE.value * sizes + MAX_FUNCTION_DIFFERENCE.value
        )
        cut = np.flatnonzero(np.any(blurred | ~np.isfinite(sizes), axis=1) & finite)
        if not cut.size:
            break
        arguments[place][:, cut] *= _CUT
        some = [a[:, cut] if a.shape[1] > 1 else a for a in arguments]
        for bound, new in zip(bounds, rounding_bounds(function, some), strict=True):
            bound[cut] = new
    return bounds


def _side_by_side(function: Any, arguments: Sequence[Any]) -> Array:
    """All results of a function at the samples, (n, elements)."""
    return np.hstack([by_sample(out.full(), _TEST_SAMPLES) for out in function.call(arguments)])


@dataclass(frozen=True, slots=True)
class _Lanes:
    """Unlike simulations side by side."""

    reference: Array
    noise: Array
    injected: Array
    start: LoopStart
    parameters: Array
    settings: LoopSettings
    recorded: Array | None = None

    def recorded_of(self, lane: int) -> Array | None:
        """Recorded signals of a lane."""
        return None if self.recorded is None else self.recorded[:, :, lane].copy()

    def one(self, lane: int) -> tuple[tuple[Array, Array, Array], LoopSettings]:
        """Reference, noise and what is added to the control of a lane, and its settings."""
        reference, noise, injected = self.reference[:, lane], self.noise[:, lane], self.injected
        inputs = (reference.copy(), noise.copy(), injected[:, lane].copy())
        return inputs, replace(self.settings, allowed=float(self.settings.allowed[lane]))

    def start_of(self, lane: int, scale: float = 1.0) -> LoopStart:
        """Where a lane starts, or a little off."""
        start = self.start
        return LoopStart(
            position=start.position[lane] * scale,
            velocity=start.velocity[lane] * scale,
            memory=start.memory[lane] * scale,
        )


def _check_loop(
    library: "NativeLibrary", functions: Mapping[str, Any], substeps: int, *, later: bool
) -> None:
    """Compare unlike lanes with the same simulations one by one, native and virtual."""
    lanes, rates = _lanes(functions, substeps), _rates(functions["held_acceleration"])
    for cut in range(_MOST_CUTS + 1):
        settings = replace(lanes.settings, period=_STEP * _CUT**cut)
        lanes = replace(lanes, settings=settings)
        pairs = list(_expected(functions, lanes, substeps))
        slow = all(
            _is_slow(rates, lanes, lane, pair[0]) for lane, pair in zip(_TRIED, pairs, strict=True)
        )
        if slow and all(_is_resolved(*pair) for pair in pairs):
            break
    statuses, ends, batch = library.simulate_batch(
        *(lanes.reference, lanes.noise, lanes.injected, lanes.parameters, lanes.start),
        *(settings, SIGNALS, 1, lanes.recorded),
    )
    for lane, pair in zip(_TRIED, pairs, strict=True):
        if "switching" in functions and any(STATUSES[each[0]] in _GIVEN_UP for each in pair):
            continue  # where it is given up here, the native loop may still follow
        inputs, own = lanes.one(lane)
        one = library.simulate(
            *inputs, lanes.parameters[lane], lanes.start_of(lane), own, lanes.recorded_of(lane)
        )
        beside = {name: values[:, lane] for name, values in batch.items()}
        for got in (one, (int(statuses[lane]), int(ends[lane]), beside)):
            if not _same(got, *pair):
                raise WrongLibraryError("the compiled time loop computes wrong values")
        if later and not _is_later(library, lanes, lane, *pair):
            raise WrongLibraryError("the compiled motion between samples computes wrong values")


def _lanes(functions: Mapping[str, Any], substeps: int) -> _Lanes:
    rng = np.random.default_rng(substeps)
    lanes = BLOCK + 1
    sizes = np.logspace(-5, 0, lanes)
    reference, noise = (sizes * rng.normal(size=(_LOOP_SAMPLES, lanes)) for _ in range(2))
    noise *= 1e-2
    start = 0.1 * sizes * rng.normal(size=lanes)
    parameters = rng.uniform(
        0.5, 1.5, (lanes, functions["closed_loop_step"].size1_in("parameters"))
    )
    injected = 0.1 * sizes * rng.normal(size=reference.shape)
    recorded = _recorded(recorded_values(functions), sizes, rng)
    if "switching" in functions:
        own = functions["switching"].size1_in("parameters")
        start = _near_sides(functions["switching"], parameters[:, :own], start, recorded)
    allowed = np.full(lanes, np.inf)
    allowed[_BOUNDED] = np.max(np.abs(reference[:, _BOUNDED] - start[_BOUNDED])) * 0.9
    continuous = is_continuous(functions)
    settings = LoopSettings(
        period=_STEP, resolution=0.0 if continuous else 1e-6, allowed=allowed, substeps=substeps
    )
    begins = LoopStart(
        position=start,
        velocity=_moving(rng, sizes),
        memory=_remembered(functions, rng, reference[0], start, recorded, parameters),
    )
    return _Lanes(reference, noise, injected, begins, parameters, settings, recorded)


def _recorded(values: int, sizes: Array, rng: np.random.Generator) -> Array | None:
    """Recorded signals by sample and lane, value and rate of each in turn; None for no signals."""
    if not values:
        return None
    shape = (_LOOP_SAMPLES, values, len(sizes))
    signals = sizes * rng.uniform(0.5, 1.5, shape)
    signals[:, 1::2] *= rng.choice([-_RATE, _RATE], signals[:, 1::2].shape)
    return signals


def _moving(rng: np.random.Generator, sizes: Array) -> Array:
    """Velocities of which every other lane has none."""
    speeds = 0.1 * sizes * rng.normal(size=len(sizes))
    return np.asarray(np.where(np.arange(len(sizes)) % 2, speeds, 0.0))


def _remembered(
    functions: Mapping[str, Any],
    rng: np.random.Generator,
    reference: Array,
    start: Array,
    recorded: Array | None,
    parameters: Array,
) -> Array:
    """What the drive remembers of an axis at rest, in every other lane a tenth off."""
    begin = functions["control_start"]
    signals = () if recorded is None else recorded[0, ::2]
    own = functions["plant_step"].size1_in("parameters")
    gains = (parameters[:, own:],) if own < parameters.shape[1] else ()
    each = zip(reference, start, *signals, *gains, strict=True)
    at_rest = [begin(*lane).full().ravel() for lane in each]
    some = np.where(np.arange(len(start)) % 2, 0.1, 0.0)[:, None]
    memory = np.array(at_rest).reshape(len(start), -1)
    return np.asarray(memory * (1 + some * rng.choice([-1, 1], memory.shape)))


def _expected(
    functions: Mapping[str, Any], lanes: _Lanes, seed: int
) -> Iterator[tuple[_Result, _Result]]:
    """What comes of each lane that is tried, and what of one that is a little off."""
    rng = np.random.default_rng(seed)
    for lane in _TRIED:
        inputs, own = lanes.one(lane)
        parameters = lanes.parameters[lane]
        off = parameters * (1 + _LITTLE * rng.choice([-1, 1], len(parameters)))
        start, shaken = lanes.start_of(lane), lanes.start_of(lane, 1 + _LITTLE)
        recorded = lanes.recorded_of(lane)
        yield (
            VirtualLoop(functions, parameters, own, _EVENTS, _STEPS).run(*inputs, start, recorded),
            VirtualLoop(functions, off, own, _EVENTS, _STEPS).run(*inputs, shaken, recorded),
        )


def _rates(acceleration: Any) -> Any:
    """How the acceleration changes with position and velocity, as a function of the same."""
    changes = [f"jac:{acceleration.name_out(0)}:{name}" for name in acceleration.name_in()[:2]]
    return acceleration.factory("rates", acceleration.name_in(), changes)


def _is_slow(rates: Any, lanes: _Lanes, lane: int, result: _Result) -> bool:
    """Whether a step resolves the plant's rates wherever a lane went, as in real simulations."""
    if "sides" in rates.name_in():  # the loop itself takes the steps that a side asks for
        return True
    status, end, signals = result
    until = end if status else _LOOP_SAMPLES
    if not until:
        return True
    q, dq, force, direction = (
        signals[name][None, :until] for name in ("position", "velocity", "force", "direction")
    )
    recorded = lanes.recorded_of(lane)
    lines = np.zeros((0, until)) if recorded is None else recorded[:until].T
    beside = rates.size1_in("held") - len(lines)
    continuous = beside == len(HELD_REFERENCE)
    law = np.vstack([q, 0 * q, lanes.noise[:until, lane], 0 * q]) if continuous else force
    law = law if continuous else np.tile(law, (beside, 1))
    held = np.vstack([law, lines])
    own = lanes.parameters[lane, : rates.size1_in("parameters")]
    states = (np.zeros((rates.size1_in("states"), 1)),) if "states" in rates.name_in() else ()
    arguments = [q, dq, held, direction, *states, own[:, None]]
    stiffness, damping = (np.abs(change.full()) for change in rates.call(arguments))
    step = lanes.settings.period / lanes.settings.substeps
    return not np.any(step * np.maximum(damping, np.sqrt(stiffness)) > MAX_TESTED_RATE.value)


def _is_resolved(expected: _Result, shaken: _Result) -> bool:
    """Whether a little remains a little."""
    if expected[:2] != shaken[:2] or STATUSES[expected[0]] == "not finite":
        return False
    return all(
        moved <= MAX_ROUNDING_SHARE.value * size for _, size, moved in _moves(expected, shaken)
    )


def _moves(expected: _Result, shaken: _Result) -> Iterator[tuple[str, float, float]]:
    """How large each signal is, and how far it moves."""
    until = expected[1] if expected[0] else _LOOP_SAMPLES
    for name in SIGNALS:
        wanted, other = expected[2][name][:until], shaken[2][name][:until]
        finite = np.isfinite(wanted) & np.isfinite(other)
        size = np.max(np.abs(wanted), initial=0.0, where=finite)
        yield name, size, np.max(np.abs(wanted - other), initial=0.0, where=finite)


def _near_sides(switching: Any, parameters: Array, start: Array, recorded: Array | None) -> Array:
    """Starts moved to where a side changes, and some into the place: a few samples then pass it."""
    near = start.copy()
    moving = "held" in switching.name_in()
    for lane in range(len(start)):
        index, q = lane % switching.size1_in("sides"), start[lane]
        for _ in range(_NEWTON):
            sides = np.ones(switching.size1_in("sides"))
            states = (0.0,) if "states" in switching.name_in() else ()
            arguments = [q, 0.0, sides, *states, parameters[lane]]
            if moving and recorded is not None:
                held = np.zeros(switching.size1_in("held"))
                held[-recorded.shape[1] :] = recorded[0, :, lane]
                arguments = [q, 0.0, held, sides, parameters[lane], 0.0]
            values, slopes = switching(*arguments)[:2]
            q -= float(values[index]) / (float(slopes[index]) or np.inf)
        beside = start[lane] if lane % 2 else 0.0
        near[lane] = q + beside if np.isfinite(q) else start[lane]
    return near


def _is_later(
    library: "NativeLibrary", lanes: _Lanes, lane: int, expected: _Result, shaken: _Result
) -> bool:
    """Whether the first sample's motion, a period later, is the second's."""
    status, end, signals = expected
    if shaken[:2] != expected[:2] or (end if status else _LOOP_SAMPLES) <= 1:
        return True
    recorded, settings = lanes.recorded_of(lane), lanes.settings
    lines = np.zeros(0) if recorded is None else recorded[0]
    motion = (signals["position"][:1].copy(), signals["velocity"][:1].copy())
    held = np.concatenate([signals["force"][:1], lines])[None, :]
    period, step = np.array([settings.period]), settings.period / settings.substeps
    found = library.later(motion, held, period, step, lanes.parameters[lane])
    later = dict(zip(("position", "velocity"), found[:2], strict=True))
    return all(
        abs(float(later[name][0]) - signals[name][1]) <= _allowed(size, moved)
        for name, size, moved in _moves(expected, shaken)
        if name in later
    )


def _allowed(size: float, moved: float) -> float:
    """How much a signal may differ, from its size and how far it moves."""
    return MAX_LOOP_DIFFERENCE.value * size + MAX_MAGNIFIED_DIFFERENCE.value * moved


def _same(got: _Result, expected: _Result, shaken: _Result) -> bool:
    """Whether two results agree as far as rounding lets them; `shaken` shows how far that is."""
    status, end, signals = expected
    if shaken[:2] != (status, end):
        return True
    if got[0] != status or (status and got[1] != end):
        return False
    until = end if status else _LOOP_SAMPLES
    for name, size, moved in _moves(expected, shaken):
        wanted, atol = signals[name][:until], _allowed(size, moved)
        if not np.allclose(got[2][name][:until], wanted, rtol=0, atol=atol, equal_nan=True):
            return False
    return True
