"""Fits of an output and their validations as documents, written and read again."""

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
from axisid.support.errors import Missing
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
    sd: Annotated[float | None, about("Of the chosen covariance; null where nothing shows it.")]
    deviations: Annotated[
        Mapping[str, MaybeInfinite],
        about(
            "By covariance: coloured errors, independent ones; where there are twins, "
            "bootstrap by them."
        ),
    ]
    interval_95: Annotated[
        tuple[float | None, float | None],
        about("On the allowed side alone where the parameter is at a bound."),
    ]
    start: Annotated[float, about("Where the search began.")]
    bounds: Annotated[tuple[float | None, float | None], about("In force; null for none.")]
    at_bound: Annotated[Literal["lower", "upper"] | None, about("Whether it is driven to one.")]
    fixed: Annotated[bool, about("Whether it was held.")]
    prior: Annotated[WrittenKnown | None, about("What was known before, and weighed.")]
    law_percent: Annotated[
        Mapping[str, float],
        about("What each term of the law, 1 % larger, moves it by, SI, by the term's gains."),
    ]
    law_move: Annotated[
        float | None, about("What the law as recorded, in place of the declared one, moves it by.")
    ]


class WrittenLack(JsonObject, frozen=True, kw_only=True):
    """What errors ask for beside a model."""

    subject: Annotated[str, about("In words.")]
    size: Annotated[float, about("Of its factor, or by how much a parameter would be more.")]
    deviation: Annotated[float, about("Of the size.")]
    unit: Annotated[str, about("Of both.")]
    chance: Annotated[float, about("That noise asks for as much of it, over all its places.")]


class WrittenOutputFit(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.fit/1"
):
    """What `axisid fit --json` writes."""

    axis: str
    signature: Annotated[str, about("sha256 of what the generated code was made from.")]
    left_out: Annotated[
        Mapping[str, float],
        about("What stands for the parameters that were left out, SI, by name."),
    ]
    records: tuple[WrittenRecord, ...]
    output: Annotated[str, about("What is followed; several are joined by and.")]
    unit: Annotated[str, about("Of the output; of several the first.")]
    position_unit: Annotated[str, about("Of the coordinate.")]
    encoder_step: Annotated[float, about("Of the coarsest encoder, SI; 0 where none is known.")]
    horizon: Annotated[float | UnsetType, about("Length of the windows of an open loop, s.")] = (
        UNSET
    )
    loss: str
    started: Annotated[str, about("Where the start is from.")]
    parameters: Annotated[Mapping[str, WrittenFitted], about("By name.")]
    covariance: Annotated[
        tuple[tuple[MaybeInfinite, ...], ...],
        about("Of the parameters in their order, the chosen one; null for infinite."),
    ]
    chosen_covariance: str
    error: Annotated[
        float, about("Root mean square of what is left, in `unit`; of several outputs the first's.")
    ]
    error_percent: Annotated[float | None, about("Of the recorded output; the largest of all.")]
    percent_beyond_noise: Annotated[
        float | None,
        about("Part of the recorded output that is left beyond noise."),
    ]
    record_errors: Annotated[tuple[RecordError, ...], about("By record, and in each by output.")]
    lacks: Annotated[
        tuple[WrittenLack, ...] | None,
        about("What is asked for beside the model, the strongest first; null where not looked."),
    ]
    unseen: Annotated[tuple[str, ...], about("What no output shows, in words.")]
    local: Annotated[
        Mapping[str, tuple[str, ...]] | UnsetType,
        about("Parameters that records have for themselves: their names by record."),
    ] = UNSET
    known: Annotated[
        Mapping[str, tuple[WrittenKnown, ...]] | UnsetType,
        about("What is known of each record, SI, by name."),
    ] = UNSET
    iterations: Annotated[
        tuple[Mapping[str, float], ...], about("Parameters where slopes were taken, SI.")
    ]
    iteration_errors: Annotated[tuple[float, ...], about("Root mean square there, in `unit`.")]
    costs: Annotated[tuple[float, ...], about("Of each search's end, where several were made.")]
    law_check: WrittenLawCheck
    verdict: tuple[WrittenCheck, ...]
    believed: Annotated[bool, about("Whether `belief` is believed.")]
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
    """A frozen fit on a second record, without its samples, with the names of `FitValidation`."""

    record: WrittenRecord
    output: Annotated[str, about("What is held against the record.")]
    unit: Annotated[str, about("Of the output.")]
    horizon: Annotated[float | None, about("Length of the windows of an open loop, s.")]
    error: Annotated[float, about("Root mean square of what is left, in `unit`.")]
    percent: Annotated[MaybeInfinite, about("Of the recorded output's.")]
    verdict: tuple[WrittenCheck, ...]

    @property
    def checks(self) -> tuple[Check, ...]:
        """Return the checks of its verdict."""
        return read_checks(self.verdict)


def written_fit_validation(validation: FitValidation) -> SavedFitValidation:
    """What is left of a second record, and whether the fit holds on it."""
    return written_as(
        SavedFitValidation,
        validation,
        record=written_record(validation.record),
        verdict=written_checks(validation.checks),
    )


def written_output_fit(fit: OutputFit) -> WrittenOutputFit:
    """The parameters with all that was asked and found of each, and whether to believe them."""
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
    """Of all records in which it was looked for; None where it was in none."""
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
    """A fit that was read from a file, with the names of `OutputFit`; see `load_result`.

    Attributes
    ----------
    file : str
    document : WrittenOutputFit
        What the file holds.
    name : str
        Of the axis.
    output : str
        What was followed.
    outputs : tuple of str
        The same one by one.
    covariances : mapping of str to (P, P) array
        The one that was chosen alone.
    error : float
        Root mean square of what is left, in the output's unit.
    error_percent : float
        The same of the recorded output; of several records the largest.
    records : tuple of WrittenRecord
        What it is of, without samples.
    levels : Levels
        From when on something was told as missing of the model.
    checks : tuple of Check
        Whether to believe it.
    local : mapping of str to tuple of str
        Names of each parameter that records have for themselves, by record.
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
        """What a document tells."""
        chosen, fitted = written.chosen_covariance, [*written.parameters.values()]
        check_sizes("the fit", [*written.parameters], {"covariance": written.covariance}, {})
        moves = [v.law_move for v in fitted]
        return read_as(
            cls,
            written,
            file=file,
            document=written,
            name=written.axis,
            # Files of one output need not say it of each record.
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
        """Any function of the parameters, as `OutputFit.derive`, under the chosen covariance."""
        at_bound = {name for name, v in self.document.parameters.items() if v.at_bound}
        return self.distribution(at_bound).derived(function, "fit again with bootstrap=")
