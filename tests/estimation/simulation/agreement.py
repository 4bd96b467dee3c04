"""Lanes of a batch, and the virtual machine, against the same loops one by one."""

from collections.abc import Callable
from typing import Any

import numpy as np

from axisid import simulate
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import SIGNALS
from axisid.estimation import simulate_batch
from axisid.support.arrays import Array
from benchmarks.event_integrator import EventIntegrator

LANES = 35  # more than a block has


def _of_lane(value: Any, lane: int) -> Any:
    """What a lane has of an option: its column or row, or what all share."""
    if isinstance(value, dict):
        return {name: _of_lane(each, lane) for name, each in value.items()}
    shape = np.shape(value)
    if shape[-1:] == (LANES,):
        return value[..., lane]
    return value[lane] if shape[:1] == (LANES,) else value


def agree(
    axis: GeneratedAxis,
    thetas: Array,
    reference: Array,
    period: float,
    *,
    machine: GeneratedAxis | None = None,
    rel: float = 1e-9,
    **options: Any,
) -> None:
    """Fail unless lanes (and one in the virtual machine) are what each is alone, by its largest."""
    batch = simulate_batch(axis, thetas, reference, period, wanted=SIGNALS, **options)
    assert not batch.failures
    for lane in (0, 17, LANES - 1):
        own = {name: _of_lane(value, lane) for name, value in options.items()}
        given = thetas[lane], np.ascontiguousarray(_of_lane(reference, lane)), period
        alone = simulate(axis, *given, **own)
        other = None if machine is None or lane else simulate(machine, *given, **own)
        for name in SIGNALS:
            found = getattr(alone, name)
            allowed = rel * max(np.abs(found).max(), 1e-12)
            assert np.abs(batch[name][:, lane] - found).max() <= allowed, (lane, name)
            if other is not None:
                assert np.abs(getattr(other, name) - found).max() <= allowed, name


def followed_by(
    body: EventIntegrator,
    samples: int,
    period: float,
    force: Callable[[int], Callable[..., float]],
    *,
    held: bool = True,
) -> tuple[Array, Array]:
    """Positions and velocities at samples, of an integrator that locates events, by its forces."""
    found = []
    for k in range(samples):
        found.append((body.q, body.v))
        body.advance(force(k), period, held=held)
    position, velocity = np.array(found).T
    return position, velocity
