"""Estimates from logs larger than memory: blocks through the prefilter into a QR factor.

What counts as rest depends on the largest speed, which takes a pass of its own. Of the regression
only the triangular factor is kept, and for the HAC deviations, in a further pass, the products of
neighbouring scores. Instruments take a pass for each loop that is simulated.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from os import PathLike

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.estimation.problems import (
    check_has_rows,
    check_identifiable,
    check_time_known,
    check_visible,
)
from axisid.estimation.records import Extent, LogBlocks, extent, other_period
from axisid.estimation.regression import (
    Solution,
    condition_number,
    factor,
    least_squares,
)
from axisid.estimation.signals import Prefilter
from axisid.estimation.tables import Provenance
from axisid.estimation.thresholds.signals import MIN_INFORMATION_LEFT
from axisid.modeling.declaration import Axis
from axisid.support.errors import EstimationError, UsageError
from axisid.support.remedy import Note, Remedy, Setting
from axisid.support.user_values import is_among, quoted

from .factored import Factored, Scores, factored, long_run
from .instruments import LogOfLoops, StreamedFit, instrumental_fit
from .log_rows import Blocks, LogRows
from .streamed_estimate import StreamedEstimate
from .watched import Watched, injection_point

#: Methods that serve a log in blocks, first the one by default.
STREAMED_METHODS = ("idm-ls", "idm-iv")


def identify_stream(
    axis: Axis | GeneratedAxis,
    blocks: Blocks,
    prefilter: Prefilter | Callable[[float], Prefilter] | None = None,
    *,
    method: str = STREAMED_METHODS[0],
    sample_period: float | None = None,
    provenance: Provenance | None = None,
) -> StreamedEstimate:
    """An estimate from a log that is read in blocks: three to six times, by instruments more often.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        Linear in its parameters.
    blocks : iterable of mappings of str to (N,) array
        Columns by role in SI: position or velocity, both where the velocity was measured too,
        force or control, and time unless `sample_period` is given. Iterating must begin anew
        each time; see `LogBlocks` for files. Instruments take the reference too.
    prefilter : Prefilter, optional
        As in `identify`; or a function that gives it for the sampling period in s, which is known
        after the first pass only.
    method : {"idm-ls", "idm-iv"}
        Instruments simulate the closed loop block by block, once for each iterate.
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
    if not is_among(method, STREAMED_METHODS):
        raise UsageError(
            f"there is no method {quoted(method)} of a log in blocks; choose from "
            f"{', '.join(STREAMED_METHODS)}.",
            code="method-in-blocks",
        )
    _check_axis(generated)
    if provenance is None and isinstance(blocks, LogBlocks):
        provenance = blocks.provenance()
    origin = provenance or Provenance()
    watched = Watched(blocks, injection_point(generated, blocks))
    found = extent(origin.source, watched, sample_period, generated.axis)
    loops = None if method == "idm-ls" else watched.extent(generated, found, origin)
    chosen = prefilter(found.period) if callable(prefilter) else prefilter
    chosen = (chosen or Prefilter()).at_rate_of(found.period)
    rows, first = _measured(generated, blocks, chosen, found, origin.source)
    if loops is None:
        return _estimate(rows, found, origin, _least_squares(rows, first))
    log = LogOfLoops(rows, loops, watched.injected_at)
    return _estimate(rows, found, origin, _by_instruments(log, first))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Solved:
    """An estimate, and the rows of which its deviations are worked out.

    Attributes
    ----------
    rows : LogRows
        With the instruments beside them, if there are any.
    found : Factored
        The measured rows.
    solution : Solution
        Of their factor.
    scores : Scores
    streamed : StreamedFit or None
        By instruments.
    """

    rows: LogRows
    found: Factored
    solution: Solution
    scores: Scores
    streamed: StreamedFit | None = None


