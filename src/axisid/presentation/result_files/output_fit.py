"""Fits of an output and their validations as documents, written and read."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from msgspec import UNSET, UnsetType

from axisid.estimation.estimates import NamedValues, Value
from axisid.estimation.misspecification import misspecification_finding
from axisid.estimation.model_validation import FitValidation
from axisid.estimation.output_error import FittedParameters, OutputFit, RecordError
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Check, Checked, Levels
from axisid.modeling.parsing import FunctionLike
from axisid.presentation.sentences import (
    unseen_text,
)
from axisid.support.arrays import Array, Exact, MaybeInfinite
from axisid.support.missing import Missing
from axisid.support.presentable import Presentable

from .checks import WrittenCheck, read_checks, written_checks
from .diagnosis import WrittenLawCheck, written_law
from .estimate import left_out
from .json_objects import (
    JsonObject,
    WrittenKnown,
    WrittenResult,
    about,
    by_name,
    check_sizes,
    read_as,
    written_as,
)
from .record import WrittenRecord, written_record


class WrittenFitted(JsonObject, frozen=True, kw_only=True):
    """A parameter of a fit."""

    value: Annotated[float, about("In `unit`.")]
    unit: Annotated[str, about("Coherent SI.")]
    sd: Annotated[
        float | None, about("Standard error by the chosen covariance; null if not identified.")
    ]
    deviations: Annotated[
        Mapping[str, MaybeInfinite],
        about(
            "Standard errors by covariance: coloured (autoregressive output errors), iid "
            "(independent ones) and, if there are simulated replicas, bootstrap."
        ),
    ]
    interval_95: Annotated[
        tuple[float | None, float | None],
        about("One-sided if the parameter is at a bound."),
    ]
    start: Annotated[float, about("Start value of the search.")]
    bounds: Annotated[
        tuple[float | None, float | None], about("Lower and upper bound; null for none.")
    ]
    at_bound: Annotated[
        Literal["lower", "upper"] | None, about("Bound that the estimate is at; null for none.")
    ]
    fixed: Annotated[bool, about("True if the parameter was fixed.")]
    prior: Annotated[
        WrittenKnown | None, about("Known value that was used with its standard error as weight.")
    ]
    law_percent: Annotated[
        Mapping[str, float],
        about("Change of the value, SI, if a term of the law is 1 % larger; by gains of the term."),
    ]
    law_move: Annotated[
        float | None,
        about("Change of the value, SI, with the recorded law instead of the declared one."),
    ]


class WrittenLack(JsonObject, frozen=True, kw_only=True):
    """A term that the model lacks, by the residuals of the fit."""

    subject: Annotated[str, about("Description of the term.")]
    size: Annotated[float, about("Its factor, or the change of a parameter.")]
    deviation: Annotated[float, about("Standard error of `size`.")]
    unit: Annotated[str, about("Unit of `size` and `deviation`.")]
    chance: Annotated[
        float, about("Probability that noise alone causes such a size, over all tested places.")
    ]


class WrittenOutputFit(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.fit/1"
):
    """Document written by `axisid fit --json`."""

    axis: str
    signature: Annotated[str, about("sha256 of the source of the generated code.")]
    left_out: Annotated[
        Mapping[str, float],
        about("Values of the parameters that were left out, SI, by name."),
    ]
    records: tuple[WrittenRecord, ...]
    output: Annotated[str, about("Fitted output; several are joined by and.")]
    unit: Annotated[str, about("Unit of the output, or of the first of several.")]
    position_unit: Annotated[str, about("Unit of the coordinate.")]
    encoder_step: Annotated[float, about("Step of the coarsest encoder, SI; 0 if unknown.")]
    horizon: Annotated[float | UnsetType, about("Length of the windows of an open loop, s.")] = (
        UNSET
    )
    loss: str
    started: Annotated[str, about("Origin of the start values.")]
    parameters: Annotated[Mapping[str, WrittenFitted], about("By name.")]
    covariance: Annotated[
        tuple[tuple[MaybeInfinite, ...], ...],
        about("Chosen covariance of the parameters, in their order; null for infinite."),
    ]
    chosen_covariance: str
    error: Annotated[float, about("Rms residual of the (first) output, in `unit`.")]
    error_percent: Annotated[
        float | None, about("Rms residual relative to the rms of the output; the largest of all.")
    ]
    percent_beyond_noise: Annotated[
        float | None,
        about("Part of the residual beyond noise, relative to the rms of the output."),
    ]
    record_errors: Annotated[tuple[RecordError, ...], about("By record, and in each by output.")]
    lacks: Annotated[
        tuple[WrittenLack, ...] | None,
        about("Missing terms, the most significant first; null if not tested."),
    ]
    unseen: Annotated[tuple[str, ...], about("Parameters that no output identifies, as text.")]
    local: Annotated[
        Mapping[str, tuple[str, ...]] | UnsetType,
        about("Parameters with a separate value for each record: names by record."),
    ] = UNSET
    known: Annotated[
        Mapping[str, tuple[WrittenKnown, ...]] | UnsetType,
        about("Known values of each record, SI, by name."),
    ] = UNSET
    iterations: Annotated[
        tuple[Mapping[str, float], ...], about("Parameters at each step of the search, SI.")
    ]
    iteration_errors: Annotated[tuple[float, ...], about("Rms residual at each step, in `unit`.")]
    costs: Annotated[tuple[float, ...], about("Cost at the end of each search.")]
    law_check: WrittenLawCheck
    verdict: tuple[WrittenCheck, ...]
    believed: Annotated[bool, about("True if `belief` is believed.")]
    levels: Levels | UnsetType = UNSET
    remarks: tuple[str, ...]


class SavedFitValidation(
    Checked,
    Presentable,
    WrittenResult,
    frozen=True,
    kw_only=True,
    tag_field="schema",
    tag="axisid.fit_validation/1",
):
    """A frozen fit on a second record, without samples, with the attributes of `FitValidation`."""

    record: WrittenRecord
    output: Annotated[str, about("Output that is compared with the record.")]
    unit: Annotated[str, about("Unit of the output.")]
    horizon: Annotated[float | None, about("Length of the windows of an open loop, s.")]
    error: Annotated[float, about("Rms residual, in `unit`.")]
    percent: Annotated[
        MaybeInfinite, about("Rms residual relative to the rms of the recorded output.")
    ]
    verdict: tuple[WrittenCheck, ...]

    @property
    def checks(self) -> tuple[Check, ...]:
        """Return the checks of its verdict."""
        return read_checks(self.verdict)


def written_fit_validation(validation: FitValidation) -> SavedFitValidation:
    """Return the document of a fit validated on a second record."""
    return written_as(
        SavedFitValidation,
        validation,
        record=written_record(validation.record),
        verdict=written_checks(validation.checks),
    )


def written_output_fit(fit: OutputFit) -> WrittenOutputFit:
    """Return the document of a fit: settings, parameters, errors and verdict."""
    return written_as(
        WrittenOutputFit,
        fit,
        axis=fit.axis.axis.name,
        signature=fit.axis.signature,
        left_out=left_out(fit.axis),
        records=tuple(written_record(record) for record in fit.records),
        position_unit=str(fit.axis.axis.coordinate.unit),
        encoder_step=fit.predictions.step,
        parameters={name: _fitted(fit, j, name) for j, name in enumerate(fit.names)},
        chosen_covariance=fit.chosen,
        record_errors=fit.of_records,
        lacks=_lacks(fit),
        unseen=tuple(map(unseen_text, fit.unseen)),
        horizon=UNSET if fit.horizon is None else fit.horizon,
        local=dict(fit.local) or UNSET,
        known={
            name: tuple(WrittenKnown(value=value, sd=sd) for value, sd in of_records)
            for name, of_records in fit.known.items()
        }
        or UNSET,
        iterations=tuple(by_name(fit.names, step.physical) for step in fit.best.steps),
        iteration_errors=tuple(step.error for step in fit.best.steps),
        costs=tuple(each.cost for each in fit.searches),
        law_check=written_law(fit.law),
        verdict=written_checks(fit.checks),
    )


def _lacks(fit: OutputFit) -> tuple[WrittenLack, ...] | None:
    """Return the missing terms of all tested records; None if no record was tested."""
    if all(isinstance(lacks, Missing) for lacks in fit.lacks):
        return None
    return tuple(
        WrittenLack(
            subject=misspecification_finding(each, axis, record).sentence,
            size=each.size,
            deviation=each.deviation,
            unit=each.unit,
            chance=each.p_value,
        )
        for lacks, axis, record in zip(fit.lacks, fit.axes, fit.records, strict=True)
        if not isinstance(lacks, Missing)
        for each in lacks
    )


def _fitted(fit: OutputFit, place: int, name: str) -> WrittenFitted:
    """Return one parameter of a fit as part of a document; `place` is its index."""
    value, known = fit.parameters[name], fit.prior.get(name)
    return written_as(
        WrittenFitted,
        value,
        sd=value.deviation,
        start=float(fit.start[place]),
        bounds=fit.bounds[name],
        at_bound=fit.at_bound.get(name),
        fixed=name in fit.fixed,
        prior=None if known is None else WrittenKnown(value=known[0], sd=known[1]),
        law_percent={term: float(move[place]) for term, move in fit.law_moves.items()},
        law_move=None if fit.law_move is None else float(fit.law_move[place]),
    )


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class SavedOutputFit(FittedParameters, Checked, Presentable, Exact):
    """A fit that was read from a file, with the attributes of `OutputFit`; see `load_result`.

    Attributes
    ----------
    file : str
        Name of the file; empty if the fit was not read from a file.
    document : WrittenOutputFit
        Content of the file.
    name : str
        Name of the axis.
    output : str
        Fitted output; several outputs are joined by "and".
    outputs : tuple of str
        Fitted outputs.
    covariances : mapping of str to (P, P) array
        The chosen covariance of the P parameters, by its name.
    error : float
        Rms residual, in the unit of the output.
    error_percent : float
        Rms residual relative to the rms of the output; the largest of several records.
    records : tuple of WrittenRecord
        Fitted records, without samples.
    levels : Levels
        Levels above which a term was reported as missing.
    checks : tuple of Check
        Checks of the verdict.
    local : mapping of str to tuple of str
        Names by record of each parameter with a separate value for each record.
    law_moves, law_move
        See `OutputFit.law_moves` and `OutputFit.law_move`.
    """

    file: str
    document: WrittenOutputFit
    name: str
    output: str
    outputs: tuple[str, ...]
    error: float
    error_percent: MaybeInfinite
    records: tuple[WrittenRecord, ...]
    levels: Levels
    checks: tuple[Check, ...]
    local: Mapping[str, tuple[str, ...]]
    law_moves: Mapping[str, Array]
    law_move: Array | None

    @classmethod
    def of(cls, file: str, written: WrittenOutputFit) -> "SavedOutputFit":
        """Return the fit of a document; `file` is the name of its file.

        Raises
        ------
        DataError
            The covariance does not match the parameters.
        """
        chosen, fitted = written.chosen_covariance, [*written.parameters.values()]
        check_sizes("the fit", [*written.parameters], {"covariance": written.covariance}, {})
        moves = [v.law_move for v in fitted]
        return read_as(
            cls,
            written,
            file=file,
            document=written,
            name=written.axis,
            # Files of one output may omit it for each record.
            outputs=tuple(dict.fromkeys(e.output or written.output for e in written.record_errors)),
            parameters=NamedValues(
                (
                    name,
                    read_as(
                        Value,
                        v,
                        interval=(
                            -math.inf if low is None else low,
                            math.inf if high is None else high,
                        ),
                        chosen=chosen,
                    ),
                )
                for name, v in written.parameters.items()
                for low, high in [v.interval_95]
            ),
            physical=np.array([v.value for v in fitted]),
            chosen=chosen,
            covariances={chosen: np.array(written.covariance)},
            levels=written.levels or DEFAULT_LEVELS,
            checks=read_checks(written.verdict),
            local=written.local or {},
            law_moves={
                term: np.array([v.law_percent[term] for v in fitted])
                for term in fitted[0].law_percent
            },
            law_move=None if None in moves else np.array(moves, dtype=float),
        )

    def __repr__(self) -> str:
        return f"fit of the {self.output}: {self.parameters.listed()}"

    def derive(self, function: FunctionLike) -> Value:
        """Return a function of the parameters with its unit and interval.

        It is calculated as in `OutputFit.derive`, but only by the chosen covariance.
        """
        at_bound = {name for name, v in self.document.parameters.items() if v.at_bound}
        return self.distribution(at_bound).derived(function, "fit again with bootstrap=")
