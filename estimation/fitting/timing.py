"""The drive's lag or its delay, free in a fit: loops are generated anew where a search ends."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, build
from axisid.estimation.choices import OPEN_LOOP
from axisid.estimation.identification import check_time
from axisid.estimation.records import Record
from axisid.modeling.declaration import HIDDEN_FROM
from axisid.modeling.quantities import Parameter
from axisid.support.errors import EstimationError, UsageError, quoted

from .result import OutputFit
from .starting import StartLike

# periods from the loop's own drive time, where the output is a straight line of it and the loop
# need not be generated anew
_MAX_TIME_STEP = 0.01

_ROUNDS = 8
_FURTHEST = 2.0  # periods, by which a time moves in a round
_LEAST = 0.1  # of a period, that a search starts from

#: Searches with the loop of an axis, from a start, about its time.
Search = Callable[[GeneratedAxis, StartLike, Parameter | None], OutputFit]


def split_free(
    free: object, axis: GeneratedAxis, records: Sequence[Record], outputs: Sequence[str]
) -> tuple[Sequence[str], Parameter | None]:
    """What is free of the law, and of the drive: its lag or its delay, or neither.

    Raises
    ------
    UsageError
        They are no names; both times are asked for, or one that the records cannot show, or that
        no loop can be simulated with.
    """
    names = (free,) if isinstance(free, str) else free
    if not isinstance(names, (tuple, list)) or not all(isinstance(name, str) for name in names):
        raise UsageError(
            f"what is free is {quoted(free)}; give names of the law's gains, gain, lag or delay of "
            "the drive, or start.",
            code="free",
        )
    law, drive = axis.declared.control, axis.declared.drive
    gains = {} if law is None else law.gains
    times = [name for name in dict.fromkeys(names) if name in HIDDEN_FROM and name not in gains]
    declared = drive.estimated
    if declared is not None and declared[0] not in times:
        times.append(declared[0])
    if not times:
        return names, None
    if len(times) > 1:
        raise UsageError(
            "lag and delay of the drive are both free, and a record shows their sum; leave one of "
            "them as it is declared.",
            code="free",
        )
    name = times[0]
    if axis.declared.states:
        raise UsageError(
            f"the drive's {name} cannot be free: the friction of axis {axis.declared.name!r} "
            "remembers, and is simulated with no drive whose force changes between the samples "
            "of the law; leave it as it is declared.",
            code="free",
        )
    for record in records:
        check_time(axis.declared, record, name, by_law=OPEN_LOOP not in outputs)
    value = max(float(getattr(drive, name)), _LEAST * records[0].period)
    parameter = declared[1] if declared is not None else Parameter(name, "s", lower=0.0)
    return [n for n in names if n != name], replace(parameter, name=name, nominal=value)


def time_in(axis: GeneratedAxis, name: str) -> float:
    """The time of a drive that a loop is generated for, s."""
    return float(getattr(axis.declared.drive, name))


def with_time_found(
    axis: GeneratedAxis,
    time: Parameter | None,
    start: StartLike,
    search: Search,
    period: float,
) -> OutputFit:
    """Where a search ends whose loop has the time that it finds.

    The period is that of the records, s: an open loop has no law with one.

    Raises
    ------
    EstimationError
        The time does not settle.
    """
    if time is None:
        return search(axis, start, None)
    value = time_in(axis, time.name)
    began: OutputFit | None = None
    for _ in range(_ROUNDS):
        solution = search(at_time(axis, time.name, value), start, time)
        began = began or solution
        found = solution.best.physical
        moved = float(np.clip(found[-1] - value, -_FURTHEST * period, _FURTHEST * period))
        start = dict(zip(solution.unknowns.names, map(float, found), strict=True))
        if abs(moved) < _MAX_TIME_STEP * period:
            return solution.begun_as(began)
        value = max(value + moved, 0.0)
    raise EstimationError(
        f"the drive's {time.name} does not settle; it is about {value:.3g} s. See whether the law "
        "and the model are right.",
        code="no-convergence",
    )


def at_time(axis: GeneratedAxis, name: str, value: float) -> GeneratedAxis:
    """The axis with another time; to compile its loop takes less than a search without does."""
    declared = axis.declared
    drive = declared.drive.with_time(name, value)
    return build(replace(declared, drive=drive), native=axis.native.enabled)
