"""A fit of an output that was written as JSON, read again."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from axisid.codegen.artefacts import Quantity
from axisid.estimation.checks import Check, Levels
from axisid.estimation.diagnostics import Checked
from axisid.estimation.estimates import Distribution, NamedValues, Value, freedom_of
from axisid.modeling.text import FunctionLike
from axisid.presentation.documents import read_as
from axisid.presentation.schema import WrittenFitted, WrittenFitValidation, WrittenOutputFit
from axisid.support.arrays import Array, frozen
from axisid.support.errors import DataError
from axisid.support.files.result_file import WRITE_AGAIN
from axisid.support.presentable import Presentable

from .contradictions import contradiction
from .diagnosis import read_check, read_levels
from .identification import SavedRecord, saved_record


@dataclass(frozen=True, kw_only=True, repr=False)
class SavedOutputFit(Checked, Presentable):
    """A fit that was read from a file, with the names of `OutputFit`; see `load_result`.

    Attributes
    ----------
    file : str
    document : WrittenOutputFit
        What the file holds.
    """

    file: str
    document: WrittenOutputFit

    def __repr__(self) -> str:
        return f"fit of the {self.output}: {self.parameters.listed()}"

    def __getitem__(self, name: str) -> Value:
        return self.parameters[name]

    @property
    def name(self) -> str:
        """Of the axis."""
        return self.document.axis

    @property
    def output(self) -> str:
        """What was followed."""
        return self.document.output

    @property
    def outputs(self) -> tuple[str, ...]:
        """The same one by one; files of one output need not say it of each record."""
        told = (each.output or self.output for each in self.document.record_errors)
        return tuple(dict.fromkeys(told))

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters."""
        return tuple(self.document.parameters)

    @cached_property
    def parameters(self) -> NamedValues:
        """The parameters with unit, deviations and 95 % interval, by name."""
        chosen = self.document.chosen_covariance
        return NamedValues((n, _value(v, chosen)) for n, v in self.document.parameters.items())

    def derive(self, function: FunctionLike) -> Value:
        """Any function of the parameters, as `OutputFit.derive`, under the chosen covariance."""
        own, chosen = self.document.parameters, self.document.chosen_covariance
        freedom = np.array([freedom_of(value) for value in self.parameters.values()])
        return Distribution(
            quantities=tuple(Quantity(name=n, unit=v.unit) for n, v in own.items()),
            theta=self.physical,
            covariances={chosen: self.covariance},
            freedom={chosen: freedom},
            chosen=chosen,
            at_bound={n for n, v in own.items() if v.at_bound},
        ).derived(function, "fit again with bootstrap=")

    @property
    def physical(self) -> Array:
        """The parameters, (P,)."""
        return frozen([v.value for v in self.parameters.values()])

    @cached_property
    def covariance(self) -> Array:
        """The one that was chosen, (P, P); infinite where nothing shows a parameter."""
        rows = [[math.inf if x is None else x for x in row] for row in self.document.covariance]
        return frozen(np.array(rows, dtype=float))

    @property
    def error(self) -> float:
        """Root mean square of what is left, in the output's unit."""
        return self.document.error

    @property
    def error_percent(self) -> float:
        """Of the recorded output; of several records the largest."""
        return _or_infinite(self.document.error_percent)

    @cached_property
    def records(self) -> tuple[SavedRecord, ...]:
        """What it is of, without samples."""
        return tuple(map(saved_record, self.document.records))

    @property
    def levels(self) -> Levels:
        """From when on something was told as missing of the model."""
        return read_levels(self.document.levels)

    @cached_property
    def checks(self) -> tuple[Check, ...]:
        """Whether to believe it."""
        return tuple(map(read_check, self.document.verdict))


@dataclass(frozen=True, kw_only=True)
class SavedFitValidation(Checked, Presentable):
    """A frozen fit on a second record, read from a file, with the names of `FitValidation`.

    Attributes
    ----------
    file : str
    document : WrittenFitValidation
        What the file holds.
    record : SavedRecord

    Notes
    -----
    What else there is, is as of a `FitValidation`.
    """

    file: str
    document: WrittenFitValidation = field(repr=False)
    record: SavedRecord
    output: str
    unit: str
    horizon: float | None
    error: float
    percent: float
    checks: tuple[Check, ...]

    @classmethod
    def of(cls, file: str, document: WrittenFitValidation) -> "SavedFitValidation":
        """As a file has it."""
        return read_as(
            cls,
            document,
            {"percent": math.inf},
            file=file,
            document=document,
            record=saved_record(document.record),
            checks=tuple(map(read_check, document.verdict)),
        )


def read_output_fit(file: str, document: WrittenOutputFit) -> SavedOutputFit:
    """A document as a result; refused where its members do not belong together.

    Raises
    ------
    DataError
        The covariance is not of the parameters, nothing is left of a record, or a deviation or an
        interval cannot be.
    """
    count = len(document.parameters)
    rows = [len(row) for row in document.covariance]
    saved = SavedOutputFit(file=file, document=document)
    left, followed = len(document.record_errors), len(saved.outputs)
    if rows != [count] * count or left != followed * len(document.records):
        raise DataError(
            f"{file} has {count} parameters and a covariance of {len(rows)}, and what is left of "
            f"{len(document.record_errors)} of {len(document.records)} records. ",
            WRITE_AGAIN,
            code="saved-fit",
        )
    for problem in _contradictions(document):
        raise contradiction(file, problem)
    return saved


def _contradictions(document: WrittenOutputFit) -> Iterator[str]:
    """What of the parameters cannot be."""
    for name, written in document.parameters.items():
        deviations = [sd for sd in (written.sd, *written.deviations.values()) if sd is not None]
        if min(deviations, default=0.0) < 0:
            yield f"a deviation of {name} is negative"
        if document.chosen_covariance not in written.deviations:
            yield f"{name} has no deviation for the covariance {document.chosen_covariance!r}"
        elif written.deviations[document.chosen_covariance] != written.sd:
            yield f"the deviation of {name} is not its covariance's"
        value = _value(written, document.chosen_covariance)
        if not value.interval[0] <= value.value <= value.interval[1]:
            yield f"the interval of {name} does not hold its value"
        if written.prior and not written.prior.sd > 0:
            yield f"what was known of {name} has the deviation {written.prior.sd:g}"


def _value(written: WrittenFitted, chosen: str) -> Value:
    low, high = written.interval_95
    return Value(
        value=written.value,
        unit=written.unit,
        deviations={n: _or_infinite(sd) for n, sd in written.deviations.items()},
        interval=(-math.inf if low is None else low, _or_infinite(high)),
        chosen=chosen,
    )


def _or_infinite(value: float | None) -> float:
    return math.inf if value is None else value
