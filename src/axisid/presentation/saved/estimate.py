"""One method's estimate as its file has it: what can be said without the rows it was made from."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

from axisid.codegen.artefacts import Quantity
from axisid.estimation.choices import is_output_error
from axisid.estimation.estimates import Distribution, Estimate, Iterate, NamedValues, Value
from axisid.estimation.regression import DrawSummary, ResidualTests
from axisid.modeling.text import FunctionLike
from axisid.presentation.documents import written_estimate
from axisid.presentation.schema import (
    Matrix,
    WrittenDrawn,
    WrittenEstimate,
    WrittenPhysical,
    WrittenValue,
)
from axisid.support.arrays import Array, frozen
from axisid.support.errors import UsageError
from axisid.support.presentable import Presentable
from axisid.support.real_numbers import is_whole
from axisid.support.uncached import Uncached
from axisid.support.user_values import is_among, quoted

from .diagnosis import read_residual_tests


@dataclass(frozen=True, kw_only=True)
class SavedForm:
    """What a regression estimated, and what stood on its left."""

    quantities: tuple[Quantity, ...]
    left: str


@dataclass(frozen=True, kw_only=True, repr=False)
class SavedEstimate(Uncached, Presentable):
    """An estimate that was read from a file, with the names of `Estimate`.

    Attributes
    ----------
    document : WrittenEstimate
        What the file holds of it.
    row_period : float
        Time from one row of the regression to the next, s.
    """

    document: WrittenEstimate
    row_period: float

    def __repr__(self) -> str:
        return f"{self.method}: {self.parameters.listed()}"

    @property
    def method(self) -> str:
        """``idm-ls``, ``ddm-ls``, ``idm-iv``, ``ddm-iv`` or ``didim``."""
        return self.document.method

    @property
    def chosen(self) -> str:
        """Of `covariances`, what intervals, draws, curvatures and tests are of."""
        return self.document.chosen_covariance

    def __getitem__(self, name: str) -> Value:
        """One of `parameters`."""
        return self.parameters[name]

    @cached_property
    def parameters(self) -> NamedValues:
        """Physical parameters by name."""
        return named(self.document.parameters, self.chosen)

    @cached_property
    def ddm_parameters(self) -> NamedValues:
        """Parameters of the direct model by name; empty for an inverse model."""
        return named(self.document.theta_ddm or {}, self.chosen)

    @property
    def is_direct(self) -> bool:
        """Whether a direct model was regressed."""
        return bool(self.ddm_parameters)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Physical parameters, length p; base parameters with what they are made of."""
        made = self.document.physical.base if self.document.physical else {}
        return tuple(
            Quantity(name=name, unit=v.unit, expression=made.get(name, ""))
            for name, v in self.parameters.items()
        )

    @property
    def ddm_quantities(self) -> tuple[Quantity, ...]:
        """Of the direct model, length m; empty for an inverse model."""
        written = self.document.theta_ddm or {}
        return tuple(
            Quantity(name=name, unit=v.unit, expression=v.expression) for name, v in written.items()
        )

    @property
    def form(self) -> SavedForm:
        """What the regression estimated."""
        if self.ddm_quantities:
            return SavedForm(quantities=self.ddm_quantities, left="acceleration")
        return SavedForm(quantities=self.quantities, left="force")

    @property
    def by_output_error(self) -> bool:
        """Whether the simulated loop's columns were regressed, not the measured motion's."""
        return is_output_error(self.method)

    @property
    def physical(self) -> Array:
        """Physical parameters, (p,)."""
        return frozen([v.value for v in self.parameters.values()])

    @property
    def filter_bias(self) -> Array | None:
        """What filter and noise move the physical parameters by, (p,), as twins tell."""
        biases = [v.filter_bias for v in self.parameters.values()]
        return None if None in biases else frozen([b for b in biases if b is not None])

    @property
    def corrected(self) -> Array:
        """Physical parameters less the bias of filter and noise, where that is known, (p,)."""
        return frozen([v.corrected for v in self.parameters.values()])

    @cached_property
    def covariances(self) -> Mapping[str, Array]:
        """Of `physical`, (p, p), by name: ``iid``, ``robust`` and ``hac``."""
        return arrays(written_covariances(self.document))

    @property
    def covariance(self) -> Array:
        """Of the physical parameters, (p, p): the chosen one, whose deviations are printed."""
        return self.covariances[self.chosen]

    @cached_property
    def ddm_covariances(self) -> Mapping[str, Array]:
        """Of the direct model's parameters, (m, m): ``iid``, ``hac`` and the chosen one."""
        return arrays(written_ddm_covariances(self.document))

    @property
    def correlation(self) -> Array:
        """Correlation matrix of the physical parameters, (p, p), of the chosen covariance."""
        return frozen(self.document.correlation)

    @property
    def covariance_names(self) -> Mapping[str, str]:
        """What each covariance is, with lags and corrections."""
        return self.document.covariance_names

    @property
    def freedom(self) -> Mapping[str, Array]:
        """Degrees of freedom of the variances of `physical`, (p,), of the chosen covariance."""
        written = self.document.freedom or {}
        usual = self.document.rows - len(self.form.quantities)
        return {self.chosen: frozen([written.get(q.name, usual) for q in self.quantities])}

    @property
    def equation_error_percent(self) -> float:
        """``100 ||y - X theta|| / ||y||``."""
        return self.document.equation_error_percent

    @property
    def simulation_error_percent(self) -> float | None:
        """``100 ||y - simulated|| / ||y||``; None where the loop could not be simulated."""
        return self.document.simulation_error_percent

    @property
    def condition_number(self) -> float:
        """Of the regressor as it was, not scaled."""
        return self.document.condition_number

    @property
    def remarks(self) -> tuple[str, ...]:
        """What the user should know about this estimate."""
        return self.document.remarks

    @property
    def curvatures(self) -> Array:
        """Second-order part of each physical parameter's deviation against the first, (p,)."""
        values = self.document.curvatures.values()
        return frozen([math.inf if c is None else c for c in values])

    @property
    def iterates(self) -> tuple[Iterate, ...]:
        """The start and every iterate; empty for least squares."""
        d = self.document
        return tuple(
            Iterate(
                physical=frozen([*physical.values()]),
                theta=frozen([*theta.values()]),
                simulation_error_percent=error,
            )
            for physical, theta, error in zip(
                d.iterations,
                d.theta_ddm_iterations or d.iterations,
                d.iteration_simulation_errors_percent,
                strict=True,
            )
        )

    @property
    def started(self) -> str:
        """Where the iteration started; empty for least squares, and in older files."""
        return self.document.started or ""

    @cached_property
    def residual_tests(self) -> ResidualTests:
        """Tests of the residuals."""
        return read_residual_tests(self.document.residual_tests)

    def derive(self, function: FunctionLike) -> Value:
        """Any function of the physical parameters, with its unit and interval.

        As `Estimate.derive` has it, by the delta method under every covariance.

        Parameters
        ----------
        function : str or SymPy expression
            Such as ``"M/Fv"``.

        Raises
        ------
        UsageError
            The function cannot be read, or its units do not fit.
        EstimationError
            It has no finite value at the estimate.

        Warns
        -----
        RuntimeWarning
            The function bends within the uncertainty, so that the delta method is not enough.
        """
        advice = "identify again and draw: propagate()"
        return self.distribution.derived(function, advice, self._curvature)

    def propagate(self, function: str, *, draws: int | None = None) -> DrawSummary:
        """A parameter over draws, as the file has it.

        Parameters
        ----------
        function : str
            A parameter's name.
        draws : int, optional
            As many as were drawn; by default as many as the file has.

        Raises
        ------
        UsageError
            The file has no such draws.
        """
        drawn = self._drawn(function, draws)
        median, low, high = (
            math.nan if x is None else x for x in (drawn.median, *drawn.interval_95)
        )
        value = self.parameters[function]
        return DrawSummary(
            value=value.value,
            unit=value.unit,
            median=median,
            interval=(low, high),
            draws=drawn.draws,
            lost=drawn.lost,
            seed=drawn.seed,
        )

    def _drawn(self, function: object, draws: object) -> WrittenDrawn:
        """The draws of a parameter, if the file has them."""
        written = self.document.drawn or {}
        if not is_among(function, written):
            raise UsageError(
                f"the file holds no draws of {quoted(function)} by {self.method}; identify again "
                "and write some.",
                code="no-saved-draws",
            )
        drawn = written[function]
        held = drawn.draws + drawn.lost
        if not (draws is None or (is_whole(draws) and draws == held)):
            raise UsageError(
                f"the file holds {held} draws of {function!r} by {self.method}, not "
                f"{quoted(draws)}; identify again and write as many.",
                code="other-saved-draws",
            )
        return drawn

    def _curvature(self, gradient: Array, hessian: Array) -> float:
        """Second-order part of a function's deviation against the first.

        The map of a direct model bends too; of that the file has each parameter's own part.
        """
        own = self.distribution.curvature(gradient, hessian)
        return float(max([own, *self.curvatures[gradient != 0]]))

    @property
    def gain_relative_sd(self) -> float:
        """Of the drive gain that scaled the force: 0 if the force was measured or it is exact."""
        return self.document.gain_relative_sd

    @property
    def gain_slopes(self) -> Array | None:
        """Of the physical parameters by the logarithm of the gain, (p,), where it is not exact."""
        return _slopes(self.parameters, self.document.gain_slopes)

    @property
    def theta_gain_slopes(self) -> Array | None:
        """The same of the regression's own parameters, (k,)."""
        if self.is_direct:
            return _slopes(self.ddm_parameters, self.document.theta_ddm_gain_slopes)
        return self.gain_slopes

    @property
    def distribution(self) -> Distribution:
        """Of the physical parameters."""
        slopes = self.gain_slopes
        return Distribution(
            quantities=self.quantities,
            theta=self.physical,
            covariances=self.covariances,
            freedom=self.freedom,
            chosen=self.chosen,
            bias=self.filter_bias,
            by_gain=None if slopes is None else self.gain_relative_sd * slopes,
        )


