"""A control law along recorded signals by its gains, and the gains with which it gives a control.

A law is run along the record, its slopes by the gains with it, and Gauss-Newton steps are made: one
that is limited, filtered or has an integral is no sum of products of its gains. What the law
remembers at the start is free along with them.
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
    run_with_slopes,
)
from .start import MIN_MEMORY_EFFECT

# of the limit: a control that near may have been cut off, as the log has a converter's noise; a
# right law is the same with more
_NEAR_LIMIT = 0.1

_STEP = 1e-5  # of a gain and of a memory's size, for slopes of what the drive makes of an output
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

    def jacobian(self, point: LawPoint) -> tuple[Array, Array]:
        """How that changes with the logarithm of each gain, (N, g), and each memory at the start.

        The second, (N, m), is 0 where it hardly shows, the first for a gain of 0.
        """
        states, output, slopes = run_with_slopes(self.functions["law_step"], *self._run_of(point))
        output, slopes, free = self._held(output), self._held(slopes), len(point.gains)
        sizes = np.abs(states).max(axis=0, initial=0.0)
        sizes = np.where(np.isfinite(sizes) & (sizes > 0), sizes, 1.0)
        by_gain = self._logged_slopes(output, slopes[:, :free])
        by_start = self._logged_slopes(output, slopes[:, free:] * sizes)
        effect = np.linalg.norm(by_start[_SETTLED:], axis=0)
        by_start[:, effect <= MIN_MEMORY_EFFECT * float(np.linalg.norm(self.control))] = 0.0
        return by_gain, by_start / sizes

    def slope_by_rest(self, point: LawPoint) -> Array:
        """How it changes with the logarithm of a factor of all that no gain multiplies, (N,)."""
        rest = self._applied(replace(point, gains=0.0 * point.gains))
        return self._logged_slopes(self._applied(point), rest[:, None])[:, 0]

    def _logged_slopes(self, output: Array, slopes: Array) -> Array:
        """Slopes of what is logged from those of the output, (N, k)."""
        ends = (
            (self.sloped(output + step), self.sloped(output - step)) for step in _STEP * slopes.T
        )
        columns = [(more - less) / (2 * _STEP) for more, less in ends]
        return np.reshape(columns, slopes.T.shape).T

    def _applied(self, point: LawPoint) -> Array:
        """The output that is applied at each sample, before the drive, (N,)."""
        return self._held(run_law(self.functions["law_step"], *self._run_of(point))[1])

    def _held(self, values: Array) -> Array:
        """Of each evaluation those that are applied at each sample."""
        return np.asarray(values[np.maximum(self.ticks.held - self.law.delay, 0)])

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
            by_gain, by_start = self.jacobian(point)
            columns = [*map(compared, (*by_gain[:, chosen].T, *by_start.T))]
            step = least_step(np.column_stack(columns), residuals, _CLEAR)[0]
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

    def _run_of(self, point: LawPoint) -> tuple[Array, Sequence[Array], Array]:
        """Memory at the start, what is read, and gains."""
        return point.start, (*self.ticks.signals, self._limits), point.gains

    @cached_property
    def _limits(self) -> Array:
        """Of the output at each evaluation, (M,)."""
        sample = np.searchsorted(self.ticks.held, np.arange(len(self.ticks)) + self.late)
        return np.asarray(self.limit[np.minimum(sample, len(self.control) - 1)])
