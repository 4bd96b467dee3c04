"""One method's estimate as its file has it: what can be said without the rows it was made from."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from msgspec.structs import asdict

from axisid.codegen.artefacts import Quantity
from axisid.estimation.choices import is_output_error
from axisid.estimation.estimates import Estimate, Iterate, NamedValues, SamplingDistribution, Value
from axisid.estimation.parameters import JointForm
from axisid.estimation.regression import DrawSummary, ResidualTests, correlation
from axisid.modeling.text import FunctionLike
from axisid.support.arrays import Array, Exact
from axisid.support.errors import UsageError, is_among, is_whole, quoted
from axisid.support.presentable import Presentable

from .values import Matrix, number, read_as
from .written_estimate import (
    WrittenEstimate,
    WrittenPhysical,
    WrittenValue,
    written_estimate,
)


@dataclass(frozen=True, kw_only=True)
class SavedForm:
    """What a regression estimated, and what stood on its left."""

    quantities: tuple[Quantity, ...]
    left: str


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class SavedEstimate(Presentable, Exact):
    """An estimate that was read from a file, with the names of `Estimate`.

    What is not listed is as of an `Estimate`.

    Attributes
    ----------
    document : WrittenEstimate
        What the file holds of it.
    row_period : float
        Time from one row of the regression to the next, s.
    parameters : NamedValues
        Physical parameters by name.
    ddm_parameters : NamedValues
        Those of the direct model; none for an inverse model.
    quantities, ddm_quantities : tuple of Quantity
        The same without values, p and m of them; base parameters with what they are made of.
    started : str
        Where the iteration started; empty for least squares, and in older files.
    iterates : tuple of Iterate
        The start and every iterate; empty for least squares.
    covariances : mapping of str to array
        Of `parameters`, (p, p), by name.
    distribution : SamplingDistribution
        Of `parameters`.
    curvatures : (p,) array
        Second-order part of each physical parameter's deviation against the first.
    """

    document: WrittenEstimate
    row_period: float
    method: str
    chosen: str
    parameters: NamedValues
    ddm_parameters: NamedValues
    quantities: tuple[Quantity, ...]
    ddm_quantities: tuple[Quantity, ...]
    covariances: Mapping[str, Array]
    distribution: SamplingDistribution
    covariance_names: Mapping[str, str]
    correlation: Array
    curvatures: Array
    equation_error_percent: float
    simulation_error_percent: float | None
    condition_number: float
    iterates: tuple[Iterate, ...]
    started: str
    residual_tests: ResidualTests
    remarks: tuple[str, ...]
    gain_relative_sd: float

    @classmethod
    def of(cls, written: WrittenEstimate, row_period: float) -> "SavedEstimate":
        """What a document tells of an estimate."""
        chosen, direct = written.chosen_covariance, written.theta_ddm or {}
        made = written.physical.base if written.physical else {}
        names, free = [*written.parameters], written.freedom or {}
        usual, slopes = written.rows - len(direct or names), written.gain_slopes
        covariances = arrays(
            {
                **(written.covariances or {}),
                "iid": written.covariance,
                "robust": written.covariance_robust,
                "hac": written.covariance_hac,
            }
        )
        quantities = tuple(
            Quantity(name=name, unit=v.unit, expression=made.get(name, ""))
            for name, v in written.parameters.items()
        )
        biases = [v.filter_bias for v in written.parameters.values() if v.filter_bias is not None]
        return read_as(
            cls,
            written,
            document=written,
            row_period=row_period,
            chosen=chosen,
            parameters=named(written.parameters, chosen),
            ddm_parameters=named(direct, chosen),
            quantities=quantities,
            ddm_quantities=tuple(
                Quantity(name=name, unit=v.unit, expression=v.expression)
                for name, v in direct.items()
            ),
            covariances=covariances,
            distribution=SamplingDistribution(
                quantities=quantities,
                theta=np.array([v.value for v in written.parameters.values()]),
                covariances=covariances,
                freedom={chosen: np.array([free.get(name, float(usual)) for name in names])},
                chosen=chosen,
                bias=np.array(biases) if len(biases) == len(names) else None,
                by_gain=None
                if slopes is None
                else written.gain_relative_sd * np.array([slopes[name] for name in names]),
            ),
            curvatures=np.array([number(c, math.inf) for c in written.curvatures.values()]),
            iterates=tuple(
                Iterate(
                    physical=np.array([*physical.values()]),
                    theta=np.array([*theta.values()]),
                    simulation_error_percent=error,
                )
                for physical, theta, error in zip(
                    written.iterations,
                    written.theta_ddm_iterations or written.iterations,
                    written.iteration_simulation_errors_percent,
                    strict=True,
                )
            ),
            started=written.started or "",
        )

    def part(self, joint: JointForm, place: int) -> "SavedEstimate":
        """The same in the parameters of the axis that one of several records has."""
        whole = self.distribution
        jacobian = joint.physical(joint.regressed(whole.theta))[1]
        own = whole.through(
            joint.members[place].axis.parameters,
            joint.own(whole.theta, place),
            joint.slopes(place) @ np.linalg.inv(jacobian),
        )
        return replace(
            self,
            parameters=own.values,
            quantities=own.quantities,
            covariances=own.covariances,
            correlation=correlation(own.covariances[own.chosen]),
            distribution=own,
        )

    def __repr__(self) -> str:
        return f"{self.method}: {self.parameters.listed()}"

    def __getitem__(self, name: str) -> Value:
        """One of `parameters`."""
        return self.parameters[name]

    @property
    def is_direct(self) -> bool:
        """Whether a direct model was regressed."""
        return bool(self.ddm_quantities)

    @property
    def form(self) -> SavedForm:
        """What the regression estimated."""
        return SavedForm(
            quantities=self.ddm_quantities or self.quantities,
            left="acceleration" if self.is_direct else "force",
        )

    @property
    def by_output_error(self) -> bool:
        """Whether the simulated loop's columns were regressed, not the measured motion's."""
        return is_output_error(self.method)

    @property
    def physical(self) -> Array:
        """Physical parameters, (p,)."""
        return self.distribution.theta

    @property
    def filter_bias(self) -> Array | None:
        """What filter and noise move the physical parameters by, (p,), as twins tell."""
        return self.distribution.bias

    @property
    def corrected(self) -> Array:
        """Physical parameters less the bias of filter and noise, where that is known, (p,)."""
        return self.distribution.corrected

    @property
    def covariance(self) -> Array:
        """Of the physical parameters, (p, p): the chosen one, whose deviations are printed."""
        return self.covariances[self.chosen]

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
        written, value = self.document.drawn or {}, self.parameters.get(function)
        if value is None or not is_among(function, written):
            raise UsageError(
                f"the file holds no draws of {quoted(function)} by {self.method}; identify again "
                "and write some.",
                code="result-file",
            )
        drawn = written[function]
        held = drawn.draws + drawn.lost
        if not (draws is None or (is_whole(draws) and draws == held)):
            raise UsageError(
                f"the file holds {held} draws of {function!r} by {self.method}, not "
                f"{quoted(draws)}; identify again and write as many.",
                code="result-file",
            )
        return DrawSummary(value=value.value, unit=value.unit, **asdict(drawn))

    def _curvature(self, gradient: Array, hessian: Array) -> float:
        """Second-order part of a function's deviation against the first.

        The map of a direct model bends too; of that the file has each parameter's own part.
        """
        own = self.distribution.curvature(gradient, hessian)
        return float(max([own, *self.curvatures[gradient != 0]]))


def estimate_facts(estimate: Estimate) -> SavedEstimate:
    """What an estimate tells without its rows, which is all that tables show."""
    return SavedEstimate.of(written_estimate(estimate), estimate.row_period)


def arrays(written: Mapping[str, Matrix]) -> dict[str, Array]:
    """Matrices of a file, by name."""
    return {name: np.array(matrix) for name, matrix in written.items()}


def written_physical_covariances(physical: WrittenPhysical) -> dict[str, Matrix]:
    """Of the declared parameters that follow, by name."""
    return {**(physical.covariances or {}), "hac": physical.covariance_hac}


def named(written: Mapping[str, WrittenValue], chosen: str = "hac") -> NamedValues:
    """Values by name, as an estimate has them; `chosen` is the covariance of their intervals."""
    return NamedValues(
        (
            name,
            read_as(
                Value,
                v,
                # Those with a member of their own, and the others.
                deviations={
                    **(v.deviations or {}),
                    "iid": v.sd,
                    "robust": v.sd_robust,
                    "hac": v.sd_hac,
                },
                chosen=chosen,
            ),
        )
        for name, v in written.items()
    )
