"""Estimates of one method as documents, written and read, without the rows of the record.

The names of a document's members are a contract with other programs.
"""

from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from msgspec import UNSET, UnsetType
from msgspec.structs import asdict

from axisid.codegen.generated_axes import GeneratedAxis, Quantity
from axisid.estimation.estimates import (
    Estimate,
    EstimateFacts,
    Iterate,
    NamedValues,
    Physical,
    SamplingDistribution,
    Value,
)
from axisid.estimation.noise_models import Chain
from axisid.estimation.regression import (
    CovarianceNote,
    Drawn,
    DrawSummary,
    ResidualTests,
    correlation,
)
from axisid.estimation.unknowns import JointForm
from axisid.modeling.parsing import FunctionLike
from axisid.presentation.sentences import covariance_text
from axisid.support.arrays import Array, Exact, MaybeInfinite
from axisid.support.checks import is_among, is_whole
from axisid.support.errors import UsageError
from axisid.support.presentable import Presentable
from axisid.support.wording import quoted

from .json_objects import (
    JsonObject,
    Matrix,
    WrittenKnown,
    about,
    by_name,
    check_sizes,
    read_as,
    written_as,
)


class WrittenValue(JsonObject, frozen=True, kw_only=True):
    """A number with unit, standard errors and interval."""

    value: Annotated[float, about("In `unit`.")]
    unit: Annotated[str, about("Coherent SI.")]
    sd: Annotated[
        float,
        about("Standard error for independent residuals, as in the published tables."),
    ]
    relative_sd_percent: Annotated[float | None, about("100 sd / |value|; null for a value of 0.")]
    sd_robust: Annotated[float, about("Standard error, robust to residuals of unequal variance.")]
    sd_hac: Annotated[float, about("Standard error, robust also to autocorrelated residuals.")]
    interval_95: Annotated[
        tuple[float, float],
        about(
            "Centred at the value minus filter_bias, from the chosen covariance and Student's "
            "distribution."
        ),
    ]
    sd_gain: Annotated[
        float,
        about("Standard error by the declared relative_sd of the drive gain; in no other member."),
    ]
    filter_bias: Annotated[
        float | None,
        about(
            "Bias of filter and noise, from simulated replicas of the record; the value contains "
            "it, the interval does not; null without replicas."
        ),
    ]
    deviations: Annotated[
        Mapping[str, float] | UnsetType,
        about("Standard errors by covariances that have no separate member."),
    ] = UNSET


class WrittenDirectValue(WrittenValue, frozen=True, kw_only=True):
    """A parameter of the direct model."""

    expression: Annotated[str, about("As a function of the physical parameters.")]


class WrittenPhysical(JsonObject, frozen=True, kw_only=True):
    """Declared parameters, calculated from base parameters and known values.

    Absent if the declared parameters are estimated directly and none is known.
    """

    parameters: Annotated[
        Mapping[str, WrittenValue], about("Parameters that can be calculated, by name.")
    ]
    covariance_hac: Annotated[Matrix, about("HAC covariance of `parameters`, in their order.")]
    base: Annotated[
        Mapping[str, str],
        about("Base parameters that are combinations, as functions of declared parameters."),
    ]
    fixed: Annotated[Mapping[str, WrittenKnown], about("Values declared as known, by name.")]
    unsettled: Annotated[
        tuple[str, ...],
        about("Parameters that cannot be calculated, with the values that would have to be known."),
    ]
    statistic: Annotated[
        float,
        about("Hotelling's statistic of the known values against the record."),
    ]
    dof: Annotated[
        int, about("Its degrees of freedom; 0 if the record cannot contradict the known values.")
    ]
    p_value: float | None
    remarks: tuple[str, ...]
    covariances: Annotated[
        Mapping[str, Matrix] | UnsetType,
        about("Chosen covariance of `parameters`, if it has no separate member."),
    ] = UNSET


