"""A simulated loop whose reference comes in blocks: its state goes from each to the next.

Position and velocity are those of the last sample, which is the first of the next block. What the
drive remembers there is in no output: the law is run along the block's motion once more, by the
function that the time loop itself calls. How many steps a sample takes, and how far the loop may be
from its reference, is known of the whole only: a block that asks for more begins the pass anew.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import STATUSES, LoopSettings, LoopStart
from axisid.codegen.runtime import along_samples
from axisid.estimation.simulation import (
    Simulation,
    allowed_distance,
    check_inertia,
    diverged,
    first_substeps,
    first_values,
    further_substeps,
    lines,
    place_at,
    run_loop,
    single_start,
    widened_distance,
)
from axisid.support.arrays import Array

_EVALUATIONS = 4096  # of the law in one call: a function is made for each number of them


class BegunAnewError(Exception):
    """A pass that is to begin anew, its loop with other settings."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopExtent:
    """What a loop needs to know of a whole log before it is simulated block by block.

    Attributes
    ----------
    start : LoopStart
    period : float
        s
    first : float
        The first reference.
    signals : tuple of float
        The first of the recorded signals.
    span : float
        Of the reference.
    most_added : float or None
        Largest test signal on the control; None for none.
    """

    start: LoopStart
    period: float
    first: float
    signals: tuple[float, ...]
    span: float
    most_added: float | None = None


