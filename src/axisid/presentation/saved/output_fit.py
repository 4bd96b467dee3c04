"""Fits of an output and studies that were written as JSON, read again."""

import math
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
from msgspec import UnsetType

from axisid.codegen.artefacts import Quantity
from axisid.estimation.checks import DEFAULT_LEVELS, Check, Levels
from axisid.estimation.diagnostics import Checked
from axisid.estimation.estimates import (
    NamedValues,
    SamplingDistribution,
    Value,
    degrees_of_freedom_of,
)
from axisid.estimation.monte_carlo import (
    CheckFigures,
    EstimandFigures,
    FailedRun,
    Share,
    StudyFigures,
    declared_chain,
)
from axisid.estimation.twins import Chain
from axisid.modeling.text import FunctionLike
from axisid.presentation.documents import number, read_as
from axisid.presentation.schema import (
    WrittenFitted,
    WrittenFitValidation,
    WrittenMonteCarlo,
    WrittenOutputFit,
    WrittenRecord,
)
from axisid.support.arrays import Array, Exact, MaybeInfinite, frozen
from axisid.support.errors import DataError
from axisid.support.files import WRITE_AGAIN
from axisid.support.presentable import Presentable


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class SavedOutputFit(Checked, Presentable, Exact):
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
    parameters : NamedValues
        With unit, deviations and 95 % interval, by name.
    covariance : (P, P) array
        The one that was chosen; infinite where nothing shows a parameter.
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
    """

    file: str
    document: WrittenOutputFit
    name: str
    output: str
    outputs: tuple[str, ...]
    parameters: NamedValues
    covariance: Array
    error: float
    error_percent: MaybeInfinite
    records: tuple[WrittenRecord, ...]
    levels: Levels
    checks: tuple[Check, ...]

    @classmethod
    def of(cls, file: str, written: WrittenOutputFit) -> "SavedOutputFit":
        """What a document tells."""
        chosen = written.chosen_covariance
        return read_as(
            cls,
            written,
            file=file,
            document=written,
            name=written.axis,
            outputs=_outputs(written),
            parameters=NamedValues((n, _value(v, chosen)) for n, v in written.parameters.items()),
            covariance=frozen([[number(x, math.inf) for x in row] for row in written.covariance]),
            levels=written.levels or DEFAULT_LEVELS,
            checks=written.verdict,
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return SavedOutputFit.of, (self.file, self.document)

    def __repr__(self) -> str:
        return f"fit of the {self.output}: {self.parameters.listed()}"

    def __getitem__(self, name: str) -> Value:
        return self.parameters[name]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters."""
        return tuple(self.parameters)

    def derive(self, function: FunctionLike) -> Value:
        """Any function of the parameters, as `OutputFit.derive`, under the chosen covariance."""
        own, chosen = self.document.parameters, self.document.chosen_covariance
        freedom = np.array([degrees_of_freedom_of(value) for value in self.parameters.values()])
        return SamplingDistribution(
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


@dataclass(frozen=True, kw_only=True)
class SavedFitValidation(Checked, Presentable):
    """A frozen fit on a second record, read from a file, with the names of `FitValidation`.

    Attributes
    ----------
    file : str
    document : WrittenFitValidation
        What the file holds.
    record : WrittenRecord

    Notes
    -----
    What else there is, is as of a `FitValidation`.
    """

    file: str
    document: WrittenFitValidation = field(repr=False)
    record: WrittenRecord
    output: str
    unit: str
    horizon: float | None
    error: float
    percent: MaybeInfinite
    checks: tuple[Check, ...]

    @classmethod
    def of(cls, file: str, document: WrittenFitValidation) -> "SavedFitValidation":
        """As a file has it."""
        return read_as(
            cls,
            document,
            file=file,
            document=document,
            checks=document.verdict,
        )


def read_output_fit(file: str, document: WrittenOutputFit) -> SavedOutputFit:
    """A document as a result; refused where its members do not belong together.

    Raises
    ------
    DataError
        The covariance is not of the parameters, or nothing is left of a record.
    """
    count = len(document.parameters)
    rows = [len(row) for row in document.covariance]
    left, followed = len(document.record_errors), len(_outputs(document))
    if rows != [count] * count or left != followed * len(document.records):
        raise DataError(
            f"{file} has {count} parameters and a covariance of {len(rows)}, and what is left "
            f"of {len(document.record_errors)} of {len(document.records)} records. "
            f"{WRITE_AGAIN}",
            code="result-file",
        )
    return SavedOutputFit.of(file, document)


def _outputs(written: WrittenOutputFit) -> tuple[str, ...]:
    """What was followed; files of one output need not say it of each record."""
    return tuple(dict.fromkeys(each.output or written.output for each in written.record_errors))


def _value(written: WrittenFitted, chosen: str) -> Value:
    low, high = written.interval_95
    return Value(
        value=written.value,
        unit=written.unit,
        deviations={n: number(sd, math.inf) for n, sd in written.deviations.items()},
        interval=(number(low, -math.inf), number(high, math.inf)),
        chosen=chosen,
    )


@dataclass(frozen=True, kw_only=True, repr=False)
class SavedMonteCarlo(StudyFigures, Presentable):
    """A study that was read from a file, with the names of `MonteCarlo`; see `load_result`.

    The numbers of each run are in the file of ``--output`` alone.

    Attributes
    ----------
    file : str
    document : WrittenMonteCarlo
        What the file holds.
    """

    file: str
    document: WrittenMonteCarlo

    def __repr__(self) -> str:
        methods = ", ".join(self.document.methods)
        return f"Monte-Carlo study of {self.name}: {len(self)} twins by {methods}"

    def __len__(self) -> int:
        return self.document.done

    @property
    def name(self) -> str:
        """Of the axis."""
        return self.document.axis

    @property
    def chosen(self) -> str:
        """Of `COVARIANCES`, what printed intervals are of."""
        return str(self.document.settings["covariance"])

    @property
    def noise(self) -> Chain:
        """Of the twins."""
        twins = self.document.twins
        if not isinstance(twins.chain, UnsetType):
            return twins.chain
        experiment = Chain(position=twins.position_noise, position_step=twins.resolution)
        return declared_chain(experiment, **cast(Any, twins.noise))

    @property
    def figures(self) -> tuple[EstimandFigures, ...]:
        """What the runs tell of each estimand."""
        return self.document.estimands

    @property
    def check_figures(self) -> tuple[CheckFigures, ...]:
        """How often each check ends how."""
        return self.document.checks

    @property
    def judged(self) -> int:
        """How many runs there is a verdict of."""
        return self.document.judged

    @property
    def objected(self) -> Share:
        """How many of the verdicts any check fails in."""
        return self.document.objected

    @property
    def failures(self) -> tuple[FailedRun, ...]:
        """Runs that gave nothing, of a method or at all, with the reason."""
        return self.document.failures
