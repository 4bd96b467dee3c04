"""The four estimators, from an axis and a record to estimates."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from axisid.codegen import GeneratedAxis, build
from axisid.modeling import Axis, ModelError, UsageError

from .arrays import Array, relative_error_percent
from .closed_loop import no_control_law, simulate
from .covariance import delta_method, iid_covariance
from .errors import DataError, EstimationError
from .estimate import Estimate, Iterate
from .forms import DirectForm, Form, InverseForm
from .linear import Solution, condition_number, instrumental_variables, least_squares
from .prefilter import Prefilter
from .record import Record
from .results import Identification
from .signals import measured_signals

#: Every method: model form, then estimator.
METHODS = ("idm-ls", "ddm-ls", "idm-iv", "ddm-iv")

_MOST_ITERATIONS = 20
# The iteration stops when no parameter moves by more than this share of its deviation.
_STILL = 1e-2
_ROUNDING = 1e-9  # the same as a share of the value, for records without noise
_PERIOD_TOLERANCE = 0.01


def identify(
    axis: Axis | GeneratedAxis,
    record: Record,
    prefilter: Prefilter | None = None,
    methods: Sequence[str] | None = None,
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
        in `Identification.skipped`.

    Raises
    ------
    UsageError, DataError, ModelError, EstimationError
        See each; a method asked for by name raises, whatever the reason.
    """
    prefilter = prefilter or Prefilter()
    generated = axis if isinstance(axis, GeneratedAxis) else build(axis)
    for method in methods or ():
        if method not in METHODS:
            raise UsageError(f"there is no method {method!r}; choose from {', '.join(METHODS)}.")
    study = _Study(generated, record, prefilter)
    estimates: dict[str, Estimate] = {}
    skipped: dict[str, str] = {}
    for method in METHODS if methods is None else dict.fromkeys(methods):
        try:
            estimates[method] = study.estimate(method)
        except (ModelError, _NoReferenceError) as error:
            if methods is not None:
                raise
            skipped[method] = str(error)
    return Identification(
        axis=generated, record=record, prefilter=prefilter, estimates=estimates, skipped=skipped
    )


class _NoReferenceError(DataError):
    """The record has no reference to simulate the loop from."""