def estimate_facts(estimate: Estimate) -> SavedEstimate:
    """What an estimate tells without its rows, which is all that tables show."""
    return SavedEstimate(document=written_estimate(estimate), row_period=estimate.row_period)


def _slopes(names: Iterable[str], written: Mapping[str, float] | None) -> Array | None:
    return None if written is None else frozen([written[name] for name in names])


def arrays(written: Mapping[str, Matrix]) -> dict[str, Array]:
    """Matrices of a file, by name."""
    return {name: frozen(matrix) for name, matrix in written.items()}


def written_covariances(estimate: WrittenEstimate) -> dict[str, Matrix]:
    """Of an estimate's parameters, by name, those with a member of their own and the others."""
    return {
        **(estimate.covariances or {}),
        "iid": estimate.covariance,
        "robust": estimate.covariance_robust,
        "hac": estimate.covariance_hac,
    }


def written_ddm_covariances(estimate: WrittenEstimate) -> dict[str, Matrix]:
    """Of the direct model's parameters, by name; empty for an inverse model."""
    own = {"iid": estimate.theta_ddm_covariance, "hac": estimate.theta_ddm_covariance_hac}
    written = {name: matrix for name, matrix in own.items() if matrix is not None}
    return {**(estimate.theta_ddm_covariances or {}), **written}


def written_physical_covariances(physical: WrittenPhysical) -> dict[str, Matrix]:
    """Of the declared parameters that follow, by name."""
    return {**(physical.covariances or {}), "hac": physical.covariance_hac}


def written_deviations(value: WrittenValue) -> dict[str, float]:
    """Of a value, by covariance, those with a member of their own and the others."""
    return {
        **(value.deviations or {}),
        "iid": value.sd,
        "robust": value.sd_robust,
        "hac": value.sd_hac,
    }


def named(written: Mapping[str, WrittenValue], chosen: str = "hac") -> NamedValues:
    """Values by name, as an estimate has them; `chosen` is the covariance of their intervals."""
    return NamedValues((name, _value(value, chosen)) for name, value in written.items())


def _value(written: WrittenValue, chosen: str) -> Value:
    return Value(
        value=written.value,
        unit=written.unit,
        deviations=written_deviations(written),
        interval=written.interval_95,
        sd_gain=written.sd_gain,
        filter_bias=written.filter_bias,
        chosen=chosen,
    )