class WrittenEstimate(JsonObject, frozen=True, kw_only=True):
    """One method's estimate."""

    method: Annotated[str, about("As given to identify.")]
    parameters: Annotated[Mapping[str, WrittenValue], about("Physical parameters, by name.")]
    theta_ddm: Annotated[
        Mapping[str, WrittenDirectValue] | None, about("Parameters of the direct model.")
    ]
    covariance: Annotated[
        Matrix, about("Covariance of the physical parameters, for independent residuals.")
    ]
    covariance_robust: Matrix
    covariance_hac: Matrix
    theta_ddm_covariance: Matrix | None
    theta_ddm_covariance_hac: Matrix | None
    correlation: Annotated[
        Matrix, about("Correlation of the physical parameters, by the chosen covariance.")
    ]
    covariance_names: Annotated[
        Mapping[str, str],
        about("Description of each covariance, with lags and corrections."),
    ]
    covariance_notes: Annotated[
        Mapping[str, CovarianceNote] | UnsetType,
        about("`covariance_names` as data; files of earlier versions have only the text."),
    ] = UNSET
    chains: Annotated[
        tuple[Chain, ...] | UnsetType,
        about("Noise of each record in its simulated replicas, SI; absent without replicas."),
    ] = UNSET
    chosen_covariance: Annotated[
        str,
        about(
            "Covariance (hac, robust, iid or another) used for interval_95, correlation, "
            "curvatures and draws."
        ),
    ]
    equation_error_percent: Annotated[
        float,
        about("100 ||y - X theta|| / ||y||; not a measure of quality for IV estimates."),
    ]
    simulation_error_percent: Annotated[
        float | None,
        about("100 ||y - simulated|| / ||y||; null if the loop could not be simulated."),
    ]
    rows: int
    condition_number: Annotated[float, about("Condition number of X, not scaled.")]
    iterations: Annotated[
        tuple[Mapping[str, float], ...],
        about("Physical parameters by iterate, SI; empty for least squares."),
    ]
    theta_ddm_iterations: Annotated[
        tuple[Mapping[str, float], ...] | None,
        about("Parameters of the direct model by iterate, SI; null for an inverse model."),
    ]
    iteration_simulation_errors_percent: tuple[float, ...]
    loss: Annotated[
        Literal["huber", "bisquare"] | UnsetType,
        about("Robust loss; absent if all rows have equal weight."),
    ] = UNSET
    light_rows: Annotated[
        int | UnsetType, about("Rows with a weight below one half by the robust loss.")
    ] = UNSET
    started: Annotated[
        Literal["least-squares", "nominal"] | UnsetType,
        about("Start of the iteration; absent for least squares."),
    ] = UNSET
    curvatures: Annotated[
        Mapping[str, MaybeInfinite],
        about(
            "Second-order part of the standard error of each physical parameter, relative to the "
            "first-order part; the delta method is sufficient up to 0.1."
        ),
    ]
    freedom: Annotated[
        Mapping[str, float] | UnsetType,
        about("Degrees of freedom of Student's distribution in interval_95, by parameter."),
    ] = UNSET
    residual_tests: ResidualTests
    remarks: tuple[str, ...]
    drawn: Annotated[
        Mapping[str, Drawn] | UnsetType | None,
        about("Summary of draws from the distribution of the estimate; with draws=."),
    ] = UNSET
    physical: WrittenPhysical | UnsetType = UNSET
    covariances: Annotated[
        Mapping[str, Matrix] | UnsetType,
        about("Covariances of the physical parameters that have no separate member."),
    ] = UNSET
    theta_ddm_covariances: Annotated[
        Mapping[str, Matrix] | UnsetType,
        about("Chosen covariance of the direct model, if it has no separate member."),
    ] = UNSET
    gain_relative_sd: Annotated[
        float,
        about("Relative standard error of the drive gain; 0 if exact or if the force is measured."),
    ]
    gain_slopes: Annotated[
        Mapping[str, float] | None,
        about(
            "Derivatives of the physical parameters by the logarithm of the drive gain; null for "
            "an exact gain."
        ),
    ]
    theta_ddm_gain_slopes: Annotated[
        Mapping[str, float] | None,
        about("Derivatives of the parameters of the direct model by the same logarithm."),
    ]


_Number = TypeVar("_Number", bound=WrittenValue)
_NAMED = frozenset({"iid", "robust", "hac"})  # covariances with separate members


