"""Estimates of one record by each method, with covariances, bias and remarks."""

from contextlib import suppress

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.regression import (
    Covariance,
    DirectForm,
    Equations,
    Form,
    Hac,
    InverseForm,
    Published,
    Robust,
    condition_number,
    delta_method,
    least_squares,
    loop_reference,
    variable_projection,
)
from axisid.estimation.signals import FilteredRecord, rests_first
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import DataError, EstimationError, ModelError

from .estimate import Estimate
from .filter_bias import filter_bias, slopes_by_gain
from .instrumental import Iteration, at_point
from .problem import Fit, Regressions, adding
from .visibility import FEW_ROWS

#: Every method: model form, then estimator.
METHODS = ("idm-ls", "ddm-ls", "idm-iv", "ddm-iv")

#: What residuals may be assumed to be: autocorrelated, of any variance, alike and independent.
COVARIANCES = ("hac", "robust", "iid")

_IN_MOTION = 0.25  # of the largest speed
_NOT_FOLLOWING = 100.0  # %
_AT_BOUND = 1e-6


class Study:
    """The estimates of one axis from one record."""

    def __init__(
        self,
        data: FilteredRecord,
        lags: int | None,
        covariance: str,
    ) -> None:
        axis = data.axis
        self.axis, self.record, self.prefilter = axis, data.record, data.prefilter
        self.covariances: dict[str, Covariance] = {
            "iid": Published(),
            "robust": Robust(),
            "hac": Hac(lags),
        }
        self.chosen = covariance
        if axis.hidden:
            raise EstimationError(
                f"axis {axis.axis.name!r} cannot be identified: {'; '.join(axis.hidden)}. Declare "
                "the combination as one parameter."
            )
        self._on = Regressions(data)

    def estimate(self, method: str) -> Estimate:
        """Run one method: regress, map to physical parameters, simulate."""
        model, estimator = method.split("-")
        form: Form = InverseForm(self.axis) if model == "idm" else DirectForm(self.axis)
        if estimator == "iv":
            with adding("Instruments need it; idm-ls and ddm-ls do without."):
                loop_reference(self.axis, self.record)
        if not self.axis.is_linear:
            # Both estimators start where least squares ends; it searches more widely.
            form = self._nearest(form)
        # What the record shows of a parameter is a matter of its own column, which only the
        # inverse model has.
        self._on.rows(form if isinstance(form, InverseForm) else InverseForm(self.axis))
        fit = self._fit_once(form) if estimator == "ls" else Iteration(method, form, self._on).fit()
        return self._result(method, form, fit)

    def _nearest(self, form: Form) -> Form:
        """A partially linear model linearised about its least-squares estimate."""
        if not isinstance(form, InverseForm):
            return form
        return form.at(variable_projection(form, self._on.rows))

    def _fit_once(self, form: Form) -> Fit:
        """Least squares. It needs no simulation; the simulation error is a courtesy."""
        measured = self._on.rows(form)
        regressor = self._on.factored(form, measured)
        solution = least_squares(measured.left - measured.known, regressor)
        if not self.axis.is_linear:
            # The search ends within the bounds, where a step of the linearised model might not.
            solution = at_point(solution, measured, form.start)
        try:
            loops, known, Z = self._on.simulated(form, form.physical(solution.theta)[0])
        except (ModelError, DataError, EstimationError) as error:
            reason = f"no simulation error, since {error}"
            fault = str(error) if isinstance(error, EstimationError) else ""
            return Fit(measured, solution, None, (), (), None, (reason,), fault)
        return Fit(measured, solution, None, (), loops, Z @ solution.theta + known, ())

    def _result(self, method: str, form: Form, fit: Fit) -> Estimate:
        measured, solution, simulated = fit.measured, fit.solution, fit.simulated
        y = measured.left
        physical, jacobian = form.physical(solution.theta)
        if not (float(y @ y) > 0 and np.all(np.isfinite(solution.residuals))):
            raise self._not_finite(method, form)
        covariances = {name: c.matrix(solution) for name, c in self.covariances.items()}
        mapped = {name: delta_method(c, jacobian) for name, c in covariances.items()}
        if not np.all(np.isfinite([*mapped.values()])):
            raise self._not_finite(method, form)
        direct = isinstance(form, DirectForm)
        return Estimate(
            method=method,
            form=form.at(physical),
            quantities=self.axis.parameters,
            theta=solution.theta,
            physical=physical,
            covariances=mapped,
            jacobian=jacobian,
            ddm_quantities=form.quantities if direct else (),
            ddm_covariances=covariances if direct else {},
            y=y,
            X=measured.regressor,
            Z=None if fit.instruments is None else fit.instruments.columns,
            rows=self._row_numbers,
            times=self._row_times,
            period=self.record.period,
            residuals=solution.residuals,
            simulated=simulated,
            equation_error_percent=relative_error_percent(solution.residuals, y),
            simulation_error_percent=None
            if simulated is None
            else relative_error_percent(y - simulated, y),
            condition_number=condition_number(measured.regressor),
            iterates=fit.iterates,
            covariance_names={name: c.describe(solution) for name, c in self.covariances.items()},
            not_simulated=fit.not_simulated,
            remarks=(
                *self._remarks(measured, simulated),
                *fit.remarks,
                *_outside_bounds(self.axis, physical),
            ),
            assumed=self.covariances[self.chosen],
            chosen=self.chosen,
            gain_relative_sd=self._gain_relative_sd,
            **self._bias_and_slopes(form.at(physical), fit, physical),
        )

    @property
    def _gain_relative_sd(self) -> float:
        """Of the gain that scaled the force; 0 for a measured force."""
        return 0.0 if self.record.force is not None else self.axis.axis.drive.relative_sd

    @property
    def _row_numbers(self) -> Array:
        return self._on.data.row_numbers

    @property
    def _row_times(self) -> Array | None:
        """Of a record with gaps, since its first sample."""
        if not self.record.segments:
            return None
        times = self.record.time[self._row_numbers.astype(int)] - self.record.time[0]
        return np.asarray(times, dtype=float)

    def _bias_and_slopes(self, form: Form, fit: Fit, physical: Array) -> dict[str, Array | None]:
        """What the gain and the filter alone move the estimate by."""
        bias: Array | None = None
        slopes: tuple[Array | None, Array | None] = (None, None)
        if self._gain_relative_sd:
            with suppress(DataError, EstimationError):  # rows of another gain may not be solved
                slopes = slopes_by_gain(form, self._on.data, fit.instruments)
        if fit.follows:
            with suppress(DataError, EstimationError):  # nor those of a simulated record
                bias = filter_bias(form, self._on.data, fit.loops, physical, fit.instruments)
        return {"gain_slopes": slopes[0], "theta_gain_slopes": slopes[1], "filter_bias": bias}

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
        if n < FEW_ROWS * k:
            remarks.append(
                f"{n} rows for {k} parameters are few: standard deviations cannot be believed; "
                "record longer, or decimate less"
            )
        if simulated is None:
            return remarks
        if relative_error_percent(measured.left - simulated, measured.left) > _NOT_FOLLOWING:
            remarks.append(
                "the simulated loop does not follow the record; "
                + (
                    rests_first(self._on.rest)
                    or "check the control law, the reference and the signs and units of the columns"
                )
            )
        speed = np.abs(self._on.signals.velocity)
        starts = [start for start, _ in self.record.spans]
        if speed[starts].max() > _IN_MOTION * speed.max():
            what = "a segment of the record" if self.record.segments else "the record"
            remarks.append(
                f"{what} begins in motion, the simulated loop at rest: its first transient is "
                "in the simulation error; begin it at rest, or drop more at the start"
            )
        return remarks


def _outside_bounds(axis: GeneratedAxis, physical: Array) -> list[str]:
    stopped = [
        f"{p.name} = {value:.6g} {p.unit} is at its bound: the search would go further"
        for p, value, bent in zip(axis.axis.parameters, physical, axis.nonlinear, strict=True)
        if bent and min(abs(value - p.lower), abs(value - p.upper)) <= _AT_BOUND * abs(value)
    ]
    return stopped + [
        f"{p.name} = {value:.6g} {p.unit} is outside its bounds [{p.lower:g}, {p.upper:g}]"
        for p, value in zip(axis.axis.parameters, physical, strict=True)
        if not p.lower <= value <= p.upper
    ]
