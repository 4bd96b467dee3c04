"""One method's estimate as its file has it: what can be said without the rows it was made from."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from msgspec.structs import asdict

from axisid.codegen.artefacts import Quantity
from axisid.estimation.choices import is_output_error
from axisid.estimation.estimates import Estimate, Iterate, NamedValues, SamplingDistribution, Value
from axisid.estimation.regression import Drawn, DrawSummary, ResidualTests
from axisid.modeling.text import FunctionLike
from axisid.presentation.documents import number, read_as, written_estimate
from axisid.presentation.schema import (
    Matrix,
    WrittenEstimate,
    WrittenPhysical,
    WrittenValue,
)
from axisid.support.arrays import Array, Exact, frozen
from axisid.support.errors import UsageError, is_among, is_whole, quoted
from axisid.support.presentable import Presentable


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
    ddm_covariances : mapping of str to array
        Of `ddm_parameters`, (m, m), by name.
    freedom : mapping of str to array
        Degrees of freedom of the variances of `parameters`, (p,), of the chosen covariance.
    curvatures : (p,) array
        Second-order part of each physical parameter's deviation against the first.
    gain_slopes, theta_gain_slopes : array or None
        Of the physical parameters by the logarithm of the gain, (p,), where it is not exact; and
        of the regression's own parameters, (k,).
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
    ddm_covariances: Mapping[str, Array]
    covariance_names: Mapping[str, str]
    correlation: Array
    freedom: Mapping[str, Array]
    curvatures: Array
    equation_error_percent: float
    simulation_error_percent: float | None
    condition_number: float
    iterates: tuple[Iterate, ...]
    started: str
    residual_tests: ResidualTests
    remarks: tuple[str, ...]
    gain_relative_sd: float
    gain_slopes: Array | None
    theta_gain_slopes: Array | None

    @classmethod
    def of(cls, written: WrittenEstimate, row_period: float) -> "SavedEstimate":
        """What a document tells of an estimate."""
        chosen, direct = written.chosen_covariance, written.theta_ddm or {}
        made = written.physical.base if written.physical else {}
        names, free = [*written.parameters], written.freedom or {}
        usual = written.rows - len(direct or names)
        slopes = _in_order(names, written.gain_slopes)
        return read_as(
            cls,
            written,
            document=written,
            row_period=row_period,
            chosen=chosen,
            parameters=named(written.parameters, chosen),
            ddm_parameters=named(direct, chosen),
            quantities=tuple(
                Quantity(name=name, unit=v.unit, expression=made.get(name, ""))
                for name, v in written.parameters.items()
            ),
            ddm_quantities=tuple(
                Quantity(name=name, unit=v.unit, expression=v.expression)
                for name, v in direct.items()
            ),
            covariances=arrays(written_covariances(written)),
            ddm_covariances=arrays(written_ddm_covariances(written)),
            freedom={chosen: frozen([free.get(name, usual) for name in names])},
            curvatures=frozen([number(c, math.inf) for c in written.curvatures.values()]),
            iterates=tuple(_iterates(written)),
            started=written.started or "",
            gain_slopes=slopes,
            theta_gain_slopes=_in_order(direct, written.theta_ddm_gain_slopes)
            if direct
            else slopes,
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return SavedEstimate.of, (self.document, self.row_period)

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
        drawn, value = self._drawn(function, draws), self.parameters[function]
        return DrawSummary(value=value.value, unit=value.unit, **asdict(drawn))

    def _drawn(self, function: object, draws: object) -> Drawn:
        """The draws of a parameter, if the file has them."""
        written = self.document.drawn or {}
        if not is_among(function, written):
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
        return drawn

    def _curvature(self, gradient: Array, hessian: Array) -> float:
        """Second-order part of a function's deviation against the first.

        The map of a direct model bends too; of that the file has each parameter's own part.
        """
        own = self.distribution.curvature(gradient, hessian)
        return float(max([own, *self.curvatures[gradient != 0]]))

    @property
    def distribution(self) -> SamplingDistribution:
        """Of the physical parameters."""
        slopes = self.gain_slopes
        return SamplingDistribution(
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
    return SavedEstimate.of(written_estimate(estimate), estimate.row_period)


def _iterates(written: WrittenEstimate) -> Iterator[Iterate]:
    """The start and every iterate."""
    thetas = written.theta_ddm_iterations or written.iterations
    errors = written.iteration_simulation_errors_percent
    for physical, theta, error in zip(written.iterations, thetas, errors, strict=True):
        yield Iterate(
            physical=frozen([*physical.values()]),
            theta=frozen([*theta.values()]),
            simulation_error_percent=error,
        )


def _in_order(names: Iterable[str], written: Mapping[str, float] | None) -> Array | None:
    """Figures of a document by name in the order of the names, where there are any."""
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
    return read_as(Value, written, deviations=written_deviations(written), chosen=chosen)
