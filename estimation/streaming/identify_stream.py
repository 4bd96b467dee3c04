"""Least squares on logs larger than memory: blocks through the prefilter into a QR factor.

The filters run forward and backward, so a row needs samples on both sides: each block is filtered
with as many neighbours as it takes the filters to forget what lies beyond. The rows are those of
`identify` to rounding. What counts as rest depends on the largest speed, which takes a pass of its
own. Of the regression only the triangular factor of ``[X y]`` is kept, and for the HAC deviations,
in a further pass, the products of neighbouring scores.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.estimation.problems import (
    Reach,
    check_has_rows,
    check_identifiable,
    check_time_known,
    check_visible,
)
from axisid.estimation.records import (
    Extent,
    LogBlocks,
    extent,
    hold_delay,
    law_ratio,
    other_period,
)
from axisid.estimation.regression import (
    Equations,
    Hac,
    InverseForm,
    LongRun,
    Solution,
    condition_number,
    factor,
    least_squares,
)
from axisid.estimation.signals import (
    DriveAlong,
    Information,
    Motion,
    Neighbours,
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
from axisid.estimation.tables import Provenance
from axisid.estimation.thresholds.signals import MIN_INFORMATION_LEFT, MIN_ROW_WEIGHT, REST_SPEED
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError, UsageError
from axisid.support.remedy import Remedy, Setting
from axisid.support.user_values import quoted

from .streamed_estimate import StreamedEstimate

_FORGOTTEN = 1e-20  # what a filter keeps of a sample that a block leaves out

Blocks = Iterable[Mapping[str, Array]]


def identify_stream(
    axis: Axis | GeneratedAxis,
    blocks: Blocks,
    prefilter: Prefilter | Callable[[float], Prefilter] | None = None,
    *,
    sample_period: float | None = None,
    provenance: Provenance | None = None,
) -> StreamedEstimate:
    """IDM-LS from a log that is read in blocks, three to six times.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        Linear in its parameters.
    blocks : iterable of mappings of str to (N,) array
        Columns by role in SI: position or velocity, both where the velocity was measured too,
        force or control, and time unless `sample_period` is given. Iterating must begin anew
        each time; see `LogBlocks` for files.
    prefilter : Prefilter, optional
        As in `identify`; or a function that gives it for the sampling period in s, which is known
        after the first pass only.
    sample_period : float, optional
        s
    provenance : Provenance, optional
        Of the log, for the result; by default that of `LogBlocks`.

    Raises
    ------
    UsageError, DataError, EstimationError
        As `identify` does; a log that needs repairs, and an axis that is not linear, are refused.
    """
    generated = as_generated(axis)
    if isinstance(blocks, (str, PathLike)):
        raise UsageError(
            f"the blocks are {quoted(blocks)}; give LogBlocks(file=path, axis=axis).",
            code="blocks-type",
        )
    _check_axis(generated)
    if provenance is None and isinstance(blocks, LogBlocks):
        provenance = blocks.provenance()
    origin = provenance or Provenance()
    found = extent(origin.source, blocks, sample_period, generated.axis)
    chosen = prefilter(found.period) if callable(prefilter) else prefilter
    chosen = (chosen or Prefilter()).at_rate_of(found.period)
    rows = _LogRows(generated, blocks, chosen, found, origin.source)
    triangle, size, left = _factored(rows)
    if chosen.reversals is None and rows.information.remaining < MIN_INFORMATION_LEFT.value:
        kept = replace(chosen, reversals="keep")
        rows = _LogRows(generated, blocks, kept, found, origin.source)
        triangle, size, left = _factored(rows)
    solution = _solved(rows, triangle, size, left)
    robust, hac, long_run = _hac(rows, solution, size)
    apart = other_period(generated.axis.control, found.period, found.clock)
    squares = float(solution.residuals @ solution.residuals)
    gram = solution.inverse_factor @ solution.inverse_factor.T
    return StreamedEstimate(
        axis=generated,
        prefilter=rows.prefilter,
        provenance=replace(origin, doubts=origin.doubts + found.notes),
        samples=found.samples,
        period=found.period,
        rows=size,
        physical=solution.theta,
        covariances={"iid": squares / (size - 1) * gram, "robust": robust, "hac": hac},
        lags=long_run.lags,
        freedom=np.minimum(long_run.freedom, size - len(solution.theta)),
        equation_error_percent=100 * math.sqrt(squares) / left,
        condition_number=condition_number(triangle[:, :-1]),
        excluded_samples=rows.excluded_samples,
        time_base=apart.note if apart is not None and not apart.confirmed else None,
    )


def _solved(rows: "_LogRows", triangle: Array, size: int, left: float) -> Solution:
    """Least squares of the factored rows; refused where they cannot tell the parameters."""
    names = [q.label for q in rows.axis.parameters]
    if size <= len(names) or not left:
        raise EstimationError(
            f"{size} rows are left for {len(names)} parameters, with a force of norm {left:g}; "
            "record longer, or decimate less."
        )
    check_visible(
        rows.axis,
        rows.reach,
        triangle[:, :-1],
        triangle[:, -1],
        rows=size,
        source=rows.source,
        without_turns=rows.rest is not None,
    )
    with np.errstate(all="ignore"):
        return least_squares(triangle[:, -1], factor(triangle[:, :-1], names, rows.source))


def _check_axis(axis: GeneratedAxis) -> None:
    check_has_rows(axis)
    check_time_known(axis)
    check_identifiable(axis)
    if not axis.is_linear:
        raise UsageError(
            f"axis {axis.axis.name!r} is not linear in its parameters, which a log read in blocks "
            "cannot serve; ",
            Remedy.of(Setting("stream", given=False), "."),
            code="nonlinear-in-blocks",
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Rows:
    """Some rows of a regression.

    Attributes
    ----------
    both : (n, p + 1) array
        Regressor, and the left side less the intercept.
    left : (n,) array
        The left side itself.
    places : (n,) array of int
        See `Neighbours`.
    """

    both: Array
    left: Array
    places: NDArray[np.int64]


class _LogRows:
    """The rows of a regression, block by block; iterating reads the log anew."""

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
        self.rest = rest_below(self._velocities()) if without_turns else None
        self._begin()

    def __iter__(self) -> Iterator[_Rows]:
        """The rows of the log, so many at a time."""
        self._begin()
        for piece in self._pieces():
            yield from self._between(*piece)

    def _begin(self) -> None:
        """Before a pass: what it finds beside the rows."""
        self.excluded_samples = 0  # samples near reversals
        self.information = Information(self.axis)
        self._reaches: list[Reach] = []

    @property
    def reach(self) -> Reach | None:
        """Of the samples of the last pass that are kept."""
        return Reach.joined(self._reaches) if self._reaches else None

    def _velocities(self) -> Iterator[Array]:
        """Filtered velocity, stretch by stretch."""
        for columns, begin, start, stop in self._pieces():
            velocity = self._motion(columns)[1]
            yield velocity[start - begin : stop - begin]

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

    def _pieces(self) -> Iterator[tuple[Mapping[str, Array], int, int, int]]:
        """Columns by role from `begin` on, whose samples from `start` to `stop` are due."""
        around = (
            sum(self.margins) + self.turns + self.reach_of_drive + 2
        )  # two more for the central differences
        names = [signal.name for signal in self.axis.axis.signals]
        columns: dict[str, Array] = {}
        begin = done = 0  # sample numbers: first one at hand, first one whose row is not made
        for block in self._acting():
            columns = {
                role: np.concatenate([columns.get(role, np.empty(0)), block[role]])
                for role in ("position", "velocity", "acceleration", "force", "control", *names)
                if role in block
            }
            end = begin + len(next(iter(columns.values())))
            stop = self.samples if end == self.samples else max(end - around, done)
            if stop > done:
                yield columns, begin, done, stop
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

    def _between(
        self, columns: Mapping[str, Array], begin: int, start: int, stop: int
    ) -> Iterator[_Rows]:
        """Rows whose samples are from `start` to before `stop`; the arrays start at `begin`."""
        f, settings = self.filter, self.prefilter
        cut, end = f.cut
        motion, smoothing = self.margins
        rows = f.rows_between(self.samples, start, stop)
        filtered = self._motion(columns)
        recorded = recorded_signals(self.axis, self.source, columns)
        force = columns.get("force")
        if force is None:
            control = checked_control(self.source, columns.get("control"))
            force = self.drive.force(control, filtered, recorded)
        beside = beside_motion(self.axis, recorded, [0])
        signals = paired_with_force(filtered, force, [0], delay=self.hold_delay, recorded=beside)
        equations = InverseForm(self.axis).equations(signals)
        # What the decimation filter sees begins and ends as it does in a whole record.
        unsettled = motion + self.turns + self.reach_of_drive + 2 if begin else 0
        low = max(start - smoothing, cut, begin + unsettled)
        high = min(stop + smoothing, self.samples - end)
        weights = np.ones(len(force))
        both = np.column_stack([equations.regressor, equations.left, equations.intercept, weights])
        near = np.zeros(len(force), dtype=bool)
        if self.rest is not None:
            near = near_turns(signals.velocity, self.turns, self.rest)
            both[near] = 0.0
            self.excluded_samples += int(near[start - begin : stop - begin].sum())
        self._look(signals, equations, near, begin, start, stop)
        for first, last in f.weightless_ends(self.samples):
            both[max(first - begin, 0) : max(last - begin, 0)] = 0.0
        if not rows.size:
            return
        both = both[low - begin : high - begin]
        weighted = (both if settings.decimate == 1 else f.smoothed(both))[rows - low]
        heavy = weighted[:, -1] > MIN_ROW_WEIGHT.value
        kept = weighted[heavy, :-1]
        if not np.all(np.isfinite(kept)):
            raise EstimationError(
                f"the regressor of {self.source} is not finite; check the signals' size."
            )
        yield _Rows(
            both=np.column_stack([kept[:, :-2], kept[:, -2] - kept[:, -1]]),
            left=kept[:, -2],
            places=rows[heavy] // settings.decimate,
        )

    def _look(
        self,
        signals: Signals,
        equations: Equations,
        near: NDArray[np.bool_],
        begin: int,
        start: int,
        stop: int,
    ) -> None:
        """Take note of the samples from `start` to before `stop` that are not dropped."""
        low, high = self.filter.dropped
        kept = np.zeros(len(near), dtype=bool)
        first, last = max(start, low), min(stop, self.samples - high)
        kept[first - begin : max(last, first) - begin] = True
        found = Reach.of(signals, equations, kept)
        self._reaches += [] if found is None else [found]
        if self.rest is not None:
            self.information.add(signals, kept, near, self.rest / REST_SPEED.value)


def _factored(rows: _LogRows) -> tuple[Array, int, float]:
    """Triangular factor of ``[X y]``, (p + 1, p + 1), rows there are, norm of the left side."""
    width = len(rows.axis.parameters) + 1
    triangle, size, squares = np.zeros((width, width)), 0, 0.0
    for piece in rows:
        _, triangle = np.linalg.qr(np.vstack([triangle, piece.both]))
        size += len(piece.both)
        squares += float(piece.left @ piece.left)
    return triangle, size, math.sqrt(squares)


def _hac(rows: _LogRows, solution: Solution, size: int) -> tuple[Array, Array, LongRun]:
    """Covariances as `Robust` and `Hac` have them, and how the latter was found."""
    # The kernel alone: rows are not kept, and a log that is streamed is long.
    found = Hac().long_run(partial(_score_products, rows, solution), size)
    factor = size / (size - len(solution.theta))
    return factor * found.power, factor * found.covariance, found


def _score_products(rows: _LogRows, solution: Solution, lags: int) -> Array:
    """``sum s_t s_(t-lag)'`` of the scores for each lag from 0, (lags + 1, p, p)."""
    influence = solution.inverse_factor @ solution.inverse_factor.T
    width = len(solution.theta)
    products = np.zeros((lags + 1, width, width))
    scores, places = np.empty((0, width)), np.empty(0, dtype=np.int64)
    for piece in rows:
        regressor, left, old = piece.both[:, :-1], piece.both[:, -1], len(scores)
        residuals = left - regressor @ solution.theta
        scores = np.vstack([scores, regressor @ influence * residuals[:, None]])
        places = np.concatenate([places, piece.places])
        order = Neighbours(places)
        for lag in range(lags + 1):
            late, early = order.pairs(lag, first=old)
            products[lag] += scores[late].T @ scores[early]
        keep = max(len(scores) - lags, 0)  # more than are within the lags, where rows are missing
        scores, places = scores[keep:], places[keep:]
    return products