class _Study:
    """One axis, one record, one prefilter."""

    def __init__(self, axis: GeneratedAxis, record: Record, prefilter: Prefilter) -> None:
        self.axis, self.record, self.prefilter = axis, record, prefilter
        self._measured = measured_signals(axis, record, prefilter)

    def estimate(self, method: str) -> Estimate:
        """Run one method: regress, map to physical parameters, simulate."""
        model, estimator = method.split("-")
        form = InverseForm(self.axis) if model == "idm" else DirectForm(self.axis)
        y, X = (self._reduced(part) for part in form.equations(self._measured))
        if estimator == "ls":
            solution = least_squares(y, X, _names(form))
            fit = self._simulated_fit(form, solution)
        else:
            self._reference()
            fit = self._iterate(method, form, y, X)
        return self._result(method, form, y, X, fit)

    def _simulated_fit(self, form: Form, solution: Solution) -> "_Fit":
        """Least squares needs no simulation; its simulation error is a courtesy."""
        try:
            simulated, _ = self._instruments(form, form.physical(solution.theta)[0])
        except (ModelError, DataError, EstimationError) as error:
            return _Fit(solution, (), None, (f"no simulation error: {error}",))
        return _Fit(solution, (), simulated, ())

    def _iterate(self, method: str, form: Form, y: Array, X: Array) -> "_Fit":
        """Instruments from the loop simulated with the last estimate, until it stands still."""
        iterates: list[Iterate] = []
        physical, still = self.axis.nominal, False
        solution: Solution | None = None
        while len(iterates) <= _MOST_ITERATIONS:
            with _naming(f"{method}, iterate {len(iterates)}"):
                simulated, Z = self._instruments(form, physical)
                theta = form.regressed(physical) if solution is None else solution.theta
                error = relative_error_percent(y - simulated, y)
                iterates.append(
                    Iterate(physical=physical, theta=theta, simulation_error_percent=error)
                )
                if solution is not None and still:
                    return _Fit(solution, tuple(iterates), simulated, ())
                solution = instrumental_variables(y, X, Z, _names(form))
                following, jacobian = form.physical(solution.theta)
            deviation = np.sqrt(np.diag(delta_method(iid_covariance(solution), jacobian)))
            allowed = _STILL * deviation + _ROUNDING * np.abs(following)
            still = bool(np.all(np.abs(following - physical) <= allowed))
            physical = following
        raise EstimationError(
            f"{method} still moves after {_MOST_ITERATIONS} iterations; the last estimate is "
            f"{self.axis.describe(physical)}. Check the control law against the record, and start "
            "from better nominal values."
        )

    def _instruments(self, form: Form, physical: Array) -> tuple[Array, Array]:
        """``y`` and the regressor of the simulated loop, reduced like the measured ones.

        With `zoh`, the rows just before and just after a sample are averaged, as the measured
        force is; each satisfies the model, so their mean does.
        """
        record = self.record
        simulation = simulate(
            self.axis,
            physical,
            self._reference(),
            record.period,
            start=float(record.position[0]),
        )
        y, Z = form.equations(simulation.after)
        if self.prefilter.hold == "zoh":
            y_before, Z_before = form.equations(simulation.before)
            y, Z = (y + y_before) / 2, (Z + Z_before) / 2
        return self._reduced(y), self._reduced(Z)

    def _reference(self) -> Array:
        """Reference of a loop that was both declared and recorded; anything less is refused."""
        axis, record = self.axis.axis, self.record
        if axis.control is None:
            raise no_control_law(axis.name)
        if record.reference is None:
            raise _NoReferenceError(
                f"{record.provenance.source} has no reference column, from which the closed loop "
                "is simulated; name it with --columns reference=NAME, or use idm-ls or ddm-ls."
            )
        if abs(record.period / axis.control.period - 1) > _PERIOD_TOLERANCE:
            raise DataError(
                f"the record is sampled every {record.period:g} s, the control law of axis "
                f"{axis.name!r} every {axis.control.period:g} s; instruments need a record at the "
                "law's period. Declare the drive's period, or use idm-ls or ddm-ls."
            )
        return record.reference

    def _reduced(self, signals: Array) -> Array:
        return self.prefilter.reduce(signals, self.record.period)

    def _result(self, method: str, form: Form, y: Array, X: Array, fit: "_Fit") -> Estimate:
        solution = fit.solution
        covariance = iid_covariance(solution)
        physical, jacobian = form.physical(solution.theta)
        direct = isinstance(form, DirectForm)
        simulated = fit.simulated
        return Estimate(
            method=method,
            quantities=self.axis.parameters,
            physical=physical,
            covariance=delta_method(covariance, jacobian),
            ddm_quantities=form.quantities if direct else (),
            theta_ddm=solution.theta if direct else np.empty(0),
            ddm_covariance=covariance if direct else np.empty((0, 0)),
            y=y,
            X=X,
            rows=self.prefilter.rows(len(self.record), self.record.period),
            residuals=solution.residuals,
            simulated=simulated,
            equation_error_percent=relative_error_percent(solution.residuals, y),
            simulation_error_percent=None
            if simulated is None
            else relative_error_percent(y - simulated, y),
            condition_number=condition_number(X),
            iterates=fit.iterates,
            covariance_name="i.i.d., residual variance with n - 1 degrees of freedom",
            remarks=(*fit.remarks, *_outside_bounds(self.axis, physical)),
        )


@dataclass(frozen=True, slots=True)
class _Fit:
    """A solution with the loop simulated from it."""

    solution: Solution
    iterates: tuple[Iterate, ...]
    simulated: Array | None
    remarks: tuple[str, ...]


def _names(form: Form) -> list[str]:
    return [quantity.expression or quantity.name for quantity in form.quantities]


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
