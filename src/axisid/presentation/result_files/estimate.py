"""One method's estimate as its file has it: what can be said without the rows it was made from.

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
from axisid.support.errors import UsageError, is_among, is_whole, quoted
from axisid.support.presentable import Presentable

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
    """A number with unit, deviations and interval."""

    value: Annotated[float, about("In `unit`.")]
    unit: Annotated[str, about("Coherent SI.")]
    sd: Annotated[
        float,
        about("Standard deviation for independent residuals, as in the published tables."),
    ]
    relative_sd_percent: Annotated[float | None, about("100 sd / |value|; null for a value of 0.")]
    sd_robust: Annotated[float, about("For residuals of any variance.")]
    sd_hac: Annotated[float, about("For autocorrelated residuals too.")]
    interval_95: Annotated[
        tuple[float, float],
        about(
            "About the value less filter_bias, from the chosen covariance and Student's "
            "distribution."
        ),
    ]
    sd_gain: Annotated[
        float,
        about("What the drive gain's declared deviation adds, in no other figure."),
    ]
    filter_bias: Annotated[
        float | None,
        about(
            "What filter and noise move the value by, as twins of the record tell; the value "
            "contains it, the interval does not; null without twins."
        ),
    ]
    deviations: Annotated[
        Mapping[str, float] | UnsetType,
        about("Under covariances that have no member of their own."),
    ] = UNSET


class WrittenDirectValue(WrittenValue, frozen=True, kw_only=True):
    """A parameter of the direct model."""

    expression: Annotated[str, about("In physical parameters.")]


class WrittenPhysical(JsonObject, frozen=True, kw_only=True):
    """Declared parameters from the base parameters and from what is declared as known.

    Absent where the estimate is of the declared parameters and none is known.
    """

    parameters: Annotated[Mapping[str, WrittenValue], about("Those that follow, by name.")]
    covariance_hac: Annotated[Matrix, about("Of these, in their order.")]
    base: Annotated[
        Mapping[str, str],
        about("Base parameters that are no declared ones, in declared ones."),
    ]
    fixed: Annotated[Mapping[str, WrittenKnown], about("What is declared as known, by name.")]
    unsettled: Annotated[
        tuple[str, ...],
        about("Which parameters do not follow, and what would have to be known."),
    ]
    statistic: Annotated[
        float,
        about("Squared distance of what was fixed from the record in deviations, Hotelling's."),
    ]
    dof: Annotated[int, about("Its degrees of freedom; 0 where nothing can contradict.")]
    p_value: float | None
    remarks: tuple[str, ...]
    covariances: Annotated[
        Mapping[str, Matrix] | UnsetType,
        about("Of `parameters`: the chosen one, where it has no member of its own."),
    ] = UNSET


class WrittenEstimate(JsonObject, frozen=True, kw_only=True):
    """One method's estimate."""

    method: Annotated[str, about("As identify takes it.")]
    parameters: Annotated[Mapping[str, WrittenValue], about("Physical, by name.")]
    theta_ddm: Annotated[Mapping[str, WrittenDirectValue] | None, about("Of the direct model.")]
    covariance: Annotated[Matrix, about("Of the physical parameters, for independent residuals.")]
    covariance_robust: Matrix
    covariance_hac: Matrix
    theta_ddm_covariance: Matrix | None
    theta_ddm_covariance_hac: Matrix | None
    correlation: Annotated[Matrix, about("Of the physical parameters, of the chosen covariance.")]
    covariance_names: Annotated[
        Mapping[str, str],
        about("What each covariance is, with lags and corrections."),
    ]
    covariance_notes: Annotated[
        Mapping[str, CovarianceNote] | UnsetType,
        about("The same as data; files of earlier versions have the text alone."),
    ] = UNSET
    chains: Annotated[
        tuple[Chain, ...] | UnsetType,
        about("The noise of each record, SI, as its twins have it; left out without twins."),
    ] = UNSET
    chosen_covariance: Annotated[
        str,
        about(
            "The covariance (hac, robust, iid or another) that interval_95, correlation, "
            "curvatures and draws are of."
        ),
    ]
    equation_error_percent: Annotated[
        float,
        about("100 ||y - X theta|| / ||y||; no quality of an instrumental estimate."),
    ]
    simulation_error_percent: Annotated[
        float | None,
        about("100 ||y - simulated|| / ||y||; null where the loop could not be simulated."),
    ]
    rows: int
    condition_number: Annotated[float, about("Of X, not scaled.")]
    iterations: Annotated[
        tuple[Mapping[str, float], ...],
        about("Physical parameters by iterate, SI; empty for least squares."),
    ]
    theta_ddm_iterations: Annotated[
        tuple[Mapping[str, float], ...] | None, about("The same of the direct model, SI.")
    ]
    iteration_simulation_errors_percent: tuple[float, ...]
    loss: Annotated[
        Literal["huber", "bisquare"] | UnsetType,
        about("How rows counted; left out where all do alike."),
    ] = UNSET
    light_rows: Annotated[
        int | UnsetType, about("Rows that counted for less than half, with such a loss.")
    ] = UNSET
    started: Annotated[
        Literal["least-squares", "nominal"] | UnsetType,
        about("Where the iteration started; left out for least squares."),
    ] = UNSET
    curvatures: Annotated[
        Mapping[str, MaybeInfinite],
        about(
            "Second-order part of each physical deviation against the first; the delta method "
            "is enough up to 0.1."
        ),
    ]
    freedom: Annotated[
        Mapping[str, float] | UnsetType,
        about("Degrees of freedom, of Student's distribution, of each physical interval_95."),
    ] = UNSET
    residual_tests: ResidualTests
    remarks: tuple[str, ...]
    drawn: Annotated[Mapping[str, Drawn] | UnsetType | None, about("With draws=.")] = UNSET
    physical: WrittenPhysical | UnsetType = UNSET
    covariances: Annotated[
        Mapping[str, Matrix] | UnsetType,
        about("Of the physical parameters, those that have no member of their own."),
    ] = UNSET
    theta_ddm_covariances: Annotated[
        Mapping[str, Matrix] | UnsetType,
        about("Of the direct model: the chosen one, where it has no member of its own."),
    ] = UNSET
    gain_relative_sd: Annotated[
        float, about("Of the drive gain; 0 where it is exact or the force was measured.")
    ]
    gain_slopes: Annotated[
        Mapping[str, float] | None,
        about(
            "Of the physical parameters by the logarithm of the drive gain; null for an exact one."
        ),
    ]
    theta_ddm_gain_slopes: Annotated[
        Mapping[str, float] | None, about("The same of the direct model.")
    ]


