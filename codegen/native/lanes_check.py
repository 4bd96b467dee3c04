"""Whether compiled rows of lanes are those of the virtual machine."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from axisid.codegen.runtime import by_sample
from axisid.codegen.thresholds.generation import MAX_LOOP_DIFFERENCE
from axisid.support.arrays import Array

from .errors import WrongLibraryError
from .lanes import LaneLibrary, Thinning

_SAMPLES, _LANES, _EVERY, _DELAY = 60, 11, 10, 0.25  # more lanes than registers, and a rest


def check_lanes(library: LaneLibrary, functions: Mapping[str, Any]) -> None:
    """Compare rows that nothing filters with those of the virtual machine, at random motions.

    Raises
    ------
    WrongLibraryError
        They differ.
    """
    rng = np.random.default_rng(0)
    shape = (_SAMPLES, _LANES)
    q, dq, ddq, force = (rng.uniform(0.5, 1.5, shape) for _ in range(4))
    s, before = (rng.choice([-1.0, 1.0], shape) for _ in range(2))
    sets = rng.uniform(0.5, 1.5, (_LANES, functions["direct_dynamics"].size1_in("parameters")))
    rows, thinning = np.arange(_EVERY - 1, _SAMPLES, _EVERY), _unfiltered()
    made = _called(functions, "drive_force", force, q, dq)
    made = (1 - _DELAY) * made + _DELAY * np.concatenate([made[:1], made[:-1]])
    row = _called(functions, "idm_regressor", q, dq, ddq, np.sign(dq))
    found = library.measured(force, (q, dq, ddq), _DELAY, None, thinning)
    _compare(found[:, -1:], made[rows])
    _compare(found[:, : row.shape[1]], row[rows])
    held = np.concatenate([force[:1], force[:-1]])
    slowed = _called(
        functions, "direct_dynamics", q, dq, held, before, np.tile(sets, (_SAMPLES, 1))
    )
    row = _called(functions, "idm_regressor", q, dq, ddq, s)
    row = (row + _called(functions, "idm_regressor", q, dq, slowed[:, 0], before)) / 2
    found = library.simulated((q, dq, ddq, force, s), before, sets, None, thinning)
    _compare(found[:, : row.shape[1]], row[rows])


def _unfiltered() -> Thinning:
    """Every so many samples as they are."""
    blocks = _SAMPLES // _EVERY
    sizes = [0, _SAMPLES, 0, _SAMPLES, 0, _EVERY, _EVERY - 1, 0, blocks, blocks]
    return Thinning(
        sizes=np.array(sizes, dtype=np.int64),
        powers=np.zeros((_EVERY + 1, 8)),
        gains=np.zeros(8),
        settled=np.zeros(8),
        ends=np.zeros((8, 8)),
        direct=1.0,
    )


def _called(functions: Mapping[str, Any], name: str, *arguments: Array) -> Array:
    """The first output of a function at samples of lanes, (N, columns, L)."""
    flat = [a.reshape(1, -1) if a.shape == (_SAMPLES, _LANES) else a.T for a in arguments]
    out = by_sample(functions[name].call(flat)[0].full(), _SAMPLES * _LANES)
    return out.reshape(_SAMPLES, _LANES, -1).transpose(0, 2, 1)


def _compare(found: Array, wanted: Array) -> None:
    allowed = MAX_LOOP_DIFFERENCE.value * (1 + np.abs(wanted))
    same = (np.abs(found - wanted) <= allowed) | ~np.isfinite(wanted)
    if not same.all():
        raise WrongLibraryError("the compiled rows of lanes are wrong")