class CarriedLoop:
    """The loop of an axis along a log, with parameters (p,).

    Parameters
    ----------
    axis : GeneratedAxis
        With a law that is evaluated at the samples of the log, and a drive without a path.
    parameters : (p,) array
        As they were estimated.
    extent : LoopExtent

    Raises
    ------
    EstimationError
        The loop cannot be simulated with these parameters.
    """

    def __init__(self, axis: GeneratedAxis, parameters: Array, extent: LoopExtent) -> None:
        self._axis, self.parameters, self._of = axis, parameters, extent
        first = np.array(extent.signals)
        self._start = single_start(
            axis,
            parameters,
            extent.first,
            0.0,
            0.0,
            extent.start.position,
            extent.start.velocity,
            extent.start.memory,
            first,
        )
        check_inertia(axis, parameters, self._start.position, first)
        away = abs(self._start.position - extent.first)
        self._settings = LoopSettings(
            period=extent.period,
            resolution=0.0,
            allowed=allowed_distance(extent.span, away),
            substeps=first_substeps(
                axis, parameters, self._start.position, extent.period, first, samples=1
            ),
        )
        self.begin()

    def begin(self) -> None:
        """Before a pass."""
        self._now, self._done = self._start, 0
        self._before: float | None = None

    def along(
        self,
        reference: Array,
        injected: Array | None,
        signals: tuple[Array, ...],
        *,
        more: bool,
    ) -> Simulation:
        """The loop over the next samples.

        Parameters
        ----------
        reference, injected : (N,) array
            The latter added to the control, or None.
        signals : tuple of (N,) array
            Recorded, in the axis's order.
        more : bool
            Whether the last sample is the first of what comes next; it is then left out.

        Raises
        ------
        BegunAnewError
            The pass is to begin anew.
        EstimationError
            As `simulate` does.
        """
        recorded = lines(self._axis, signals, self._settings.period)
        status, stopped, out = run_loop(
            self._axis,
            self.parameters,
            self._settings,
            (reference, None, injected, self._now),
            recorded,
        )
        self._check(status, stopped, out, signals)
        if self._before is not None:
            out["before"][0] = self._before
        count = len(reference) - more
        if more:
            self._carry(reference, injected, recorded, out)
        self._done += count
        out = {name: values[:count] for name, values in out.items()}
        return Simulation(
            time=self._settings.period * np.arange(self._done - count, self._done, dtype=float),
            direction_before=out.pop("before"),
            measured_position=out["position"],
            recorded=tuple(values[:count] for values in signals),
            **out,
        )

    def _check(
        self, status: int, stopped: int, out: dict[str, Array], signals: tuple[Array, ...]
    ) -> None:
        """Begin anew with more steps or room where a block asks for it, or say what is wrong."""
        settings, axis = self._settings, self._axis
        visited = {n: values[:stopped] if status else values for n, values in out.items()}
        enough = further_substeps(
            axis,
            self.parameters,
            settings.substeps,
            visited,
            settings.period,
            signals,
            len(out["position"]),
        )
        if enough != settings.substeps:
            self._settings = replace(settings, substeps=enough)
            raise BegunAnewError
        if not status:
            return
        if STATUSES[status] == "out of range" and (wider := self._wider()) > settings.allowed:
            self._settings = replace(settings, allowed=wider)
            raise BegunAnewError
        at = place_at(out, stopped, signals)
        raise diverged(axis, self.parameters, status, self._done + stopped, settings.period, at)

    def _wider(self) -> float:
        most = self._of.most_added
        (wider,) = widened_distance(
            self._axis,
            self.parameters[None, :],
            np.array([self._start.position]),
            None,
            None if most is None else np.array([most]),
            0.0,
            np.array(self._of.signals),
        )
        return float(wider)

    def _carry(
        self,
        reference: Array,
        injected: Array | None,
        recorded: Array | None,
        out: dict[str, Array],
    ) -> None:
        """What the loop is at the last sample, from which it goes on."""
        memory = self._now.memory
        if memory is None:
            first = first_values(recorded)
            begin = self._axis.functions["control_start"]
            memory = begin(reference[0], out["position"][0], *first).full().ravel()
        if len(memory):
            memory = self._remembered(memory, reference, injected, recorded, out)
        self._before = float(out["before"][-1])
        self._now = LoopStart(
            position=float(out["position"][-1]),
            velocity=float(out["velocity"][-1]),
            memory=memory,
        )

    def _remembered(
        self,
        memory: Array,
        reference: Array,
        injected: Array | None,
        recorded: Array | None,
        out: dict[str, Array],
    ) -> Array:
        """What the drive remembers at the last sample, (m,), from what it did at the first."""
        count, period = len(reference) - 1, self._settings.period
        along = {
            **dict(zip(_motion(self._axis), (out["position"], out["velocity"]), strict=True)),
            "reference": reference,
            "reference_rate": np.diff(reference, append=reference[-1]) / period,
            "direction": np.sign(out["velocity"]),
            "parameters": self.parameters[:, None],
            "step": np.full(1, period),
        }
        along |= {} if injected is None else {"injected": injected}
        along |= {} if recorded is None else {"signals": recorded.T}
        for begin in range(0, count, _EVALUATIONS):
            part = slice(begin, min(begin + _EVALUATIONS, count))
            law, sizes = _law_over(self._axis, part.stop - part.start)
            # An encoder's error there is none, and a side of the position is nothing to a law.
            given = (along.get(name, np.zeros((size, 1))) for name, size in sizes.items())
            columns = (np.atleast_2d(values) for values in given)
            shape = part.stop - part.start
            wide = (
                np.repeat(each, shape, axis=1) if each.shape[1] == 1 else each[:, part]
                for each in columns
            )
            memory = np.ascontiguousarray(law.call([memory, *wide])[0].full()[:, -1])
        return memory


def _motion(axis: GeneratedAxis) -> list[str]:
    """What position and velocity are called."""
    return list(axis.functions["closed_loop_step"].name_in()[:2])


@lru_cache(maxsize=8)
def _law_over(axis: GeneratedAxis, count: int) -> tuple[Any, dict[str, int]]:
    """What is remembered after so many samples, and the sizes of what else that takes, by name."""
    step = axis.functions["closed_loop_step"]
    sizes = {name: step.size1_in(name) for name in step.name_in() if name != "state"}
    return along_samples(step, count), sizes
