"""A control law along recorded signals by its gains, and the gains with which it gives a control.

A law that is limited, filtered or has an integral is no sum of products of its gains: it is run
along the record, with each gain a little larger and smaller, and Gauss-Newton steps are made. What
the law remembers at the start is free along with them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from threading import get_ident
from typing import Any

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, law_functions
from axisid.estimation.records import Record
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array

from .law_run import LawTicks, as_logged, commands_as_logged, late_in_log, least_step, limit_in_log
from .start import MIN_MEMORY_EFFECT

# of the limit: a control that near may have been cut off, as the log has a converter's noise; a
# right law is the same with more
_NEAR_LIMIT = 0.1

_STEP = 1e-5  # of a gain and of a memory's size, for slopes
_ROUNDS, _HALVINGS = 12, 6  # of Gauss-Newton steps, and of each that leads nowhere
_STILL = 1e-7  # relative change of what is left, at which they end
_EXACT = 1e-9  # of the control, what may be left at most where they end too
_LARGEST = 0.5  # step of the logarithm of a gain
_SETTLED = 10  # samples in which the law's memory fills
_BLOCK = 25  # evaluations that are one function: to call one takes longer than to evaluate it
_CLEAR = 1e-8  # singular value of unit columns, by the largest, of what the record shows at all

#: What is made of a control before it is compared: its rows, or a low-pass of them.
Compared = Callable[[Array], Array]


@dataclass(frozen=True, slots=True)
class LawPoint:
    """Gains of a law, (g,), and what it remembers at the first evaluation, (m,)."""

    gains: Array
    start: Array


@dataclass(frozen=True, kw_only=True)
class LawAlong:
    """A law along recorded signals.

    Attributes
    ----------
    law : ControlLaw
        Its gains are those of no run.
    ticks : LawTicks
        What it measured.
    control : (N,) array
        Recorded, without what was added to the law's.
    limit : (N,) array
        Of the output: the drive's where the control is near it, else none, infinite.
    functions : mapping of str to casadi.Function
        The law's, see `law_functions`.
    logged : callable
        What a record has of what the law gives, see `commands_as_logged`.
    sloped : callable
        The same for slopes: but for steps of the drive, which have none.
    late : int
        Samples after which it has it.
    """

    law: ControlLaw
    ticks: LawTicks
    control: Array
    limit: Array
    functions: Mapping[str, Any]
    logged: Compared
    sloped: Compared
    late: int

    @classmethod
    def of(
        cls, axis: GeneratedAxis, law: ControlLaw, ticks: LawTicks, record: Record
    ) -> "LawAlong":
        """A law, which need not be the axis's, along a record of one piece with a control."""
        own = axis.axis.control
        control = np.asarray(record.control) - as_logged(axis, ticks.added_at_samples(law.delay))
        # Behind a lag nothing tells where the command was at its limit.
        hidden = axis.axis.response is not None and axis.axis.drive.logged == "current"
        near = np.abs(control) >= (1 - _NEAR_LIMIT) * limit_in_log(axis)
        return cls(
            law=law,
            ticks=ticks,
            control=control,
            limit=np.where(near & (not hidden), axis.axis.drive.limit, np.inf),
            functions=law_functions(law, axis.axis.signal_symbols),
            logged=partial(commands_as_logged, axis),
            sloped=partial(commands_as_logged, axis, steps=False),
            late=late_in_log(axis) + law.delay - (0 if own is None else own.delay),
        )

    @property
    def declared(self) -> LawPoint:
        """The declared gains, and the memory of an axis at rest."""
        start = self.functions["law_start"](self.ticks.reference[0], self.ticks.position[0])
        return LawPoint(np.array([*self.law.gains.values()], dtype=float), start.full().ravel())

    def output(self, point: LawPoint) -> Array:
        """The law's output when it is applied, whatever the drive's limit, (N,)."""
        return self.logged(self._applied(point))

    def slopes_by_gain(self, point: LawPoint, free: Sequence[int] | None = None) -> Array:
        """How that changes with the logarithm of each gain, or of those that are free, (N, g).

        A gain of 0 has no logarithm, and a slope of 0.
        """
        steps = _STEP * np.diag(point.gains)
        chosen = steps if free is None else steps[[*free]]
        return self._columns([self._slope(point, gains=step) for step in chosen])

    def slopes_by_start(self, point: LawPoint) -> Array:
        """How that changes with each memory at the start, (N, m); by 0 where that hardly shows."""
        _, states = self._run(point)
        largest = np.abs(states).max(axis=0, initial=0.0)
        sizes = np.where(np.isfinite(largest) & (largest > 0), largest, 1.0)
        slopes = [self._slope(point, start=step) for step in _STEP * np.diag(sizes)]
        least = MIN_MEMORY_EFFECT * float(np.linalg.norm(self.control))
        return self._columns(
            [
                slope / size if float(np.linalg.norm(slope[_SETTLED:])) > least else 0 * slope
                for slope, size in zip(slopes, sizes, strict=True)
            ]
        )

    def _columns(self, slopes: Sequence[Array]) -> Array:
        return np.column_stack([np.empty((len(self.control), 0)), *slopes])

    def _slope(
        self, point: LawPoint, gains: Array | float = 0.0, start: Array | float = 0.0
    ) -> Array:
        """The slope of the output along a way that is `_STEP` long, (N,)."""
        more, less = (
            self.sloped(
                self._applied(LawPoint(point.gains + way * gains, point.start + way * start))
            )
            for way in (1, -1)
        )
        return (more - less) / (2 * _STEP)

    def _applied(self, point: LawPoint) -> Array:
        """The output that is applied at each sample, before the drive, (N,)."""
        output, _ = self._run(point)
        return np.asarray(output[np.maximum(self.ticks.held - self.law.delay, 0)])

    def fitted(self, point: LawPoint, compared: Compared, free: Sequence[int]) -> LawPoint:
        """The gains that give a control best, some of them free, with the memory at the start.

        Parameters
        ----------
        point : LawPoint
            Where to begin.
        compared : callable
            What is made of a control before it is compared.
        free : sequence of int
            Places of the gains that may change; none changes its sign.

        Returns
        -------
        LawPoint
            The best that was met.
        """
        if not len(free) + len(point.start):
            return point
        wanted, chosen = compared(self.control), list(free)
        off = wanted - compared(self.output(point))
        enough = (_EXACT * float(np.linalg.norm(wanted))) ** 2
        left, before = float(off @ off), np.inf
        for _ in range(_ROUNDS):
            if not (left > enough and before - left > _STILL * left):
                break
            columns = np.hstack([self.slopes_by_gain(point, chosen), self.slopes_by_start(point)])
            step = least_step(np.column_stack([*map(compared, columns.T)]), off, _CLEAR)[0]
            # The end of the step, or of a shorter one, which leaves less.
            for _ in range(_HALVINGS):
                gains = point.gains.copy()
                gains[chosen] *= np.exp(np.clip(step[: len(chosen)], -_LARGEST, _LARGEST))
                end = LawPoint(gains, point.start + step[len(chosen) :])
                there = wanted - compared(self.output(end))
                if np.all(np.isfinite(there)) and float(there @ there) < left:
                    break
                step = step / 2
            else:
                break
            point, off, before, left = end, there, left, float(there @ there)
        return point

    def _run(self, point: LawPoint) -> tuple[Array, Array]:
        """The output at each evaluation, (M,), and what is remembered after it, (M, m)."""
        count, read = len(self.ticks), self._read
        whole = len(read[0])
        states, output = np.empty((whole, len(point.start))), np.empty(whole)
        arguments = (point.start, *read, np.tile(point.gains, whole))
        _along(self.functions["law_step"], whole // _BLOCK, get_ident())(
            arguments, (states, output)
        )
        return output[:count], states[:count]

    @cached_property
    def _read(self) -> tuple[Array, ...]:
        """What the law reads at each evaluation and the limit of its output, to whole blocks."""
        count = len(self.ticks)
        shown = np.searchsorted(self.ticks.held, np.arange(count) + self.late)
        limits = self.limit[np.minimum(shown, len(self.control) - 1)]
        rest = (0, -count % _BLOCK)
        every = (*self.ticks.signals, limits)
        return tuple(np.pad(values.ravel(), rest, "edge") for values in every)


# A fit runs one law along one record many times; to make such a function takes as long as a run.
@lru_cache(maxsize=16)
def _along(
    step: Any, blocks: int, _thread: int
) -> Callable[[Sequence[Array], Sequence[Array]], None]:
    """Runs a law over so many blocks of evaluations: from arguments into results.

    One for each thread, by its number: places of arguments and results are set before a run.
    """
    last = step.n_in() - 1  # the memory comes first in and first out
    one = step.slice("law", [last, *range(last)], [0, 1])
    function = one.mapaccum(_BLOCK).expand().mapaccum(blocks)
    # To make CasADi's matrices of arrays takes much longer than a run.
    buffer, run = function.buffer()

    def along(arguments: Sequence[Array], results: Sequence[Array]) -> None:
        held = [np.ascontiguousarray(values, dtype=np.float64) for values in arguments]
        for i, values in enumerate(held):
            buffer.set_arg(i, values.data)
        for i, values in enumerate(results):
            buffer.set_res(i, values.data)
        run()

    return along