_Number = TypeVar("_Number", bound=WrittenValue)
_NAMED = frozenset({"iid", "robust", "hac"})  # covariances that have members of their own


def written_estimate(
    estimate: Estimate,
    drawn: Mapping[str, Drawn] | Any = UNSET,
    physical: WrittenPhysical | Any = UNSET,
) -> WrittenEstimate:
    """One estimate; statistics that are not finite become None."""
    names, direct = ([q.name for q in of] for of in (estimate.quantities, estimate.ddm_quantities))
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
    """Return what each covariance is, as a file has it."""
    if isinstance(written.covariance_notes, UnsetType):
        texts = written.covariance_names.items()
        return {name: CovarianceNote(kind="other", label=text) for name, text in texts}
    return written.covariance_notes


def _slopes(names: Iterable[str], slopes: Array | None) -> dict[str, float] | None:
    return None if slopes is None else by_name(names, slopes)


def written_physical(physical: Physical, chosen: str) -> WrittenPhysical:
    """Declared parameters that follow from the base parameters and from what is known."""
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
    """What stands for the parameters that were left out, by name."""
    return {p.name: p.known for p in axis.declared.left_out if p.known is not None}


def _further(
    covariances: Mapping[str, Array], chosen: str, written_elsewhere: Set[str]
) -> dict[str, Array] | UnsetType:
    """Covariances that are not written elsewhere: the chosen one, and those of later rows.

    Robust and i.i.d. ones that no interval is of are left out, as in every file so far.
    """
    wanted = {chosen, *(covariances.keys() - _NAMED)} - written_elsewhere
    return {name: c for name, c in covariances.items() if name in wanted} or UNSET


def _written(kind: type[_Number], value: Value, **others: Any) -> _Number:
    """A number with unit, deviations and interval."""
    return written_as(
        kind,
        value,
        deviations={n: sd for n, sd in value.deviations.items() if n not in _NAMED} or UNSET,
        **others,
    )


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class SavedEstimate(EstimateFacts, Presentable, Exact):
    """An estimate that was read from a file, with the names of `Estimate`.

    What is not listed is as of an `Estimate`.

    Attributes
    ----------
    document : WrittenEstimate
        What the file holds of it.
    parameters : NamedValues
        Physical parameters by name.
    ddm_parameters : NamedValues
        Those of the direct model; none for an inverse model.
    covariances : mapping of str to array
        Of `parameters`, (p, p), by name.
    distribution : SamplingDistribution
        Of `parameters`.
    curvatures : (p,) array
        Second-order part of each physical parameter's deviation against the first.
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
        """What a document tells of an estimate."""
        _check_whole(written)
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
                freedom={chosen: np.array([free.get(name, float(usual)) for name in names])},
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
        """Notes on each covariance as text."""
        return {name: covariance_text(note) for name, note in self.covariance_notes.items()}

    def part(self, joint: JointForm, place: int) -> "SavedEstimate":
        """The same in the parameters of the axis that one of several records has."""
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
        return self.distribution.derived(
            function, "identify again and draw: propagate()", self._curvature
        )

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


def _check_whole(written: WrittenEstimate) -> None:
    """Refuse an estimate whose members are not of the same parameters.

    Raises
    ------
    DataError
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
    """Matrices of a file, by name."""
    return {name: np.array(matrix) for name, matrix in written.items()}


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
