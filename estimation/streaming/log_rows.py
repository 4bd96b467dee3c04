"""The rows of a log that is read in blocks, those of the measured motion and of simulated loops.

The filters run forward and backward, so a row needs samples on both sides: each block is filtered
with as many neighbours as it takes the filters to forget what lies beyond. The rows are those of
`identify` to rounding. A loop is simulated block by block beside the log, and its signals take the
same way as columns of it.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from copy import copy
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.problems import Reach
from axisid.estimation.records import Extent, hold_delay, law_ratio
from axisid.estimation.regression import Equations, InverseForm, loop_equations
from axisid.estimation.signals import (
    DriveAlong,
    Information,
    Motion,
    Prefilter,
    SampledFilter,
    Signals,
    beside_motion,
    check_filter,
    check_without_position,
    checked_control,
    chosen_hold,
    near_turns,
    paired_with_force,
    recorded_signals,
    response_reach,
    rest_below,
    through_path,
)
from axisid.estimation.thresholds.signals import MIN_ROW_WEIGHT, REST_SPEED
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError

from .carried_loop import BegunAnewError
from .loops_beside import TURNING, LoopsBeside, simulation_of

_FORGOTTEN = 1e-20  # what a filter keeps of a sample that a block leaves out

Blocks = Iterable[Mapping[str, Array]]
T = TypeVar("T")


@dataclass(frozen=True, slots=True, kw_only=True)
class Rows:
    """Some rows of a regression.

    Attributes
    ----------
    both : (n, p + 1) array
        Regressor, and the left side less the intercept.
    left : (n,) array
        The left side itself.
    loop : (n, p + 1) array
        Regressor and intercept of the simulated loop; (n, 0) without one.
    places : (n,) array of int
        See `Neighbours`.
    """

    both: Array
    left: Array
    loop: Array
    places: NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Stretch:
    """Columns by role from the sample `begin` on, of which those from `start` to `stop` are due."""

    columns: Mapping[str, Array]
    begin: int
    start: int
    stop: int

    @property
    def due(self) -> slice:
        """Of the columns."""
        return slice(self.start - self.begin, self.stop - self.begin)


class LogRows:
    """The rows of a log, block by block; iterating reads the log anew.

    Parameters
    ----------
    axis : GeneratedAxis
    blocks : iterable of mappings of str to (N,) array
    prefilter : Prefilter
    found : Extent
        Of the log.
    source : str
        For messages.
    """

    def __init__(
        self,
        axis: GeneratedAxis,
        blocks: Blocks,
        prefilter: Prefilter,
        found: Extent,
        source: str,
    ) -> None:
        self.axis, self.blocks, self.source = axis, blocks, source
        self.samples, self.period = found.samples, found.period
        first = next(iter(blocks))
        if "position" not in first:
            check_without_position(axis, source)
        check_filter(prefilter, axis, self.samples, self.period, source)
        hold = chosen_hold(prefilter, axis, measured="force" in first)
        without_turns = prefilter.reversals == "leave-out" or (
            prefilter.reversals is None and axis.has_direction
        )
        self.prefilter = replace(
            prefilter,
            hold=hold,
            reversals="leave-out" if without_turns else "keep",
        )
        late = hold_delay(axis.axis.control, found.period, found.clock)
        self.hold_delay = late if hold == "zoh" else 0.0
        self.held = (law_ratio(axis.axis.control, found.period, found.clock) or 1.0) <= 1
        self.reach_of_drive = response_reach(axis, found.period)
        self.filter = SampledFilter(self.prefilter, self.period)
        self.margins = self.filter.settling(_FORGOTTEN)
        self.turns = self.filter.turn_reach if without_turns else 0
        self.loops = LoopsBeside()
        self.rest = rest_below(self._velocities()) if without_turns else None
        self._begin()

    def beside(self, loops: LoopsBeside, rest: float | None = None) -> "LogRows":
        """The same rows with those of a loop, or without the samples near its reversals.

        `rest` is the speed below which the loop rests whose reversals these are.
        """
        other = copy(self)
        other.loops = loops
        other.rest = self.rest if rest is None else rest
        other._begin()
        return other

    def over(self, reduce: Callable[["LogRows"], T]) -> T:
        """What is made of all rows, in a pass that begins anew where a loop asks for it."""
        while True:
            try:
                return reduce(self)
            except BegunAnewError:
                continue

    def __iter__(self) -> Iterator[Rows]:
        """The rows of the log, so many at a time."""
        self._begin()
        for stretch in self._stretches():
            yield from self._between(stretch)

    def _begin(self) -> None:
        """Before a pass: what it finds beside the rows."""
        self.excluded_samples = 0  # samples near reversals
        self.information = Information(self.axis)
        self.fastest_of_loop = 0.0  # filtered
        self._reaches: list[Reach] = []

    @property
    def reach(self) -> Reach | None:
        """Of the samples of the last pass that are kept."""
        return Reach.joined(self._reaches) if self._reaches else None

    def _velocities(self) -> Iterator[Array]:
        """Filtered velocity, stretch by stretch."""
        for stretch in self._stretches():
            yield self._motion(stretch.columns)[1][stretch.due]

    @property
    def drive(self) -> DriveAlong:
        """The drive along the log's motion, as the hold pairs the two."""
        return DriveAlong(
            axis=self.axis,
            starts=[0],
            period=self.period,
            held=self.held,
            delay=self.hold_delay,
            mean=self.prefilter.hold == "zoh",
        )

    def _motion(self, columns: Mapping[str, Array]) -> Motion:
        """Filtered motion of a stretch; an axis that does without its position may have none."""
        position, velocity = columns.get("position"), columns.get("velocity")
        if position is None:
            position = np.zeros_like(np.asarray(velocity))
        return self.filter.motion(position, velocity, columns.get("acceleration"))

    def _stretches(self) -> Iterator[_Stretch]:
        """The log in overlapping stretches, each sample due in one of them."""
        around = (
            sum(self.margins) + self.turns + self.reach_of_drive + 2
        )  # two more for the central differences
        names = [signal.name for signal in self.axis.axis.signals]
        columns: dict[str, Array] = {}
        begin = done = 0  # sample numbers: first one at hand, first one whose row is not made
        roles = ("position", "velocity", "acceleration", "force", "control", *names)
        for block in self.loops.along(self.axis, self._acting()):
            columns = {
                role: np.concatenate([columns.get(role, np.empty(0)), block[role]])
                for role in (*roles, *self.loops.names)
                if role in block
            }
            end = begin + len(next(iter(columns.values())))
            stop = self.samples if end == self.samples else max(end - around, done)
            if stop > done:
                yield _Stretch(columns=columns, begin=begin, start=done, stop=stop)
                done = stop
                spent = max(done - around - begin, 0)
                columns = {role: values[spent:] for role, values in columns.items()}
                begin += spent

    def _acting(self) -> Iterator[Mapping[str, Array]]:
        """The blocks of the log, each with the control of which the drive makes its force."""
        drive, last = self.axis.axis.drive, None
        for block in self.blocks:
            if not drive.changes_logged or "control" not in block:
                yield block
                continue
            acting, last = through_path(drive.path, block["control"], self.period, last)
            yield {**block, "control": acting}

    def _between(self, stretch: _Stretch) -> Iterator[Rows]:
        """Rows whose samples are due in a stretch."""
        begin, start, stop = stretch.begin, stretch.start, stretch.stop
        f, settings = self.filter, self.prefilter
        motion, smoothing = self.margins
        signals = self._signals(stretch.columns)
        equations = InverseForm(self.axis).equations(signals)
        weights = np.ones(len(signals.force))
        both = np.column_stack(
            [
                equations.regressor,
                equations.left,
                equations.intercept,
                *self._of_loop(stretch),
                weights,
            ]
        )
        near = self._near(stretch, signals)
        both[near] = 0.0
        self.excluded_samples += int(near[stretch.due].sum())
        self._look(signals, equations, near, stretch)
        for first, last in f.weightless_ends(self.samples):
            both[max(first - begin, 0) : max(last - begin, 0)] = 0.0
        rows = f.rows_between(self.samples, start, stop)
        if not rows.size:
            return
        # What the decimation filter sees begins and ends as it does in a whole record.
        cut, end = f.cut
        unsettled = motion + self.turns + self.reach_of_drive + 2 if begin else 0
        low = max(start - smoothing, cut, begin + unsettled)
        high = min(stop + smoothing, self.samples - end)
        both = both[low - begin : high - begin]
        weighted = (both if settings.decimate == 1 else f.smoothed(both))[rows - low]
        heavy = weighted[:, -1] > MIN_ROW_WEIGHT.value
        yield self._checked(weighted[heavy, :-1], rows[heavy] // settings.decimate)

    def _checked(self, kept: Array, places: NDArray[np.int64]) -> Rows:
        """Rows of columns, (n, k)."""
        if not np.all(np.isfinite(kept)):
            raise EstimationError(
                f"the regressor of {self.source} is not finite; check the signals' size."
            )
        p = len(self.axis.parameters)
        left = kept[:, p]
        return Rows(
            both=np.column_stack([kept[:, :p], left - kept[:, p + 1]]),
            left=left,
            loop=kept[:, p + 2 :],
            places=places,
        )

    def _signals(self, columns: Mapping[str, Array]) -> Signals:
        """Filtered motion beside the force, of a stretch."""
        filtered = self._motion(columns)
        recorded = recorded_signals(self.axis, self.source, columns)
        force = columns.get("force")
        if force is None:
            control = checked_control(self.source, columns.get("control"))
            force = self.drive.force(control, filtered, recorded)
        beside = beside_motion(self.axis, recorded, [0])
        return paired_with_force(filtered, force, [0], delay=self.hold_delay, recorded=beside)

    def _of_loop(self, stretch: _Stretch) -> list[Array]:
        """Regressor and intercept of the simulated loop along a stretch, if there is one."""
        loop = self.loops.instruments
        if loop is None:
            return []
        recorded = recorded_signals(self.axis, self.source, stretch.columns)
        simulated = simulation_of(stretch.columns, recorded, self.period)
        if self.rest is not None:
            velocity = self.filter.motion(simulated.position)[1][stretch.due]
            fastest = float(np.abs(velocity).max(initial=0.0))
            self.fastest_of_loop = max(self.fastest_of_loop, fastest)
        form = InverseForm(self.axis)
        found = loop_equations(form, simulated, loop.parameters, self.prefilter.hold)
        return [found.regressor, found.intercept]

    def _near(self, stretch: _Stretch, signals: Signals) -> NDArray[np.bool_]:
        """Which samples of a stretch are near a reversal or a rest that is left out."""
        if self.rest is None:
            return np.zeros(len(signals.force), dtype=bool)
        velocity = signals.velocity
        if self.loops.turning is not None:
            velocity = self.filter.motion(stretch.columns[f"{TURNING}.position"])[1]
        return near_turns(velocity, self.turns, self.rest)

    def _look(
        self,
        signals: Signals,
        equations: Equations,
        near: NDArray[np.bool_],
        stretch: _Stretch,
    ) -> None:
        """Take note of the samples that are due and not dropped."""
        low, high = self.filter.dropped
        kept = np.zeros(len(near), dtype=bool)
        first, last = max(stretch.start, low), min(stretch.stop, self.samples - high)
        kept[first - stretch.begin : max(last, first) - stretch.begin] = True
        found = Reach.of(signals, equations, kept)
        self._reaches += [] if found is None else [found]
        if self.rest is not None and self.loops.turning is None:
            self.information.add(signals, kept, near, self.rest / REST_SPEED.value)