def written_estimate(
    estimate: Estimate,
    drawn: Mapping[str, Drawn] | Any = UNSET,
    physical: WrittenPhysical | Any = UNSET,
) -> WrittenEstimate:
    """Return the document of an estimate; statistics that are not finite become None.

    Parameters
    ----------
    estimate : Estimate
    drawn : mapping of str to Drawn, optional
        Summary of draws by parameter; None or UNSET for none.
    physical : WrittenPhysical, optional
        Declared parameters calculated from the estimate; UNSET for none.
    """
    names = [quantity.name for quantity in estimate.quantities]
    direct = [quantity.name for quantity in estimate.ddm_quantities]  # empty for an inverse model
    return written_as(
        WrittenEstimate,
        estimate,
        parameters={n: _written(WrittenValue, v) for n, v in estimate.parameters.items()},
        theta_ddm={
            q.name: _written(WrittenDirectValue, value, expression=q.expression)
            for q, value in zip(
                estimate.ddm_quantities, estimate.ddm_parameters.values(), strict=True
            )
        }
        or None,
        covariance=estimate.covariances["iid"],
        covariance_robust=estimate.covariances["robust"],
        covariance_hac=estimate.covariances["hac"],
        covariances=_further(estimate.covariances, estimate.chosen, _NAMED),
        theta_ddm_covariance=estimate.ddm_covariances["iid"] if direct else None,
        theta_ddm_covariance_hac=estimate.ddm_covariances["hac"] if direct else None,
        theta_ddm_covariances=_further(estimate.ddm_covariances, estimate.chosen, {"iid", "hac"}),
        chains=tuple(each.likeliest for each in estimate.inference.chains) or UNSET,
        chosen_covariance=estimate.chosen,
        rows=len(estimate.y),
        iterations=tuple(by_name(names, i.physical) for i in estimate.iterates),
        theta_ddm_iterations=tuple(by_name(direct, i.theta) for i in estimate.iterates)
        if direct
        else None,
        iteration_simulation_errors_percent=tuple(
            i.simulation_error_percent for i in estimate.iterates
        ),
        started=estimate.started or UNSET,
        loss=UNSET if estimate.counts is None else estimate.loss,
        light_rows=UNSET if estimate.counts is None else int(estimate.light_rows.sum()),
        curvatures=by_name(names, estimate.curvatures),
        freedom=by_name(names, estimate.freedom[estimate.chosen]),
        drawn=drawn,
        physical=physical,
        gain_slopes=_slopes(names, estimate.inference.gain_slopes),
        theta_ddm_gain_slopes=_slopes(direct, estimate.inference.theta_gain_slopes)
        if direct
        else None,
    )


def _covariance_notes(written: WrittenEstimate) -> Mapping[str, CovarianceNote]:
    """Return the notes on the covariances in a file, by the name of the covariance.

    Files of earlier versions have only texts, which become labels of notes.
    """
    if isinstance(written.covariance_notes, UnsetType):
        texts = written.covariance_names.items()
        return {name: CovarianceNote(kind="other", label=text) for name, text in texts}
    return written.covariance_notes


def _slopes(names: Iterable[str], slopes: Array | None) -> dict[str, float] | None:
    """Return the derivatives by the logarithm of the drive gain, by parameter; None without any."""
    return None if slopes is None else by_name(names, slopes)


def written_physical(physical: Physical, chosen: str) -> WrittenPhysical:
    """Return the document of declared parameters that are calculated from base parameters.

    `chosen` is the name of the chosen covariance.
    """
    return written_as(
        WrittenPhysical,
        physical,
        parameters={n: _written(WrittenValue, v) for n, v in physical.parameters.items()},
        covariance_hac=physical.covariances["hac"],
        covariances=_further(physical.covariances, chosen, {"hac"}),
        base={p.name: p.description for p in physical.combined},
        fixed={
            p.name: written_as(WrittenKnown, p, value=p.known, sd=p.known_sd)
            for p in physical.known
        },
    )


def left_out(axis: GeneratedAxis) -> dict[str, float]:
    """Return the values of the parameters that were left out of an axis, SI, by name."""
    return {p.name: p.known for p in axis.declared.left_out if p.known is not None}


def _further(
    covariances: Mapping[str, Array], chosen: str, written_elsewhere: Set[str]
) -> dict[str, Array] | UnsetType:
    """Return the covariances that have no separate member in a document.

    These are the chosen one and registered ones. Robust and i.i.d. covariances that no interval
    uses are omitted. Unset if there are none.

    Parameters
    ----------
    covariances : mapping of str to array
    chosen : str
        Name of the chosen covariance.
    written_elsewhere : set of str
        Names of covariances with separate members.
    """
    wanted = {chosen, *(covariances.keys() - _NAMED)} - written_elsewhere
    return {name: c for name, c in covariances.items() if name in wanted} or UNSET


