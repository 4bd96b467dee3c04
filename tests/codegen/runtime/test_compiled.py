"""Compiled code computes what the virtual machine does, over axes of every kind."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from axisid import Axis, build, load_axis
from axisid.codegen.lowering import BLOCK, SIGNALS, LoopSettings, LoopStart
from axisid.codegen.runtime import VirtualLoop, by_sample, is_continuous, recorded_count
from axisid.codegen.runtime.batched_rows import Decimation
from axisid.codegen.runtime.casadi_functions import VECTORS
from axisid.codegen.runtime.library import NativeLibrary
from axisid.codegen.runtime.library_cache import compiled_library
from axisid.modeling import LIBRARY
from tests.axes.recorded import UNRECORDED, recorded_axis
from tests.axes.remembering import bristle, dahl_axis, stack
from tests.axes.simulated import AXES

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("c_compiler")]

GRID: Mapping[str, Axis] = {
    **{name: load_axis(name) for name in LIBRARY},
    **AXES,
    **{axis.name: axis for axis in (bristle(), dahl_axis(), stack())},
    **{kind: recorded_axis(kind) for kind in ("pressure", "supply", "feed")},
}
LITTLE = 1e-15


@dataclass(frozen=True)
class Compiled:
    """A library, the same in the virtual machine, and its parameters, behind them the gains."""

    text: str
    library: NativeLibrary
    functions: Mapping[str, Any]
    parameters: np.ndarray


def compiled(name: str) -> Compiled:
    """The library of an axis."""
    axis = build(GRID[name])
    functions, text = axis.loop.functions if axis.loop else axis.functions, axis.native.text
    library = NativeLibrary(compiled_library(text), functions)
    law = axis.axis.control
    gains = [*law.gains.values()] if law and axis.loop else []
    own = np.where(np.abs(axis.nominal) > 0, axis.nominal, 1.0)
    return Compiled(text, library, functions, np.append(own, gains))


def near(found: np.ndarray, wanted: np.ndarray, moved: np.ndarray) -> bool:
    """Whether values agree to rounding, as far as a little change of all arguments moves them."""
    with np.errstate(invalid="ignore"):
        size = np.max(np.abs(wanted), initial=0.0, where=np.isfinite(wanted))
        allowed = 1e-9 * size + 1e3 * np.abs(moved - wanted)
        same = (np.abs(found - wanted) <= allowed) | (found == wanted)
    return bool(np.all(same | ~np.isfinite(wanted) & ~np.isfinite(found)))


def wrong_functions(of: Compiled, samples: int = 200) -> list[str]:
    """Functions that differ at random points of both signs and many sizes."""
    found = []
    for name in (name for name in of.functions if f"void {name}_rows(" in of.text):
        rng, function, points = np.random.default_rng(0), of.functions[name], []
        for i, of_what in enumerate(function.name_in()):
            shape = (function.size1_in(i), samples)
            values = rng.choice([-1.0, 1.0], shape)
            if of_what == "parameters":
                values = of.parameters[: len(values), None] * rng.uniform(0.8, 1.2, shape)
            elif of_what != "sides":
                values *= 10 ** rng.uniform(-4, 0.2, shape)
            points.append(1e-4 * np.abs(values) if of_what == "step" else values)
        arguments = [
            x[0] if function.name_in(i) not in VECTORS else x.T for i, x in enumerate(points)
        ]
        results = of.library.evaluate(name, arguments)
        here, there = (function.call([x * scale for x in points]) for scale in (1.0, 1 + LITTLE))
        for result, wanted, moved in zip(results, here, there, strict=True):
            if not near(result, *(by_sample(x.full(), samples) for x in (wanted, moved))):
                found.append(name)
    return found


def is_loop_right(of: Compiled, substeps: int, samples: int = 40) -> bool:
    """Whether unlike lanes, together and alone, are what the virtual machine makes of each."""
    rng, lanes = np.random.default_rng(substeps), BLOCK + 1
    sizes = np.logspace(-4, -1, lanes)
    reference = np.cumsum(0.1 * sizes * rng.normal(size=(samples, lanes)), axis=0)
    noise, injected = (1e-2 * sizes * rng.normal(size=reference.shape) for _ in range(2))
    parameters = of.parameters * rng.uniform(0.8, 1.2, (lanes, len(of.parameters)))
    values = recorded_count(of.functions)
    recorded = rng.uniform(0.5, 1.5, (samples, values, lanes)) if values else None
    own = of.functions["plant_step"].size1_in("parameters")
    begin = of.functions["control_start"]
    position, velocity = (0.1 * sizes * rng.normal(size=lanes) for _ in range(2))
    signals = np.zeros((0, lanes)) if recorded is None else recorded[0, ::2]
    gains = [parameters[:, own:].T] if own < len(of.parameters) else []
    memory = begin.call([reference[:1], position[None], *signals[:, None], *gains])[0].full().T
    allowed = np.full(lanes, np.inf)
    allowed[3] = 0.6 * np.max(np.abs(reference[:, 3] - position[3]))
    settings = LoopSettings(
        period=1e-3,
        resolution=0.0 if is_continuous(of.functions) else 1e-6,
        allowed=allowed,
        substeps=substeps,
    )
    start = LoopStart(position=position, velocity=velocity, memory=memory.copy())
    status, ends, batch = of.library.simulate_batch(
        reference, noise, injected, parameters, start, settings, SIGNALS, 1, recorded
    )
    for lane in (0, 3, 11, 24, BLOCK):
        alone = replace(settings, allowed=float(allowed[lane]))
        inputs = [each[:, lane].copy() for each in (reference, noise, injected)]
        given = None if recorded is None else recorded[:, :, lane].copy()
        runs = []
        for scale in (1.0, 1 + LITTLE):
            begins = LoopStart(
                position=position[lane] * scale, velocity=velocity[lane], memory=memory[lane].copy()
            )
            virtual = VirtualLoop(of.functions, parameters[lane] * scale, alone)
            runs.append(virtual.run(*inputs, begins, given))
        (ended, at, wanted), (other, _, moved) = runs
        begins = LoopStart(
            position=position[lane], velocity=velocity[lane], memory=memory[lane].copy()
        )
        one = of.library.simulate(*inputs, parameters[lane], begins, alone, given)
        assert ended == other
        until = at if ended else samples
        together = (status[lane], ends[lane], {n: v[:, lane] for n, v in batch.items()})
        for got in (one, together):
            if got[0] != ended or (ended and got[1] != at):
                return False
            for name in SIGNALS:
                if not near(got[2][name][:until], wanted[name][:until], moved[name][:until]):
                    return False
    return True


@pytest.mark.parametrize("name", GRID)
def test_functions_and_loops_are_those_of_the_virtual_machine(name: str) -> None:
    of = compiled(name)
    assert wrong_functions(of) == []
    assert all(is_loop_right(of, substeps) for substeps in (1, 3))


@pytest.mark.parametrize("name", UNRECORDED)
def test_rows_of_lanes_are_those_of_the_virtual_machine(name: str) -> None:
    """With a delay of the force, and friction of both directions where a force is held."""
    axis, rng = build(GRID[name]), np.random.default_rng(0)
    library = axis.native.lanes
    shape, every = (60, 11), 10
    q, dq, ddq, force = (rng.uniform(0.5, 1.5, shape) for _ in range(4))
    s, before = (rng.choice([-1.0, 1.0], shape) for _ in range(2))
    sets = rng.uniform(0.5, 1.5, (shape[1], len(axis.parameters)))

    def called(function: str, *arguments: np.ndarray) -> np.ndarray:
        flat = [x.reshape(1, -1) if x.shape == shape else x for x in arguments]
        out = by_sample(axis.functions[function].call(flat)[0].full(), q.size)
        return out.reshape(*shape, -1).transpose(0, 2, 1)[every - 1 :: every]

    decimation = Decimation(
        sizes=np.array([0, 60, 0, 60, 0, every, every - 1, 0, 6, 6], dtype=np.int64),
        **{name: np.zeros(8) for name in ("gains", "settled")},
        powers=np.zeros((every + 1, 8)),
        ends=np.zeros((8, 8)),
        direct=1.0,
    )
    made = axis.functions["drive_force"].call([x.reshape(1, -1) for x in (force, q, dq)])[0]
    made = made.full().reshape(shape)
    late = 0.75 * made + 0.25 * np.concatenate([made[:1], made[:-1]])
    row = called("idm_regressor", q, dq, ddq, np.sign(dq))
    found = library.measured(force, (q, dq, ddq), 0.25, None, decimation)
    np.testing.assert_allclose(found[:, : row.shape[1]], row, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found[:, -1], late[every - 1 :: every], rtol=1e-9)
    held = np.concatenate([force[:1], force[:-1]])
    given = [x.reshape(1, -1) for x in (q, dq, held, before)]
    slowed = axis.functions["direct_dynamics"].call([*given, np.tile(sets, (60, 1)).T])[0]
    other = called("idm_regressor", q, dq, slowed.full().reshape(shape), before)
    row = (called("idm_regressor", q, dq, ddq, s) + other) / 2
    found = library.simulated((q, dq, ddq, force, s), before, sets, None, decimation)
    np.testing.assert_allclose(found[:, : row.shape[1]], row, rtol=1e-9, atol=1e-9)
