"""A control law along recorded signals by its gains, and the gains with which it gives a control.

A law is run along the record, with each gain a little larger and smaller, and Gauss-Newton steps
are made: one that is limited, filtered or has an integral is no sum of products of its gains. What
the law remembers at the start is free along with them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, law_functions
from axisid.estimation.records import Record
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array

from .law_run import (
    LawInputs,
    as_logged,
    commands_as_logged,
    late_in_log,
    least_step,
    limit_in_log,
    run_law,
)
from .start import MIN_MEMORY_EFFECT

# of the limit: a control that near may have been cut off, as the log has a converter's noise; a
# right law is the same with more
_NEAR_LIMIT = 0.1

_STEP = 1e-5  # of a gain and of a memory's size, for slopes
_ROUNDS, _HALVINGS = 12, 6  # of Gauss-Newton steps, and of each that leads nowhere
_STILL = 1e-7  # relative change of the squared residuals, at which they end
_EXACT = 1e-9  # of the control, the residuals at which they end too
_LARGEST = 0.5  # step of the logarithm of a gain
_SETTLED = 10  # samples in which the law's memory fills
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
    ticks : LawInputs
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
    ticks: LawInputs
    control: Array
    limit: Array
    functions: Mapping[str, Any]
    logged: Compared
    sloped: Compared
    late: int

    @classmethod
    def of(
        cls, axis: GeneratedAxis, law: ControlLaw, ticks: LawInputs, record: Record
    ) -> "LawAlong":
        """A law, which need not be the axis's, along a record of one piece with a control."""
        declared = axis.axis.control
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
            late=late_in_log(axis) + law.delay - (0 if declared is None else declared.delay),
        )

    @property
    def declared(self) -> LawPoint:
        """The declared gains, and the memory of an axis at rest."""
        start = self.functions["law_start"](self.ticks.reference[0], self.ticks.position[0])
        return LawPoint(np.array([*self.law.gains.values()], dtype=float), start.full().ravel())

    def output(self, point: LawPoint) -> Array:
        """The law's output when it is applied, whatever the drive's limit, (N,)."""
        return self.logged(self._applied(point))

    def jacobian_by_gain(self, point: LawPoint, free: Sequence[int] | None = None) -> Array:
        """How that changes with the logarithm of each gain, or of those that are free, (N, g).

        A gain of 0 has no logarithm, and a slope of 0.
        """
        places = [*range(len(point.gains))] if free is None else [*free]
        steps = np.diag(_STEP * np.abs(point.gains))[places]
        return self._slopes(point, "gains", steps) * np.sign(point.gains[places])

    def slope_by_rest(self, point: LawPoint) -> Array:
        """How that changes with the logarithm of a factor of all that no gain multiplies, (N,)."""
        output = self._applied(point)
        step = _STEP * self._applied(replace(point, gains=0.0 * point.gains))
        return (self.sloped(output + step) - self.sloped(output - step)) / (2 * _STEP)

    def jacobian_by_start(self, point: LawPoint) -> Array:
        """How that changes with each memory at the start, (N, m); by 0 where that hardly shows."""
        sizes = np.abs(self._run(point)[0]).max(axis=0, initial=0.0)
        sizes = np.where(np.isfinite(sizes) & (sizes > 0), sizes, 1.0)
        slopes = self._slopes(point, "start", np.diag(_STEP * sizes)) / sizes
        effect = np.linalg.norm(slopes[_SETTLED:], axis=0) * sizes
        slopes[:, effect <= MIN_MEMORY_EFFECT * float(np.linalg.norm(self.control))] = 0.0
        return slopes

    def _slopes(self, point: LawPoint, name: str, steps: Array) -> Array:
        """Slopes of the output by the gains or the start, by steps (k, g) of `_STEP`, (N, k)."""
        slopes, at = np.empty((len(self.control), len(steps))), getattr(point, name)
        for column, step in zip(slopes.T, steps, strict=True):
            ends = (replace(point, **{name: at + s}) for s in (step, -step))
            more, less = (self.sloped(self._applied(end)) for end in ends)
            column[:] = (more - less) / (2 * _STEP)
        return slopes

    def _applied(self, point: LawPoint) -> Array:
        """The output that is applied at each sample, before the drive, (N,)."""
        _, output = self._run(point)
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
        residuals = wanted - compared(self.output(point))
        enough = (_EXACT * float(np.linalg.norm(wanted))) ** 2
        cost, before = float(residuals @ residuals), np.inf
        for _ in range(_ROUNDS):
            if not (cost > enough and before - cost > _STILL * cost):
                break
            columns = np.hstack(
                [self.jacobian_by_gain(point, chosen), self.jacobian_by_start(point)]
            )
            step = least_step(np.column_stack([*map(compared, columns.T)]), residuals, _CLEAR)[0]
            for _ in range(_HALVINGS):  # where the whole step leaves no less
                gains = point.gains.copy()
                gains[chosen] *= np.exp(np.clip(step[: len(chosen)], -_LARGEST, _LARGEST))
                end = LawPoint(gains, point.start + step[len(chosen) :])
                there = wanted - compared(self.output(end))
                if np.all(np.isfinite(there)) and float(there @ there) < cost:
                    break
                step = step / 2
            else:
                break
            point, residuals, before, cost = end, there, cost, float(there @ there)
        return point

    def _run(self, point: LawPoint) -> tuple[Array, Array]:
        """What is remembered after each evaluation, (M, m), and the output there, (M,)."""
        signals = *self.ticks.signals, self._limits
        return run_law(self.functions["law_step"], point.start, signals, point.gains)

    @cached_property
    def _limits(self) -> Array:
        """Of the output at each evaluation, (M,)."""
        sample = np.searchsorted(self.ticks.held, np.arange(len(self.ticks)) + self.late)
        return np.asarray(self.limit[np.minimum(sample, len(self.control) - 1)])
