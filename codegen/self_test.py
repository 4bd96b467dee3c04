"""Whether a compiled axis computes what the virtual machine computes."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .arguments import Array, by_sample, is_scalar
from .compiler import NativeUnavailableError
from .loop_settings import BLOCK, SIGNALS, LoopSettings
from .virtual_loop import VirtualLoop

if TYPE_CHECKING:
    from .native import NativeLibrary

_Result = tuple[int, int, dict[str, NDArray[np.float64]]]  # status, its sample, signals

_TEST_SAMPLES, _TEST_TOLERANCE = 32, 1e-12
_DIFFERENCES = {"plant_rate": 1e-5}  # a root of differences over a millionth magnifies rounding
# Few samples, since an unstable loop magnifies rounding from each to the next; how much it does is
# seen from a start and parameters that are a little off.
_LOOP_SAMPLES, _LOOP_TOLERANCE = 8, 1e-9
_LITTLE, _MAGNIFIED = 1e-15, 1e3
_NEWTON = 5  # steps to where a side changes
_TRIED = (0, 3, 11, 24, BLOCK)  # lanes; the last lies in the second block
_BOUNDED = 3  # the lane that soon leaves its range


def check_library(library: "NativeLibrary", functions: Mapping[str, Any], text: str) -> None:
    """Compare a fresh library with the virtual machine at random points.

    Raises
    ------
    NativeUnavailableError
        They differ.
    """
    _check_functions(library, functions, text)
    if "void simulate_batch(" in text:
        for substeps in (1, 3):
            _check_loop(library, functions, substeps)


def _check_functions(library: "NativeLibrary", functions: Mapping[str, Any], text: str) -> None:
    rng = np.random.default_rng(0)
    for name, function in functions.items():
        if f"void {name}_rows(" not in text:
            continue
        arguments = [
            rng.uniform(
                0.5,
                1.5,
                (function.size1_in(i), _TEST_SAMPLES if is_scalar(function, i) else 1),
            )
            for i in range(function.n_in())
        ]
        if "sides" in function.name_in():
            sides = arguments[function.index_in("sides")]
            sides[:] = rng.choice([-1.0, 1.0], sides.shape)
        if "step" in function.name_in():  # a long step would magnify rounding without bound
            arguments[function.index_in("step")] *= 1e-3
        expected = [
            by_sample(out.full(), _TEST_SAMPLES) for i, out in enumerate(function.call(arguments))
        ]
        tolerance = _DIFFERENCES.get(name, _TEST_TOLERANCE)
        for got, wanted in zip(library.rows(name, arguments), expected, strict=True):
            if not np.allclose(got, wanted, rtol=tolerance, atol=tolerance, equal_nan=True):
                raise NativeUnavailableError(f"the compiled {name} computes wrong values")


def _check_loop(library: "NativeLibrary", functions: Mapping[str, Any], substeps: int) -> None:
    """Compare unlike lanes with the same simulations one by one, native and virtual."""
    rng = np.random.default_rng(substeps)
    lanes = BLOCK + 1
    sizes = np.logspace(-5, 0, lanes)
    reference, noise = (sizes * rng.normal(size=(_LOOP_SAMPLES, lanes)) for _ in range(2))
    noise *= 1e-2
    start = 0.1 * sizes * rng.normal(size=lanes)
    parameters = rng.uniform(
        0.5, 1.5, (lanes, functions["closed_loop_step"].size1_in("parameters"))
    )
    if "switching" in functions:
        start = _near_sides(functions["switching"], parameters, start)
    allowed = np.full(lanes, np.inf)
    allowed[_BOUNDED] = np.max(np.abs(reference[:, _BOUNDED] - start[_BOUNDED])) * 0.9
    continuous = functions["held_acceleration"].size1_in("held") > 1
    period, resolution = 1e-3, 0.0 if continuous else 1e-6
    settings = LoopSettings(
        period=period, resolution=resolution, allowed=allowed, substeps=substeps
    )
    statuses, ends, batch = library.simulate_batch(
        reference, noise, parameters, start, settings, SIGNALS, 1
    )
    for lane in _TRIED:
        own = replace(settings, allowed=float(allowed[lane]))
        given = (np.ascontiguousarray(reference[:, lane]), np.ascontiguousarray(noise[:, lane]))
        one = library.simulate(*given, parameters[lane], start[lane], own)
        expected = VirtualLoop(functions, parameters[lane], own).run(*given, start[lane])
        off = parameters[lane] * (1 + _LITTLE * rng.choice([-1, 1], parameters.shape[1]))
        shaken = VirtualLoop(functions, off, own).run(*given, start[lane] * (1 + _LITTLE))
        beside = {name: values[:, lane] for name, values in batch.items()}
        for got in (one, (int(statuses[lane]), int(ends[lane]), beside)):
            if not _same(got, expected, shaken):
                raise NativeUnavailableError("the compiled time loop computes wrong values")


def _near_sides(switching: Any, parameters: Array, start: Array) -> Array:
    """Starts moved to where a side changes, and some into the place: a few samples then pass it."""
    near = start.copy()
    for lane in range(len(start)):
        index, q = lane % switching.size1_in("sides"), start[lane]
        for _ in range(_NEWTON):
            sides = np.ones(switching.size1_in("sides"))
            values, slopes, _ = switching(q, 0.0, sides, parameters[lane])
            q -= float(values[index]) / (float(slopes[index]) or np.inf)
        beside = start[lane] if lane % 2 else 0.0
        near[lane] = q + beside if np.isfinite(q) else start[lane]
    return near


def _same(got: _Result, expected: _Result, shaken: _Result) -> bool:
    """Whether two results agree as far as rounding lets them; `shaken` shows how far that is."""
    status, end, signals = expected
    if shaken[:2] != (status, end):
        return True
    if got[0] != status or (status and got[1] != end):
        return False
    until = end if status else _LOOP_SAMPLES
    for name in SIGNALS:
        wanted, other = signals[name][:until], shaken[2][name][:until]
        finite = np.isfinite(wanted) & np.isfinite(other)
        size = np.max(np.abs(wanted), initial=0.0, where=finite)
        moved = np.max(np.abs(wanted - other), initial=0.0, where=finite)
        allowed = _LOOP_TOLERANCE * size + _MAGNIFIED * moved
        if not np.allclose(got[2][name][:until], wanted, rtol=0, atol=allowed, equal_nan=True):
            return False
    return True
