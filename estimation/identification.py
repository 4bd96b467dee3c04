"""The four estimators, from an axis and a record to estimates."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from axisid.codegen import GeneratedAxis, as_generated
from axisid.modeling import Axis, AxisidError, ModelError, UsageError

from .arrays import Array, relative_error_percent
from .closed_loop import Simulation, signals_before, simulate
from .covariance import Covariance, Hac, Published, Robust, delta_method
from .errors import DataError, EstimationError
from .estimate import Estimate, Iterate
from .excitation import motion_lacks
from .forms import DirectForm, Equations, Form, InverseForm
from .linear import (
    Factored,
    Solution,
    condition_number,
    factor,
    instrumental_variables,
    least_squares,
)
from .loop_setup import no_control_law
from .prefilter import Prefilter
from .record import Record
from .results import Identification
from .signals import measured_signals, settled

#: Every method: model form, then estimator.
METHODS = ("idm-ls", "ddm-ls", "idm-iv", "ddm-iv")

_MOST_ITERATIONS = 20
# The iteration stops when no parameter moves by more than this share of its deviation.
_STILL = 1e-2
_ROUNDING = 1e-9  # the same as a share of the value, for records without noise
_PERIOD_TOLERANCE = 0.01
_IN_MOTION = 0.25  # of the largest speed
_FEW_ROWS = 10  # for each parameter
_NOT_FOLLOWING = 100.0  # %


def identify(
    axis: Axis | GeneratedAxis,
    record: Record,
    prefilter: Prefilter | None = None,
    methods: Sequence[str] | None = None,
    *,
    lags: int | None = None,
) -> Identification:
    """Identify an axis from a record.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
    record : Record
    prefilter : Prefilter, optional
        The paper's appropriate filter by default.
    methods : sequence of str, optional
        Of `METHODS`. By default all that the axis and the record allow; what they do not allow is
        in `Identification.skipped`, what came to nothing in `Identification.failed`.
    lags : int, optional
        Of the autocorrelation-consistent covariance; chosen from the data by default.

    Raises
    ------
    UsageError, DataError, ModelError, EstimationError
        See each; a method asked for by name raises, whatever the reason.
    """
    generated = as_generated(axis)
    asked = (methods,) if isinstance(methods, str) else methods
    for method in asked or ():
        if method not in METHODS:
            raise UsageError(f"there is no method {method!r}; choose from {', '.join(METHODS)}.")
    if asked is not None and not asked:
        raise UsageError(f"no method is given; choose from {', '.join(METHODS)}.")
    if not isinstance(record, Record):
        raise UsageError(f"the record is {record!r}; read one with read_record(path, axis).")
    prefilter = settled(prefilter or Prefilter(), generated, record)
    study = _Study(generated, record, prefilter, lags)
    estimates: dict[str, Estimate] = {}
    skipped: dict[str, str] = {}
    failed: dict[str, str] = {}
    for method in METHODS if asked is None else dict.fromkeys(asked):
        try:
            # What is not finite is refused by name; NumPy's own warnings would only repeat it.
            with np.errstate(all="ignore"):
                estimates[method] = study.estimate(method)
        except (ModelError, _LoopDataError) as error:
            if asked is not None:
                raise
            skipped[method] = str(error)
        except EstimationError as error:
            if asked is not None or not estimates:
                raise
            failed[method] = str(error)
    return Identification(
        axis=generated,
        record=record,
        prefilter=prefilter,
        estimates=estimates,
        skipped=skipped,
        failed=failed,
    )


class _LoopDataError(DataError):
    """The record does not serve to simulate the loop."""


class _Study:
    """One axis, one record, one prefilter."""

    def __init__(
        self, axis: GeneratedAxis, record: Record, prefilter: Prefilter, lags: int | None
    ) -> None:
        self.axis, self.record, self.prefilter = axis, record, prefilter
        self.covariances: dict[str, Covariance] = {
            "iid": Published(),
            "robust": Robust(),
            "hac": Hac(lags),
        }
        if axis.hidden:
            raise EstimationError(
                f"axis {axis.axis.name!r} cannot be identified: {'; '.join(axis.hidden)}. Declare "
                "the combination as one parameter."
            )
        self._measured = measured_signals(axis, record, prefilter)

    def estimate(self, method: str) -> Estimate:
        """Run one method: regress, map to physical parameters, simulate."""
        model, estimator = method.split("-")
        form = InverseForm(self.axis) if model == "idm" else DirectForm(self.axis)
        if estimator == "iv":
            with _adding("Instruments need it; idm-ls and ddm-ls do without."):
                loop_reference(self.axis, self.record)
        measured = form.equations(self._measured).reduced(self.prefilter, self.record.period)
        with _adding(self._lacking()):
            regressor = factor(
                measured.regressor, [q.expression or q.name for q in form.quantities]
            )
        if estimator == "ls":
            fit = self._fit_once(form, measured, regressor)
        else:
            fit = self._iterate(method, form, measured, regressor)
        return self._result(method, form, measured, fit)

    def _fit_once(self, form: Form, measured: Equations, regressor: Factored) -> "_Fit":
        """Least squares. It needs no simulation; the simulation error is a courtesy."""
        solution = least_squares(measured.left - measured.known, regressor)
        try:
            known, Z = self._simulated(form, form.physical(solution.theta)[0])
        except (ModelError, DataError, EstimationError) as error:
            return _Fit(solution, None, (), None, (f"no simulation error, since {error}",))
        return _Fit(solution, None, (), Z @ solution.theta + known, ())

    def _iterate(self, method: str, form: Form, measured: Equations, regressor: Factored) -> "_Fit":
        """Instruments from the loop simulated with the last estimate, until it stands still."""
        iterates: list[Iterate] = []
        physical, still = self.axis.nominal, False
        solution: Solution | None = None
        instruments: Factored | None = None
        while len(iterates) <= _MOST_ITERATIONS:
            with _naming(f"{method}, iterate {len(iterates)}"):
                known, Z = self._simulated(form, physical)
                theta = form.regressed(physical) if solution is None else solution.theta
                # The loop satisfies the model row by row, so this is its left side.
                simulated = Z @ theta + known
                error = relative_error_percent(measured.left - simulated, measured.left)
                iterates.append(
                    Iterate(physical=physical, theta=theta, simulation_error_percent=error)
                )
                if solution is not None and instruments is not None and still:
                    return _Fit(solution, instruments.columns, tuple(iterates), simulated, ())
                instruments = factor(Z, regressor.names, "the simulated loop")
                solution = instrumental_variables(
                    measured.left - measured.known, regressor, instruments
                )
                following, jacobian = form.physical(solution.theta)
            deviation = np.sqrt(np.diag(delta_method(Published().matrix(solution), jacobian)))
            allowed = _STILL * deviation + _ROUNDING * np.abs(following)
            still = bool(np.all(np.abs(following - physical) <= allowed))
            physical = following
        raise EstimationError(
            f"{method} still moves after {_MOST_ITERATIONS} iterations; the last estimate is "
            f"{self.axis.describe(physical)}. Check the control law against the record, and start "
            "from better nominal values."
        )

    def _simulated(self, form: Form, physical: Array) -> tuple[Array, Array]:
        """Known part and regressor of the loop simulated with an estimate, reduced."""
        reference, period = loop_reference(self.axis, self.record), self.record.period
        loop = simulate(
            self.axis, physical, reference, period, start=float(self.record.position[0])
        )
        return simulated_right(form, loop, physical, self.prefilter, period)

    def _result(self, method: str, form: Form, measured: Equations, fit: "_Fit") -> Estimate:
        solution, y, simulated = fit.solution, measured.left, fit.simulated
        physical, jacobian = form.physical(solution.theta)
        if not (np.any(y) and np.all(np.isfinite(solution.residuals))):
            raise self._not_finite(method, form)
        covariances = {name: c.matrix(solution) for name, c in self.covariances.items()}
        mapped = {name: delta_method(c, jacobian) for name, c in covariances.items()}
        if not np.all(np.isfinite([*mapped.values()])):
            raise self._not_finite(method, form)
        direct = isinstance(form, DirectForm)
        return Estimate(
            method=method,
            form=form,
            quantities=self.axis.parameters,
            theta=solution.theta,
            physical=physical,
            covariances=mapped,
            jacobian=jacobian,
            ddm_quantities=form.quantities if direct else (),
            ddm_covariances=covariances if direct else {},
            y=y,
            X=measured.regressor,
            Z=fit.instruments,
            rows=self.prefilter.rows(len(self.record), self.record.period),
            residuals=solution.residuals,
            simulated=simulated,
            equation_error_percent=relative_error_percent(solution.residuals, y),
            simulation_error_percent=None
            if simulated is None
            else relative_error_percent(y - simulated, y),
            condition_number=condition_number(measured.regressor),
            iterates=fit.iterates,
            covariance_names={name: c.describe(solution) for name, c in self.covariances.items()},
            remarks=(
                *self._remarks(measured, simulated),
                *fit.remarks,
                *_outside_bounds(self.axis, physical),
            ),
            gain_relative_sd=self._gain_deviation(),
        )

    def _lacking(self) -> str:
        facts = motion_lacks(self._measured)
        return f"In this record {', and '.join(facts)}." if facts else ""

    def _gain_deviation(self) -> float | None:
        """Relative deviation of the gain that scaled the force.

        All parameters are proportional to the gain, as long as no known term keeps its size.
        """
        relative = self.axis.axis.drive.relative_sd
        if self.record.force is not None or relative == 0:
            return 0.0
        known = InverseForm(self.axis).equations(self._measured).known
        return None if np.any(known) else relative

    @staticmethod
    def _not_finite(method: str, form: Form) -> EstimationError:
        return EstimationError(
            f"{method}: the regression is not finite, or the {form.left} is zero in every row; "
            "check the signals' size and the known terms of the equation of motion."
        )

    def _remarks(self, measured: Equations, simulated: Array | None) -> list[str]:
        """What the user should know whatever the method."""
        remarks = list(self.prefilter.remarks(self.record.period))
        n, k = measured.regressor.shape
        if n < _FEW_ROWS * k:
            remarks.append(
                f"{n} rows for {k} parameters are few: standard deviations cannot be believed; "
                "record longer, or decimate less"
            )
        if simulated is None:
            return remarks
        if relative_error_percent(measured.left - simulated, measured.left) > _NOT_FOLLOWING:
            remarks.append(
                "the simulated loop does not follow the record; check the control law, the "
                "reference and the signs and units of the columns"
            )
        speed = np.abs(self._measured.velocity)
        if speed[0] > _IN_MOTION * speed.max():
            remarks.append(
                "the record begins in motion, the simulated loop at rest: its first transient is "
                "in the simulation error; begin the record at rest, or drop more at the start"
            )
        return remarks


def loop_reference(axis: GeneratedAxis, record: Record) -> Array:
    """Reference of a loop that was both declared and recorded, (N,); anything less is refused.

    Raises
    ------
    ModelError
        The axis has no control law.
    DataError
        The record has no reference, or another period than the law.
    """
    law = axis.axis.control
    if law is None:
        raise no_control_law(axis.axis.name)
    if record.reference is None:
        raise _LoopDataError(
            f"{record.provenance.source} has no reference column, from which the closed loop "
            "is simulated; name it with --columns reference=NAME."
        )
    if abs(record.period / law.period - 1) > _PERIOD_TOLERANCE:
        raise _LoopDataError(
            f"the record is sampled every {record.period:g} s, the control law of axis "
            f"{axis.axis.name!r} every {law.period:g} s; instruments need a record at the "
            "law's period. Declare the drive's period."
        )
    return record.reference


def simulated_right(
    form: Form, loop: Simulation, physical: Array, prefilter: Prefilter, period: float
) -> tuple[Array, Array]:
    """Known part and regressor of a simulated loop, reduced like the measured ones.

    With `zoh`, the rows just before and just after a sample are averaged, as the measured force is.
    """
    equations = form.equations(loop.signals)
    if prefilter.hold == "zoh":
        equations = equations.mean(form.equations(signals_before(form.axis, physical, loop)))
    return equations.reduced_right(prefilter, period)


@dataclass(frozen=True, slots=True)
class _Fit:
    """A solution with the loop simulated from it."""

    solution: Solution
    instruments: Array | None
    iterates: tuple[Iterate, ...]
    simulated: Array | None
    remarks: tuple[str, ...]


@contextmanager
def _adding(what: str) -> Iterator[None]:
    """Say more in an error, if there is more to say."""
    try:
        yield
    except AxisidError as error:
        if what:
            raise type(error)(f"{error} {what}") from error
        raise


@contextmanager
def _naming(what: str) -> Iterator[None]:
    """Say in an estimation error where it arose."""
    try:
        yield
    except EstimationError as error:
        raise EstimationError(f"{what}: {error}") from error


def _outside_bounds(axis: GeneratedAxis, physical: Array) -> list[str]:
    return [
        f"{p.name} = {value:.6g} {p.unit} is outside its bounds [{p.lower:g}, {p.upper:g}]"
        for p, value in zip(axis.axis.parameters, physical, strict=True)
        if not p.lower <= value <= p.upper
    ]
