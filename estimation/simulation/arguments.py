"""What simulations are given, checked."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.records import check_sample_period
from axisid.support.arrays import Array
from axisid.support.errors import (
    ModelError,
    UsageError,
    first_of,
    is_real,
    is_whole,
    quoted,
    real_array,
)

from .integration_steps import MOST_SUBSTEPS
from .loop_inputs import LoopInputs, law_of
from .multirate import clocks_of


def no_control_law(name: str) -> ModelError:
    """The error of an axis whose loop cannot be closed."""
    return ModelError(
        f"axis {name!r} has no control law, so its closed loop cannot be simulated. Declare one "
        "(the table [control] in TOML, control=... in Python).",
        code="no-control-law",
    )


def checked_loop(
    axis: GeneratedAxis,
    parameters: ArrayLike | Mapping[str, ArrayLike],
    reference: ArrayLike,
    period: float,
    *,
    many: bool = False,
    start: ArrayLike | None = None,
    start_velocity: ArrayLike | None = None,
    memory: ArrayLike | None = None,
    position_noise: ArrayLike | None = None,
    injected: ArrayLike | None = None,
    signals: Mapping[str, ArrayLike] | None = None,
    gains: Mapping[str, ArrayLike] | None = None,
    resolution: float = 0.0,
    substeps: int | None = None,
) -> tuple[Array, LoopInputs]:
    """Parameters, (p,) or (B, p) of many, and what loops are given at the law's evaluations.

    Raises
    ------
    UsageError, ModelError
        As in `simulate` and `simulate_batch`.
    """
    if axis.axis.control is None:
        raise no_control_law(axis.axis.name)
    given = in_order(axis, parameters)
    theta, ref = contiguous(given, "the parameters"), contiguous(reference, "the reference")
    lanes, samples = theta.shape[:many], len(ref) if ref.ndim else 0
    shapes = tuple(dict.fromkeys(((samples,), (samples, *lanes))))
    if (
        theta.shape != (*lanes, len(axis.parameters))
        or ref.shape not in shapes
        or not (ref.size and theta.size and np.isfinite(ref).all())
    ):
        wanted = "(B, p) and (N,) or (N, B)" if many else "(p,) and (N,)"
        raise UsageError(
            f"axis {axis.axis.name!r} has {len(axis.parameters)} parameters "
            f"({', '.join(axis.names)}); those that are given have the shape {theta.shape}, the "
            f"reference {ref.shape}. Give {wanted}, the reference finite.",
            code="simulation-input",
        )
    check_sample_period(period)
    law, counts = law_of(axis), is_real(resolution) and 0 <= resolution < math.inf
    if not counts or (resolution and law.continuous):
        raise UsageError(
            f"the resolution is {quoted(resolution)}; give 0 or more, and 0 with a continuous law, "
            "which takes no samples.",
            code="simulation-input",
        )
    check_whole("the substeps", substeps, MOST_SUBSTEPS)
    begin = ref[0] if start is None else checked_array(start, "the start", lanes)
    if memory is not None:
        response = axis.axis.response
        drive = () if response is None else response.remembered
        names = [*(each.name for each in law.memory), *law.delay_line, *drive]
        what = f"the memory ({', '.join(names) or 'the law remembers nothing'})"
        memory = checked_array(memory, what, (*lanes, len(names)))
    inputs = LoopInputs(
        reference=ref,
        period=period,
        start=LoopStart(
            position=np.broadcast_to(begin, lanes)[()],
            velocity=np.zeros(lanes)[()]
            if start_velocity is None
            else checked_array(start_velocity, "the start velocity", lanes)[()],
            memory=memory,
        ),
        noise=optional_array(position_noise, "the noise", (samples, *lanes)),
        injected=optional_array(injected, "the injected signal", *shapes),
        signals=checked_signals(axis, signals, shapes),
        gains=gains_by_lane(axis, gains, len(theta)),
        resolution=resolution,
    )
    return theta, inputs.at_law(axis, clocks_of(law, samples, period))


def check_whole(what: str, value: int | None, most: int) -> None:
    """Refuse what is given and is no whole number from 1 on."""
    if value is not None and not (is_whole(value) and 1 <= value <= most):
        raise UsageError(
            f"{what} are {quoted(value)}; give a whole number from 1 to {most}.",
            code="simulation-input",
        )


def contiguous(values: ArrayLike, what: str) -> Array:
    """The array as compiled loops read it."""
    return np.require(real_array(values, what), requirements=["C", "A"])


def checked_array(values: ArrayLike, what: str, *shapes: tuple[int, ...]) -> Array:
    """What is given for the samples or the lanes of loops: finite numbers of one of some shapes.

    Raises
    ------
    UsageError
        It has another shape, or a number is not finite.
    """
    array = contiguous(values, what)
    if array.shape not in shapes or not np.all(np.isfinite(array)):
        said = f"has the shape {array.shape}" if array.ndim else f"is {array}"
        wanted = " or ".join(str(shape) if shape else "one number" for shape in shapes)
        raise UsageError(f"{what} {said}; give {wanted}, all finite.", code="simulation-input")
    return array


def optional_array(values: ArrayLike | None, what: str, *shapes: tuple[int, ...]) -> Array | None:
    """The same of what may be left out."""
    return None if values is None else checked_array(values, what, *shapes)


def checked_signals(
    axis: GeneratedAxis,
    signals: Mapping[str, ArrayLike] | None,
    shapes: Sequence[tuple[int, ...]],
) -> tuple[Array, ...]:
    """The signals that an axis declares, in its order, (N,) each, or (N, B) in a batch.

    Raises
    ------
    UsageError
        One is missing, is not declared, or has another length.
    """
    given = {} if signals is None else signals
    if not isinstance(given, Mapping):
        raise UsageError(
            f"the signals are {quoted(given)}; give arrays by name, such as "
            "{'pressure': values}.",
            code="simulation-input",
        )
    names = [signal.name for signal in axis.axis.signals]
    if {*given} != {*names}:
        missing = ", ".join(name for name in names if name not in given)
        unknown = ", ".join(str(name) for name in given if name not in names)
        raise UsageError(
            f"axis {axis.axis.name!r} has the recorded signals {', '.join(names) or 'none'}; "
            f"{missing and f'not given: {missing}. '}{unknown and f'not declared: {unknown}. '}"
            "Give signals={'name': values} with one value for each sample of the reference.",
            code="simulation-input",
        )
    return tuple(checked_array(given[name], f"the signal {name!r}", *shapes) for name in names)


def gains_by_lane(
    axis: GeneratedAxis, gains: Mapping[str, ArrayLike] | None, lanes: int
) -> Array | None:
    """All gains of the law for each lane, (B, g); None where no lane has another.

    Raises
    ------
    ModelError
        The axis has no law whose gains could change, or not that gain.
    UsageError
        There are not as many values as lanes, or they are not finite.
    """
    if not gains:
        return None
    _, law = axis.loop_with(gains)
    by_lane, names = np.tile([*law.gains.values()], (lanes, 1)), [*law.gains]
    for name, given in gains.items():
        values = real_array(given, f"the gain {name}")
        positive = name in law.positive
        bad = np.flatnonzero(~np.isfinite(values) | (positive & (values <= 0)))
        if values.shape not in ((), (lanes,)) or bad.size:
            said = f"has the shape {values.shape}" if values.shape else f"is {values}"
            if bad.size and values.shape:
                said = f"of lane {bad[0]} is {values.flat[bad[0]]:g}"
            raise UsageError(
                f"the gain {name} {said}; give a finite number{' above 0' * positive}, or one for "
                f"each of {lanes} lanes.",
                code="simulation-input",
            )
        by_lane[:, names.index(name)] = values
    return by_lane


def in_order(
    axis: GeneratedAxis, parameters: ArrayLike | Mapping[str, ArrayLike]
) -> ArrayLike | Array:
    """Parameters that are given by name, in the axis's order; others as they are.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : array_like or mapping of str to array_like
        Of names a number each, or one for each lane, (B,).

    Returns
    -------
    (p,) or (B, p) array

    Raises
    ------
    UsageError
        A name is of no parameter, or a parameter has none.
    """
    if not isinstance(parameters, Mapping):
        return parameters
    names = tuple(p.name for p in axis.axis.parameters)
    if {*parameters} != {*names}:
        unknown = [quoted(name) for name in parameters if name not in names]
        missing = [name for name in names if name not in parameters]
        faults = ((unknown, "is no parameter"), (missing, "is missing"))
        said = " and ".join(f"{first_of(each)} {what}" for each, what in faults if each)
        raise UsageError(
            f"the parameters of axis {axis.axis.name!r} by name: {said}; give a value of each of "
            f"{', '.join(names)}.",
            code="simulation-input",
        )
    values = {name: real_array(parameters[name], f"the values of {name}") for name in names}
    if len({each.shape for each in values.values()} - {()}) > 1:
        shapes = ", ".join(f"{name} {each.shape}" for name, each in values.items())
        raise UsageError(
            f"the parameters by name have the shapes {shapes}; give each one number, or one for "
            "each lane.",
            code="simulation-input",
        )
    return np.stack(np.broadcast_arrays(*values.values()), axis=-1)
