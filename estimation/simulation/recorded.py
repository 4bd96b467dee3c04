"""Recorded signals as a simulation takes them: of each its value and its rate, at every sample."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from axisid.codegen.artefacts import GeneratedAxis
from axisid.support.arrays import Array
from axisid.support.errors import UsageError
from axisid.support.user_values import quoted

from .lane_arguments import checked_array
from .two_clocks import TwoClocks


def checked_signals(
    axis: GeneratedAxis, signals: Mapping[str, ArrayLike] | None, samples: int, lanes: int = 0
) -> tuple[Array, ...]:
    """The signals that an axis declares, in its order, (N,) each, or (N, B) in a batch.

    Raises
    ------
    UsageError
        One is missing, is not declared, or has another length.
    """
    if not (signals is None or isinstance(signals, Mapping)):
        raise UsageError(
            f"the signals are {quoted(signals)}; give arrays by name, such as "
            "{'pressure': values}. What is wanted of a batch is `wanted`.",
            code="recorded-type",
        )
    found, names = dict(signals or {}), [signal.name for signal in axis.axis.signals]
    if missing := [name for name in names if name not in found]:
        raise UsageError(
            f"axis {axis.axis.name!r} has the recorded signals {', '.join(names)}, of which "
            f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} not given; give "
            f"signals={{{missing[0]!r}: values}}, one for each sample of the reference.",
            code="recorded-missing",
        )
    if unknown := [name for name in found if name not in names]:
        listed = ", ".join(names) or "none"
        raise UsageError(
            f"axis {axis.axis.name!r} declares no signal {', '.join(map(str, unknown))}; its "
            f"signals are {listed}.",
            code="recorded-unknown",
        )
    shapes = [(samples,), *([(samples, lanes)] if lanes else [])]
    return tuple(checked_array(found[name], f"the signal {name!r}", shapes) for name in names)


def lines(axis: GeneratedAxis, signals: Sequence[Array], period: float) -> Array | None:
    """Value and rate of each signal in turn, (N, 2 s) or (N, 2 s, B); None for no signals.

    Parameters
    ----------
    axis : GeneratedAxis
    signals : sequence of (N,) or (N, B) array
        In the axis's order.
    period : float
        s
    """
    if not signals:
        return None
    shape = np.broadcast_shapes(*(s.shape + (1,) * (2 - s.ndim) for s in signals))
    wide = max(s.ndim for s in signals) > 1
    columns = []
    for declared, values in zip(axis.axis.signals, signals, strict=True):
        here = np.broadcast_to(values if values.ndim > 1 else values[:, None], shape)
        following = here if declared.is_held else np.concatenate([here[1:], here[-1:]])
        columns += [here, (following - here) / period]
    stacked = np.stack(columns, axis=1)
    return np.ascontiguousarray(stacked if wide else stacked[:, :, 0])


def at_law(axis: GeneratedAxis, signals: Sequence[Array], clocks: TwoClocks) -> tuple[Array, ...]:
    """Signals of a log, (N,) each, where its law is evaluated, (M,) each.

    What is held from sample to sample of a log that is faster than the law enters by its mean until
    the next evaluation, unless law or drive read it at the evaluation.
    """
    read = axis.axis.sampled_signals
    return tuple(
        clocks.linear(values)
        if not declared.is_held
        else clocks.held(values)
        if declared.name in read
        else clocks.mean_held(values)
        for declared, values in zip(axis.axis.signals, signals, strict=True)
    )


def before(axis: GeneratedAxis, signals: Sequence[Array]) -> tuple[Array, ...]:
    """Signals just before each sample: what was held until then."""
    return tuple(
        np.concatenate([values[:1], values[:-1]]) if declared.is_held else values
        for declared, values in zip(axis.axis.signals, signals, strict=True)
    )
