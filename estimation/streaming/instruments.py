"""Instrumental variables of a log that is read in blocks: each iterate takes a pass over it.

The iteration is that of a record in memory. In place of the rows it has their triangular factor,
which has the same norms and products, so that every step is the same but for rounding.
"""

from dataclasses import dataclass

import numpy as np

from axisid.estimation.choices.methods import ROW_LOSSES
from axisid.estimation.methods import (
    Fit,
    IterationState,
    Start,
    Step,
    Steps,
    from_least_squares,
    least_squares_start,
    nominal_start,
)
from axisid.estimation.regression import (
    Columns,
    Equations,
    Form,
    InverseForm,
    PublishedCovariance,
    Solution,
    factor,
)
from axisid.estimation.thresholds.estimates import MAX_SIMULATION_ERROR
from axisid.estimation.thresholds.signals import REST_SPEED
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError

from .carried_loop import CarriedLoop, LoopExtent
from .factored import Factored, factored
from .log_rows import LogRows
from .loops_beside import LoopsBeside

METHOD = "idm-iv"


class LogOfLoops:
    """A log, and loops that are simulated along it.

    Parameters
    ----------
    rows : LogRows
        Without a loop.
    extent : LoopExtent
        Of the loops.
    injected_at : str or None
        What the log's test signal was added to.
    """

    def __init__(self, rows: LogRows, extent: LoopExtent, injected_at: str | None) -> None:
        self.rows, self._extent, self._injected_at = rows, extent, injected_at
        self._turning: CarriedLoop | None = None
        self._last: tuple[Array, Factored] | None = None

    def with_loop(self, physical: Array) -> LogRows:
        """The rows beside those of the loop simulated with parameters (p,)."""
        loop = CarriedLoop(self.rows.axis, physical, self._extent)
        return self._beside(loop)

    def _beside(self, instruments: CarriedLoop | None) -> LogRows:
        loops = LoopsBeside(
            instruments=instruments, turning=self._turning, injected_at=self._injected_at
        )
        return self.rows.beside(loops)

    def without_loop(self) -> LogRows:
        """The rows by themselves."""
        return self._beside(None)

    def at(self, physical: Array) -> Factored:
        """The same, factored; the last is kept."""
        if self._last is None or not np.array_equal(self._last[0], physical):
            self._last = physical, self.with_loop(physical).over(factored)
        return self._last[1]

    def turn_as_loop(self, physical: Array) -> bool:
        """Leave out the reversals and rests of the loop with parameters (p,), if that follows.

        As `bound_record` does: noise makes reversals where there are none.
        """
        try:
            rows = self.with_loop(physical)
            found = rows.over(factored)
        except EstimationError:
            return False
        if not found.unexplained(physical) < MAX_SIMULATION_ERROR.value:
            return False
        self._turning = CarriedLoop(self.rows.axis, physical, self._extent)
        rest = REST_SPEED.value * rows.fastest_of_loop
        self.rows = self.rows.beside(LoopsBeside(), rest)
        return True


@dataclass(frozen=True, slots=True)
class StreamedFit:
    """A fit of a log, by triangular factors in place of rows.

    Attributes
    ----------
    fit : Fit
    at : (p,) array
        Parameters of the loop whose rows are the instruments.
    mixing : (p, p) array
        See `Scores`.
    """

    fit: Fit
    at: Array
    mixing: Array


def instrumental_fit(log: LogOfLoops, physical: Array) -> StreamedFit:
    """Instrumental variables of a log, from its least squares (p,).

    Raises
    ------
    EstimationError
        The iteration comes to no end, or the loop cannot be simulated; the iterate is named.
    """
    form = InverseForm(log.rows.axis)
    made: list[_LogSteps] = []

    def steps(start: Start) -> _LogSteps:
        made.append(_LogSteps(form, start, log))
        return made[-1]

    try:
        start = least_squares_start(form, physical, log.at(physical).unexplained(physical))
    except EstimationError as error:
        start = nominal_start(form, error.note)
    first = steps(start)
    if start.why_not is not None:
        fit = first.fit()
    else:
        fit = from_least_squares(first, lambda why: steps(nominal_start(form, why)))
    (taken,) = (each for each in made if each.ended is not None and each.ended[0] is fit)
    assert taken.ended is not None  # noqa: S101  # of the one that was taken
    step = taken.ended[1]
    k = len(physical)
    mixing = np.linalg.solve(step.simulated.columns[:k], step.solution.influence[:k])
    return StreamedFit(fit, step.start, np.asarray(mixing, dtype=float))


class _LogSteps(Steps):
    """The iteration on a log."""

    def __init__(self, form: Form, start: Start, log: LogOfLoops) -> None:
        super().__init__(METHOD, form, start, ROW_LOSSES[0])
        self._log, self._rows = log, 0
        self.ended: tuple[Fit, Step] | None = None

    @property
    def rest(self) -> float:
        """See `Steps.rest`; it is not looked for."""
        return 0.0

    def _at(self, physical: Array) -> IterationState:
        found = self._log.at(physical)
        self._rows = found.size
        Z, intercept = found.loop
        return self._made(found.equations, physical, (), intercept, Z)

    def _regressor(self, measured: Equations) -> Columns:
        return factor(measured.regressor, [q.label for q in self._form.quantities])

    def _covariance(self, solution: Solution) -> Array:
        # The norm of the residuals is that of all rows, their number is not.
        share = (len(solution.residuals) - 1) / (self._rows - 1)
        return share * PublishedCovariance().matrix(solution)

    def _ended(self, step: Step, reached: IterationState, remarks: tuple[str, ...] = ()) -> Fit:
        fit = super()._ended(step, reached, remarks)
        self.ended = fit, step
        return fit
