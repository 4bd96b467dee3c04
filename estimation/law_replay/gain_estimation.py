"""Estimation of the gains of a control law from recorded signals and control.

The gains are found by Gauss-Newton steps, as a law with a limit, a filter or an integral is not
linear in products of its gains. For the derivatives, the law is replayed along the record with each
gain slightly larger. The memory of the law at the start is estimated together with the gains.
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

# distance from the limit, relative to it, in which a control may have been clipped, as the log has
# converter noise; a correct law is not affected by a larger value
_NEAR_LIMIT = 0.1

# relative step of a gain or of the law's memory (its internal state) for derivatives; with a fifth
# of it, rounding hides the difference between the start of an integral and a long integral time
_STEP = 5e-5
_ROUNDS, _STEPS = 12, 6  # of derivatives, and of Gauss-Newton steps with the same derivatives
_STILL = 1e-7  # relative change of the squared residuals at which the iteration ends
_EXACT = 1e-9  # residuals relative to the control at which the iteration ends
_LARGEST = 0.5  # step of the logarithm of any gain
LAW_SETTLING = 10  # samples in which the law's memory fills
_CLEAR = 1e-8  # relative singular value of unit columns, above which the record shows a direction


@dataclass(frozen=True, kw_only=True, eq=False)
class LawReplay:
    """A control law replayed along recorded signals, with some gains and some initial memory.

    The memory of a law is its internal state: an integral, filter states, earlier positions.

    Attributes
    ----------
    law : ControlLaw
        The law with its declared gains.
    ticks : LawInputs
        Inputs of the law at its M evaluations.
    control : (N,) array
        Recorded control minus the signal that was added to that of the law.
    limit : (N,) array
        Limit of the output at each sample: the drive's limit where the control is near it, infinite
        elsewhere.
    limits : (M,) array
        The same limit at each evaluation.
    functions : mapping of str to casadi.Function
        Functions of the law, see `law_functions`.
    logged : callable
        Maps the law's output to the logged control, see `commands_as_logged`.
    gains : (g,) array
        Gains that the replay uses, in the order of the law.
    start : (m,) array
        Memory of the law at the first evaluation.
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
        """Return the replay of any law along a record without gaps, with the law's declared gains.

        Parameters
        ----------
        axis : GeneratedAxis
            Axis with the drive and the signals of the record; its own law is not used.
        law : ControlLaw
            Law that is replayed. Its memory at the start is that of an axis at rest.
        ticks : LawInputs
            Inputs of this law along the record.
        record : Record
            Record with a control.
        """
        # The recorded control, without the test signal that was added to the output of the law.
        control = np.asarray(record.control) - as_logged(axis, ticks.added_at_samples(law.delay))
        # A control logged behind a lag does not show where the command was at its limit.
        hidden = axis.response is not None and axis.drive.logged == "current"
        near = np.abs(control) >= (1 - _NEAR_LIMIT) * limit_in_log(axis)
        limit = np.where(near & (not hidden), axis.drive.limit, np.inf)
        # The sample of the log in which the output of each evaluation appears.
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
        """Return the replay of the axis's law along a simulated loop, within the drive's limit.

        There is no recorded control: `control` is 0. `start` is the memory of the loop at the
        first evaluation; its first m elements are the memory of the law.
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
        """Control of the law at each sample, as the drive logs it, (N,)."""
        return self.logged(self._applied)

    def jacobian_by_gain(self, free: Sequence[int] | slice = slice(None)) -> Array:
        """Return the derivative of `output` by the logarithm of each free gain, (N, g).

        `free` has the indices of the g free gains, by default of all. The derivative by a gain of 0
        is 0.
        """
        # Each row is the gains with one of them larger.
        ends = self.gains + np.diag(_STEP * self.gains)[free]
        return self._slopes([replace(self, gains=end) for end in ends])

    @property
    def slope_by_rest(self) -> Array:
        """Derivative of `output` by the logarithm of a factor of the terms without gains, (N,).

        These terms of the law are its output with all gains 0.
        """
        step = _STEP * replace(self, gains=0.0 * self.gains)._applied
        more, less = (self.logged(self._applied + by, steps=False) for by in (step, -step))
        return np.asarray((more - less) / (2 * _STEP))

    def slopes_by_start(self, compared: Callable[[Array], Array]) -> list[Array]:
        """Return the derivative of compared values by each element of the initial memory.

        It is 0 for an element with a negligible effect: one that has faded before the first
        compared sample cannot be estimated.

        Parameters
        ----------
        compared : callable
            Maps a control, (N,), to the values that are compared, (n,), as in `fitted`.

        Returns
        -------
        list of (n,) array
            One for each of the m elements.
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
        """Return difference quotients of the output, (N, k), from this replay to k others.

        `ends` has these replays, each with one gain or one element of the memory changed by the
        relative step `_STEP`.
        """
        here, *there = (self.logged(each._applied, steps=False) for each in (self, *ends))
        return np.asarray((np.reshape(there, (len(ends), len(here))).T - here[:, None]) / _STEP)

    @cached_property
    def _applied(self) -> Array:
        """Output of the law at each sample, after its delay and before the drive, (N,)."""
        return np.asarray(self._run[1][np.maximum(self.ticks.held - self.law.delay, 0)])

    def fitted(self, compared: Callable[[Array], Array], free: Sequence[int]) -> "LawReplay":
        """Return the replay with the free gains and the initial memory that fit the control best.

        They minimise ``sum (c(u) - c(u_law))^2`` by Gauss-Newton steps, with the recorded control
        u, the control of the law u_law, and `compared` as c. The steps are in the logarithms of the
        gains, so that no gain changes its sign. The derivatives are computed again only where steps
        with the present ones no longer help.

        Parameters
        ----------
        compared : callable
            Maps a control, (N,), to the values that are compared, (n,): a selection of samples, or
            a low-pass.
        free : sequence of int
            Indices of the gains that are fitted; the others keep their values.

        Returns
        -------
        LawReplay
            The replay with the smallest cost; this replay if there is nothing to fit.
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
            for _ in range(_STEPS):  # with the same derivatives as long as they help
                # A step, limited in the logarithms of the gains.
                step = least_squares_step(columns, residuals, _CLEAR)[0]
                # All elements are scaled, as a memory such as an integral changes with a gain.
                step *= share * _LARGEST / np.abs(step[: len(chosen)]).max(initial=_LARGEST)
                gains = best.gains.copy()
                gains[chosen] *= np.exp(step[: len(chosen)])
                end = replace(best, gains=gains, start=best.start + step[len(chosen) :])
                # The step is taken if it reduces the cost. If no step with these derivatives has
                # reduced it, the next is half as long.
                there = wanted - compared(end.output)
                gained = 1 - float(there @ there) / cost
                if gained > 0:
                    best, residuals, cost = end, there, float(there @ there)
                elif cost == before:
                    share /= 2  # the whole step does not reduce the cost
                if not cost or (cost < before and not gained > _STILL):
                    break
        return best

    @cached_property
    def _run(self) -> tuple[Array, Array]:
        """Memory of the law after each evaluation, (M, m), and output of the law, (M,)."""
        read = *self.ticks.signals, self.limits, self.gains[None, :]
        return run_law(self.functions["law_step"], self.start, read)
