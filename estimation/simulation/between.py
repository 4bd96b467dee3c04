"""What a log has of a loop whose law has another clock: the motion between its evaluations.

From the evaluation before a sample the plant goes on as in the simulation itself, under the force
that is held, through every stop, reversal and side on its way.
"""

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopSettings
from axisid.codegen.runtime import VirtualLoop
from axisid.support.arrays import Array
from axisid.support.errors import UsageError

from .two_clocks import TwoClocks


def at_log_samples(
    axis: GeneratedAxis,
    parameters: Array,
    signals: dict[str, Array],
    clocks: TwoClocks,
    recorded: Array | None,
    substeps: int,
) -> dict[str, Array]:
    """Signals of a simulation at the law's evaluations, (M,), at the samples of the log, (N,).

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    signals : dict of str to (M,) array
        By the names of `SIGNALS`; NaN from where the simulation ended early.
    clocks : TwoClocks
    recorded : (M, 2 s) array or None
        Value and rate of each recorded signal.
    substeps : int
        That the simulation took in a sample.

    Returns
    -------
    dict of str to (N,) array
        The same, and ``held``: the force just before a sample.
    """
    last, since = clocks.elapsed
    force = signals["force"]
    earlier = np.concatenate([force[:1], force[:-1]])
    out = {name: values[last] for name, values in signals.items()}
    out["held"] = np.where(since > 0, force[last], earlier[last])
    apart = np.flatnonzero(since > 0)
    if not apart.size:
        return out
    if axis.states:
        raise UsageError(
            f"the log of axis {axis.axis.name!r} is sampled between the evaluations of its law, "
            "where what its friction remembers is not known; give the law's period, or whole "
            "multiples of it.",
            code="clocks-and-states",
        )
    begin, span = last[apart], since[apart]
    lines = np.zeros((len(force), 0)) if recorded is None else recorded
    position, velocity, direction = _later(
        axis,
        parameters,
        (signals["position"][begin], signals["velocity"][begin]),
        np.column_stack([force, lines])[begin],
        span,
        clocks.law_period / substeps,
    )
    then = lines[begin, ::2] + span[:, None] * lines[begin, 1::2]
    (acceleration,) = axis.evaluate(
        "direct_dynamics", position, velocity, force[begin], direction, *then.T, parameters
    )
    sticks = (velocity == 0) & (np.abs(direction) < 1)
    out["position"][apart], out["velocity"][apart] = position, velocity
    out["direction"][apart] = out["direction_before"][apart] = direction
    out["acceleration"][apart] = np.where(sticks, 0.0, acceleration[:, 0])
    return out


def _later(
    axis: GeneratedAxis,
    parameters: Array,
    motion: tuple[Array, Array],
    held: Array,
    span: Array,
    step: float,
) -> tuple[Array, Array, Array]:
    """As `NativeLibrary.later`: native, or in the virtual machine."""
    library = axis.native.library()
    if library is not None:
        return library.later(motion, held, span, step, parameters)
    settings = LoopSettings(period=step, resolution=0.0, allowed=np.inf, substeps=1)
    return VirtualLoop(axis.functions, parameters, settings).later(motion, held, span, step)
