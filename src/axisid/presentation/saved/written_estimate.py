"""One method's estimate as its document. The names are a contract with other programs."""

from collections.abc import Iterable, Mapping, Set
from typing import Annotated, Any, Literal, TypeVar

from msgspec import UNSET, UnsetType

from axisid.codegen.artefacts import GeneratedAxis, Quantity
from axisid.estimation.estimates import Estimate, Physical, Value
from axisid.estimation.regression import Drawn, ResidualTests
from axisid.estimation.twins import Chain
from axisid.support.arrays import Array, finite

from .values import JsonObject, Matrix, WrittenKnown, about, written_as


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
        Mapping[str, float | None],
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


T = TypeVar("T")

_NAMED = frozenset({"iid", "robust", "hac"})  # covariances that have members of their own
_NAMED_DIRECT = frozenset({"iid", "hac"})  # the same of the direct model's parameters
_NAMED_PHYSICAL = frozenset({"hac"})  # and of those that follow from known values


def written_estimate(
    estimate: Estimate,
    drawn: Mapping[str, Drawn] | Any = UNSET,
    physical: WrittenPhysical | Any = UNSET,
) -> WrittenEstimate:
    """One estimate; statistics that are not finite become None."""
    direct, iterates = bool(estimate.ddm_quantities), estimate.iterates
    return written_as(
        WrittenEstimate,
        estimate,
        parameters={name: written_value(v) for name, v in estimate.parameters.items()},
        theta_ddm={
            q.name: written_as(
                WrittenDirectValue,
                estimate.ddm_parameters[q.name],
                deviations=_others(estimate.ddm_parameters[q.name].deviations) or UNSET,
                expression=q.expression,
            )
            for q in estimate.ddm_quantities
        }
        or None,
        covariance=matrix(estimate.covariances["iid"]),
        covariance_robust=matrix(estimate.covariances["robust"]),
        covariance_hac=matrix(estimate.covariances["hac"]),
        covariances=_further(estimate.covariances, estimate.chosen, _NAMED),
        theta_ddm_covariance=matrix(estimate.ddm_covariances["iid"]) if direct else None,
        theta_ddm_covariance_hac=matrix(estimate.ddm_covariances["hac"]) if direct else None,
        theta_ddm_covariances=_further(estimate.ddm_covariances, estimate.chosen, _NAMED_DIRECT),
        chains=tuple(each.likeliest for each in estimate.inference.chains) or UNSET,
        chosen_covariance=estimate.chosen,
        rows=len(estimate.y),
        iterations=tuple(_named(estimate.quantities, i.physical) for i in iterates),
        theta_ddm_iterations=tuple(_named(estimate.ddm_quantities, i.theta) for i in iterates)
        if direct
        else None,
        iteration_simulation_errors_percent=tuple(i.simulation_error_percent for i in iterates),
        started=estimate.started or UNSET,
        loss=UNSET if estimate.counts is None else estimate.loss,
        light_rows=UNSET if estimate.counts is None else int(estimate.light_rows.sum()),
        curvatures={
            q.name: finite(c) for q, c in zip(estimate.quantities, estimate.curvatures, strict=True)
        },
        freedom=_named(estimate.quantities, estimate.freedom[estimate.chosen]),
        drawn=drawn,
        physical=physical,
        gain_slopes=_slopes(estimate.quantities, estimate.inference.gain_slopes),
        theta_ddm_gain_slopes=_slopes(estimate.ddm_quantities, estimate.inference.theta_gain_slopes)
        if direct
        else None,
    )


def _slopes(quantities: Iterable[Quantity], slopes: Array | None) -> dict[str, float] | None:
    return None if slopes is None else _named(quantities, slopes)


def drawn_parameters(estimate: Estimate, draws: int) -> dict[str, Drawn]:
    """Every parameter over draws; None where no draw gave an axis."""
    return {
        name: written_as(Drawn, estimate.propagate(name, draws=draws))
        for name in estimate.parameters
    }


def written_physical(physical: Physical, chosen: str) -> WrittenPhysical:
    """Declared parameters that follow from the base parameters and from what is known."""
    return written_as(
        WrittenPhysical,
        physical,
        parameters={name: written_value(v) for name, v in physical.parameters.items()},
        covariance_hac=matrix(physical.covariances["hac"]),
        covariances=_further(physical.covariances, chosen, _NAMED_PHYSICAL),
        base={p.name: p.description for p in physical.combined},
        fixed={
            p.name: written_as(WrittenKnown, p, value=p.known, sd=p.known_sd)
            for p in physical.known
        },
    )


def left_out(axis: GeneratedAxis) -> dict[str, float]:
    """What stands for the parameters that were left out, by name."""
    return {p.name: p.known for p in axis.declared.left_out if p.known is not None}


def _others(by_covariance: Mapping[str, T]) -> dict[str, T]:
    """What is of covariances that have no member of their own."""
    return {name: each for name, each in by_covariance.items() if name not in _NAMED}


def _further(
    covariances: Mapping[str, Array], chosen: str, written: Set[str]
) -> dict[str, Matrix] | UnsetType:
    """Covariances that are not written elsewhere: the chosen one, and those of later rows.

    Robust and i.i.d. ones that no interval is of are left out, as in every file so far.
    """
    wanted = {chosen, *_others(covariances)} - written
    return {name: matrix(c) for name, c in covariances.items() if name in wanted} or UNSET


def written_value(value: Value) -> WrittenValue:
    """A number with unit, deviations and interval."""
    return written_as(WrittenValue, value, deviations=_others(value.deviations) or UNSET)


def matrix(values: Array) -> Matrix:
    """An array as a document holds it."""
    return tuple(map(tuple, values.tolist()))


def _named(quantities: Iterable[Quantity], values: Array) -> dict[str, float]:
    return {q.name: float(value) for q, value in zip(quantities, values, strict=True)}