def _measured(
    axis: GeneratedAxis, blocks: Blocks, prefilter: Prefilter, found: Extent, source: str
) -> tuple[LogRows, Factored]:
    """The rows, their reversals kept where too little is left without, and their factor."""
    rows = LogRows(axis, blocks, prefilter, found, source)
    first = factored(rows)
    if prefilter.reversals is None and rows.information.remaining < MIN_INFORMATION_LEFT.value:
        rows = LogRows(axis, blocks, replace(prefilter, reversals="keep"), found, source)
        first = factored(rows)
    return rows, first


def _least_squares(rows: LogRows, found: Factored) -> _Solved:
    solution = _solved(rows, found)
    gram = solution.inverse_factor @ solution.inverse_factor.T
    scores = Scores(theta=solution.theta, mixing=gram)
    return _Solved(rows=rows, found=found, solution=solution, scores=scores)


def _by_instruments(log: LogOfLoops, first: Factored) -> _Solved:
    """Instrumental variables, where the loop of least squares turns if that follows the log."""
    start = _solved(log.rows, first).theta
    if log.rows.rest is not None and log.turn_as_loop(start):
        rows = log.without_loop()
        start = _solved(rows, rows.over(factored)).theta
    streamed = instrumental_fit(log, start)
    solution = streamed.fit.solution
    return _Solved(
        rows=log.with_loop(streamed.at),
        found=log.at(streamed.fit.iterates[-1].physical),
        solution=solution,
        scores=Scores(theta=solution.theta, mixing=streamed.mixing),
        streamed=streamed,
    )


def _estimate(
    rows: LogRows, found: Extent, origin: Provenance, solved: _Solved
) -> StreamedEstimate:
    """The estimate with its deviations."""
    axis, solution, size = rows.axis, solved.solution, solved.found.size
    robust, hac, run = long_run(solved.rows, solved.scores, size)
    apart = other_period(axis.axis.control, found.period, found.clock)
    squares = float(solution.residuals @ solution.residuals)
    gram = solution.inverse_factor @ solution.inverse_factor.T
    fit = None if solved.streamed is None else solved.streamed.fit
    return StreamedEstimate(
        axis=axis,
        method=STREAMED_METHODS[fit is not None],
        prefilter=rows.prefilter,
        provenance=replace(origin, doubts=origin.doubts + found.notes),
        samples=found.samples,
        period=found.period,
        rows=size,
        physical=solution.theta,
        covariances={"iid": squares / (size - 1) * gram, "robust": robust, "hac": hac},
        lags=run.lags,
        freedom=np.minimum(run.freedom, size - len(solution.theta)),
        equation_error_percent=100 * math.sqrt(squares) / solved.found.left,
        simulation_error_percent=None if fit is None else fit.iterates[-1].simulation_error_percent,
        iterates=() if fit is None else fit.iterates,
        started="" if fit is None else fit.started,
        remarks=() if fit is None else tuple(map(Note.of, fit.remarks)),
        condition_number=condition_number(solved.found.both[:, :-1]),
        excluded_samples=solved.rows.excluded_samples,
        time_base=apart.note if apart is not None and not apart.confirmed else None,
    )


def _solved(rows: LogRows, found: Factored) -> Solution:
    """Least squares of the factored rows; refused where they cannot tell the parameters."""
    names = [q.label for q in rows.axis.parameters]
    if found.size <= len(names) or not found.left:
        raise EstimationError(
            f"{found.size} rows are left for {len(names)} parameters, with a force of norm "
            f"{found.left:g}; record longer, or decimate less."
        )
    regressor, left = found.both[:, :-1], found.both[:, -1]
    check_visible(
        rows.axis,
        rows.reach,
        regressor,
        left,
        rows=found.size,
        source=rows.source,
        without_turns=rows.rest is not None,
    )
    with np.errstate(all="ignore"):
        return least_squares(left, factor(regressor, names, rows.source))


def _check_axis(axis: GeneratedAxis) -> None:
    check_has_rows(axis.axis)
    check_time_known(axis)
    check_identifiable(axis)
    if not axis.is_linear:
        raise UsageError(
            f"axis {axis.axis.name!r} is not linear in its parameters, which a log read in blocks "
            "cannot serve; ",
            Remedy.of(Setting("stream", given=False), "."),
            code="nonlinear-in-blocks",
        )
