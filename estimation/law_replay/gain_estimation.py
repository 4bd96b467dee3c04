"""A control law along recorded signals by its gains, and the gains with which it gives a control.

A law is run along the record, also with each gain a little larger, and Gauss-Newton steps are
made: one that is limited, filtered or has an integral is no sum of products of its gains. What the
law remembers at the start is free along with them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, law_functions
from axisid.estimation.records import Record
from axisid.estimation.signals import (
    as_logged,
    commands_as_logged,
    control_delay_in_log,
    limit_in_log,
)
from axisid.estimation.simulation import law_of
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array, least_squares_step

from .initial_state_of_record import MIN_MEMORY_EFFECT
from .replay import LawInputs, run_law

# of the limit: a control that near may have been cut off, as the log has a converter's noise; a
# right law is the same with more
_NEAR_LIMIT = 0.1

# of a gain and of a memory's size, for slopes; with a fifth, rounding hides how the start of an
# integral differs from a long integral time
_STEP = 5e-5
_ROUNDS, _STEPS = 12, 6  # of slopes, and of Gauss-Newton steps by the same
_STILL = 1e-7  # relative change of the squared residuals, at which they end
_EXACT = 1e-9  # of the control, the residuals at which they end too
_LARGEST = 0.5  # step of the logarithm of any gain
LAW_SETTLING = 10  # samples in which the law's memory fills
_CLEAR = 1e-8  # singular value of unit columns, by the largest, of what the record shows at all


@dataclass(frozen=True, kw_only=True, eq=False)
class LawReplay:
    """A law along recorded signals.

    Attributes
    ----------
    law : ControlLaw
        Its gains are the declared ones.
    ticks : LawInputs
        What it measured.
    control : (N,) array
        Recorded, without what was added to the law's.
    limit : (N,) array
        Of the output: the drive's where the control is near it, else none, infinite.
    limits : (M,) array
        The same at each evaluation.
    functions : mapping of str to casadi.Function
        The law's, see `law_functions`.
    logged : callable
        What a record has of what the law gives, see `commands_as_logged`.
    gains : (g,) array
        That it is run with.
    start : (m,) array
        What it remembers at the first evaluation.
    """

    law: ControlLaw
    ticks: LawInputs
    control: Array
    limit: Array
    functions: Mapping[str, Any]
    limits: Array
    logged: Callable[..., Array]
    gains: Array
    start: Array

    @classmethod
    def of(
        cls, axis: GeneratedAxis, law: ControlLaw, ticks: LawInputs, record: Record
    ) -> "LawReplay":
        """A law, which need not be the axis's, along a record of one piece with a control.

        With its declared gains, and the memory of an axis at rest.
        """
        control = np.asarray(record.control) - as_logged(axis, ticks.added_at_samples(law.delay))
        # Behind a lag nothing tells where the command was at its limit.
        hidden = axis.response is not None and axis.drive.logged == "current"
        near = np.abs(control) >= (1 - _NEAR_LIMIT) * limit_in_log(axis)
        limit = np.where(near & (not hidden), axis.drive.limit, np.inf)
        sample = np.searchsorted(
            ticks.held, np.arange(len(ticks)) + control_delay_in_log(axis, law)
        )
        functions = law_functions(law, axis.signal_symbols)
        start = functions["law_start"](ticks.reference[0], ticks.position[0])
        return cls(
            law=law,
            ticks=ticks,
            control=control,
            limit=limit,
            limits=limit[np.minimum(sample, len(control) - 1)],
            functions=functions,
            logged=partial(commands_as_logged, axis),
            gains=np.array([*law.gains.values()], dtype=float),
            start=start.full().ravel(),
        )

    @classmethod
    def of_loop(cls, axis: GeneratedAxis, ticks: LawInputs, start: Array) -> "LawReplay":
        """The law along a simulated loop, before the drive, whose limit it knows.

        Of what the loop remembers at the start the law's memory comes first.
        """
        law = law_of(axis)
        return cls(
            law=law,
            ticks=ticks,
            control=np.zeros(len(ticks.held)),
            limit=np.full(len(ticks.held), axis.drive.limit),
            limits=np.full(len(ticks), axis.drive.limit),
            functions=law_functions(law, axis.signal_symbols),
            logged=lambda output, **_: output,
            gains=np.array([*law.gains.values()], dtype=float),
            start=start[: len(law.memory)],
        )

    @property
    def output(self) -> Array:
        """The law's output when it is applied, whatever the drive's limit, (N,)."""
        return self.logged(self._applied)

    def jacobian_by_gain(self, free: Sequence[int] | slice = slice(None)) -> Array:
        """How that changes with the logarithm of each gain, or of those that are free, (N, g).

        A gain of 0 has no logarithm, and a slope of 0.
        """
        ends = self.gains + np.diag(_STEP * self.gains)[free]
        return self._slopes([replace(self, gains=end) for end in ends])

    @property
    def slope_by_rest(self) -> Array:
        """How that changes with the logarithm of a factor of all that no gain multiplies, (N,)."""
        step = _STEP * replace(self, gains=0.0 * self.gains)._applied
        more, less = (self.logged(self._applied + by, steps=False) for by in (step, -step))
        return np.asarray((more - less) / (2 * _STEP))

    def slopes_by_start(self, compared: Callable[[Array], Array]) -> list[Array]:
        """How what is compared changes with each memory at the start; by 0 where it hardly does.

        What has faded before the first sample that is compared is left alone: it could be anything.
        """
        sizes = np.abs(self._run[0]).max(axis=0, initial=0.0)
        sizes = np.where(np.isfinite(sizes) & (sizes > 0), sizes, 1.0)
        ends = [replace(self, start=end) for end in self.start + np.diag(_STEP * sizes)]
        effects = [compared(effect) for effect in self._slopes(ends).T]
        least = MIN_MEMORY_EFFECT * float(np.linalg.norm(compared(self.control)))
        return [
            effect / size if float(np.linalg.norm(effect)) > least else 0.0 * effect
            for effect, size in zip(effects, sizes, strict=True)
        ]

    def _slopes(self, ends: "Sequence[LawReplay]") -> Array:
        """Slopes of the output towards laws that are `_STEP` away, (N, k)."""
        here, *there = (self.logged(each._applied, steps=False) for each in (self, *ends))
        return np.asarray((np.reshape(there, (len(ends), len(here))).T - here[:, None]) / _STEP)

    @cached_property
    def _applied(self) -> Array:
        """The output that is applied at each sample, before the drive, (N,)."""
        return np.asarray(self._run[1][np.maximum(self.ticks.held - self.law.delay, 0)])

    def fitted(self, compared: Callable[[Array], Array], free: Sequence[int]) -> "LawReplay":
        """The gains that give the control best, some of them free, with the memory at the start.

        Parameters
        ----------
        compared : callable
            What is made of a control before it is compared: its rows, or a low-pass of them.
        free : sequence of int
            Places of the gains that may change; none changes its sign.

        Returns
        -------
        LawReplay
            With the best that were met.
        """
        best = self
        if not len(free) + len(self.start):
            return best
        wanted, chosen = compared(self.control), list(free)
        residuals = wanted - compared(self.output)
        enough = (_EXACT * float(np.linalg.norm(wanted))) ** 2
        cost, before = float(residuals @ residuals), np.inf
        for _ in range(_ROUNDS):
            if not (cost > enough and before - cost > _STILL * cost):
                break
            by_gain = map(compared, best.jacobian_by_gain(chosen).T)
            columns = np.column_stack([*by_gain, *best.slopes_by_start(compared)])
            before, share = cost, 1.0
            for _ in range(_STEPS):  # by the same slopes as long as they lead on
                step = least_squares_step(columns, residuals, _CLEAR)[0]
                # As a whole: what is remembered at the start goes with a gain, as an integral does.
                step *= share * _LARGEST / np.abs(step[: len(chosen)]).max(initial=_LARGEST)
                gains = best.gains.copy()
                gains[chosen] *= np.exp(step[: len(chosen)])
                end = replace(best, gains=gains, start=best.start + step[len(chosen) :])
                there = wanted - compared(end.output)
                gained = 1 - float(there @ there) / cost
                if gained > 0:
                    best, residuals, cost = end, there, float(there @ there)
                elif cost == before:
                    share /= 2  # where the whole step leaves no less
                if not cost or (cost < before and not gained > _STILL):
                    break
        return best

    @cached_property
    def _run(self) -> tuple[Array, Array]:
        read = *self.ticks.signals, self.limits, self.gains[None, :]
        return run_law(self.functions["law_step"], self.start, read)