def _written(kind: type[_Number], value: Value, **others: Any) -> _Number:
    """Return a number with unit, standard errors and interval as part of a document.

    Parameters
    ----------
    kind : type of WrittenValue
    value : Value
    **others
        Members of `kind` that a `Value` does not have.
    """
    return written_as(
        kind,
        value,
        deviations={n: sd for n, sd in value.deviations.items() if n not in _NAMED} or UNSET,
        **others,
    )


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class SavedEstimate(EstimateFacts, Presentable, Exact):
    """An estimate that was read from a file, with the attributes of `Estimate`.

    Attributes that are not listed are those of `Estimate`.

    Attributes
    ----------
    document : WrittenEstimate
        Content of the file.
    parameters : NamedValues
        Physical parameters by name.
    ddm_parameters : NamedValues
        Parameters of the direct model; empty for an inverse model.
    covariances : mapping of str to array
        Covariances of `parameters`, (p, p), by name.
    distribution : SamplingDistribution
        Sampling distribution of `parameters`.
    curvatures : (p,) array
        Second-order part of the standard error of each physical parameter, relative to the
        first-order part.
    """

    document: WrittenEstimate
    parameters: NamedValues
    ddm_parameters: NamedValues
    covariances: Mapping[str, Array]
    distribution: SamplingDistribution
    covariance_notes: Mapping[str, CovarianceNote]
    correlation: Array
    curvatures: Array
    residual_tests: ResidualTests

    @classmethod
    def of(cls, written: WrittenEstimate, row_period: float) -> "SavedEstimate":
        """Return the estimate of a document.

        Parameters
        ----------
        written : WrittenEstimate
        row_period : float
            Time between rows, s.

        Raises
        ------
        DataError
            Members of the document have different parameters.
        """
        _check_whole(written)
        chosen, direct = written.chosen_covariance, written.theta_ddm or {}
        combined = written.physical.base if written.physical else {}
        names, freedom = [*written.parameters], written.freedom or {}
        default_freedom = float(written.rows - len(direct or names))
        slopes = written.gain_slopes
        covariances = arrays(
            {
                **(written.covariances or {}),
                "iid": written.covariance,
                "robust": written.covariance_robust,
                "hac": written.covariance_hac,
            }
        )
        quantities = tuple(
            Quantity(name=name, unit=v.unit, expression=combined.get(name, ""))
            for name, v in written.parameters.items()
        )
        physical = np.array([v.value for v in written.parameters.values()])
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
            physical=physical,
            ddm_quantities=tuple(
                Quantity(name=name, unit=v.unit, expression=v.expression)
                for name, v in direct.items()
            ),
            covariances=covariances,
            covariance_notes=_covariance_notes(written),
            distribution=SamplingDistribution(
                quantities=quantities,
                theta=physical,
                covariances=covariances,
                freedom={chosen: np.array([freedom.get(name, default_freedom) for name in names])},
                chosen=chosen,
                bias=np.array(biases) if len(biases) == len(names) else None,
                by_gain=None
                if slopes is None
                else written.gain_relative_sd * np.array([slopes[name] for name in names]),
            ),
            curvatures=np.array([written.curvatures[name] for name in names]),
            iterates=tuple(
                Iterate(
                    physical=np.array([physical[name] for name in names]),
                    theta=np.array([theta[name] for name in direct or names]),
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

    @property
    def covariance_names(self) -> Mapping[str, str]:
        """Return the description of each covariance as text, by name."""
        return {name: covariance_text(note) for name, note in self.covariance_notes.items()}

    def part(self, joint: JointForm, place: int) -> "SavedEstimate":
        """Return the estimate of the parameters that apply to one of several records.

        Parameters
        ----------
        joint : JointForm
            Form of the common regression of all records.
        place : int
            Index of the record.
        """
        whole = self.distribution
        jacobian = joint.physical(joint.regressed(whole.theta))[1]
        by_whole = joint.record_jacobian(place) @ np.linalg.inv(jacobian)
        own = whole.through(
            joint.members[place].axis.parameters, joint.own(whole.theta, place), by_whole
        )
        return replace(
            self,
            parameters=own.values,
            quantities=own.quantities,
            physical=own.theta,
            covariances=own.covariances,
            correlation=correlation(own.covariances[own.chosen]),
            distribution=own,
            curvatures=np.where(by_whole == 0, 0.0, self.curvatures).max(axis=1),
        )

    def derive(self, function: FunctionLike) -> Value:
        """Return a function of the physical parameters, with its unit and interval.

        It is calculated by the delta method for every covariance, as in `Estimate.derive`.

        Parameters
        ----------
        function : str or SymPy expression
            For example ``"M/Fv"``.

        Raises
        ------
        UsageError
            The function cannot be read, or its units do not fit.
        EstimationError
            It has no finite value at the estimate.

        Warns
        -----
        RuntimeWarning
            The function is nonlinear within the uncertainty, so the delta method is inaccurate.
        """
        return self.distribution.derived(
            function, "identify again and draw: propagate()", self._curvature
        )

    def propagate(self, function: str, *, draws: int | None = None) -> DrawSummary:
        """Return the summary of the draws of a parameter that the file contains.

        Parameters
        ----------
        function : str
            Name of a parameter.
        draws : int, optional
            Number of draws, which must be the number in the file; by default that number.

        Raises
        ------
        UsageError
            The file has no such draws.
        """
        written, value = self.document.drawn or {}, self.parameters.get(function)
        if value is None or not is_among(function, written):
            raise UsageError(
                f"the file contains no draws of {quoted(function)} by {self.method}. Identify "
                "again and save with draws=2000.",
                code="result-file",
            )
        drawn = written[function]
        number = drawn.draws + drawn.lost
        if not (draws is None or (is_whole(draws) and draws == number)):
            raise UsageError(
                f"the file contains {number} draws of {function!r} by {self.method}, but draws is "
                f"{quoted(draws)}. Omit draws, or identify again and save with the other number.",
                code="result-file",
            )
        return DrawSummary(value=value.value, unit=value.unit, **asdict(drawn))

    def _curvature(self, gradient: Array, hessian: Array) -> float:
        """Return the second-order part of a standard error, relative to the first-order part.

        The map of a direct model is nonlinear too; the file contains its part per parameter.
        """
        own = self.distribution.curvature(gradient, hessian)
        return float(max([own, *self.curvatures[gradient != 0]]))


def _check_whole(written: WrittenEstimate) -> None:
    """Refuse an estimate whose members have different parameters.

    Raises
    ------
    DataError
        A matrix or a mapping does not have one entry per parameter.
    """
    check_sizes(
        f"the estimate {written.method}",
        [*written.parameters],
        {
            "covariance": written.covariance,
            "covariance_robust": written.covariance_robust,
            "covariance_hac": written.covariance_hac,
            "correlation": written.correlation,
            **(written.covariances or {}),
        },
        {
            "curvatures": written.curvatures,
            "gain_slopes": written.gain_slopes,
            **{f"iteration {i}": each for i, each in enumerate(written.iterations, 1)},
        },
    )
    check_sizes(
        f"the direct model of {written.method}",
        [*(written.theta_ddm or written.parameters)],
        {
            "theta_ddm_covariance": written.theta_ddm_covariance,
            "theta_ddm_covariance_hac": written.theta_ddm_covariance_hac,
            **(written.theta_ddm_covariances or {}),
        },
        {
            "theta_ddm_gain_slopes": written.theta_ddm_gain_slopes,
            **{
                f"iteration {i}": each
                for i, each in enumerate(written.theta_ddm_iterations or (), 1)
            },
        },
    )
    if physical := written.physical:
        check_sizes(
            f"the physical parameters by {written.method}",
            [*physical.parameters],
            {"covariance_hac": physical.covariance_hac, **(physical.covariances or {})},
            {},
        )


def arrays(written: Mapping[str, Matrix]) -> dict[str, Array]:
    """Return the matrices of a file as arrays, by name."""
    return {name: np.array(matrix) for name, matrix in written.items()}


def named(written: Mapping[str, WrittenValue], chosen: str = "hac") -> NamedValues:
    """Return the values of a document by name, as in an estimate.

    `chosen` is the name of the covariance of the intervals.
    """
    return NamedValues(
        (
            name,
            read_as(
                Value,
                v,
                # Standard errors with and without separate members.
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
