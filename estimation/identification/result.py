"""The result of an identification: estimates, their data, and results by record."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from operator import attrgetter
from typing import Any, Generic, Self, TypeAlias, TypeVar

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.diagnostics import Diagnosis, DiagnosticInputs, diagnose
from axisid.estimation.diagnostics.control_law import RecordLaws
from axisid.estimation.estimates import (
    Estimate,
    PhysicalByMethod,
    Value,
    physical_parameters,
)
from axisid.estimation.estimation_problem import ParameterAtBound, Problem
from axisid.estimation.records import Record, record_labels
from axisid.estimation.signals import FilteredRecord, Prefilter, Sampling
from axisid.estimation.verdict_checks import (
    DEFAULT_LEVELS,
    Check,
    Checked,
    Levels,
    unless_faulty,
)
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Exact, Uncached
from axisid.support.errors import Missing, UsageError, is_whole, quoted
from axisid.support.presentable import Presentable, view_of

#: A record, or what a file holds of one: what is told of it, without its samples.
RecordInfo: TypeAlias = Record | Any


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordResult:
    """One of several records in a result, by the reported estimate.

    Attributes
    ----------
    name : str
    record : RecordInfo
    sampling : Sampling
    known : mapping of str to (float, float)
        What is known of it, with its standard deviation, SI.
    rows : int
    weight : float
        Of its rows, whose mean square over all rows is 1.
    noise : float
        Root mean square of the residuals, in the unit of the left side.
    equation_error_percent : float
    simulation_error_percent : float or None
    share_percent : float or None
        Force that the parameters it has alone make otherwise than those of all; None where it alone
        does not tell them.
    p_value : float or None
        That chance alone makes as much.
    """

    name: str
    record: RecordInfo
    sampling: Sampling
    known: Mapping[str, tuple[float, float]]
    rows: int
    weight: float
    noise: float
    equation_error_percent: float
    simulation_error_percent: float | None
    share_percent: float | None
    p_value: float | None


def record_index(number: object, records: int) -> int:
    """Return the index of one of several records, by its number from 1.

    Raises
    ------
    UsageError
        There is no such record.
    """
    count = max(records, 1)
    if not is_whole(number) or not 1 <= number <= count:
        there = "there is 1" if count == 1 else f"there are {count}, numbered from 1"
        there = there[:1].upper() + there[1:]
        raise UsageError(f"the result has no record {quoted(number)}. {there}.", code="result")
    return int(number) - 1


Estimated = TypeVar("Estimated")


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveTime:
    """The estimated lag or delay of a drive.

    Attributes
    ----------
    name : str
        ``lag`` or ``delay``.
    parameter : Parameter
        As what it was declared.
    value, deviation : float
        s; the deviation is that of the delay between force and motion.
    interval : (float, float)
        95 %.
    """

    name: str
    parameter: Parameter
    value: float
    deviation: float
    interval: tuple[float, float]

    def __str__(self) -> str:
        return (
            f"{self.name} {self.parameter.name} = {1e3 * self.value:.4g} +- "
            f"{1e3 * self.deviation:.2g} ms"
        )


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class ByMethod(Checked, Generic[Estimated]):
    """Estimates by method: ``result["idm-iv"]``; it iterates over the methods.

    Its members are those of an `Identification`.
    """

    estimates: Mapping[str, Estimated]
    skipped: Mapping[str, str]
    failed: Mapping[str, str]
    requested: Prefilter | None = None
    set_aside: Mapping[str, str] = field(default_factory=dict)
    drive_time: DriveTime | None = None
    levels: Levels = DEFAULT_LEVELS

    @property
    def verdict(self: Any) -> tuple[Check, ...]:
        """The checks, each with a name, a status, a finding and a figure."""
        return tuple(self.checks)

    @property
    def local(self: Any) -> dict[str, tuple[Value | None, ...]]:
        """Values of each local parameter by record, of the reported estimate.

        None in a record that does not have the parameter.
        """
        values = self.preferred.parameters
        return {name: tuple(map(values.get, own)) for name, own in self.local_names.items()}

    def __getitem__(self, method: str) -> Estimated:
        name = str(method).lower()
        if name not in self.estimates:
            raise UsageError(
                f"the result has no {quoted(method)}. Choose from {', '.join(self.estimates)}.",
                code="result",
            )
        return self.estimates[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.estimates)

    def __contains__(self, method: object) -> bool:
        return isinstance(method, str) and method.lower() in self.estimates

    def __len__(self) -> int:
        return len(self.estimates)

    def summary(self, draws: int = 0, *, every: bool = False, full: bool = False) -> str:
        """Return the reported estimate as text, with the verdict.

        Parameters
        ----------
        draws : int
            How many to draw from each estimate's distribution, for a table of intervals that do
            without the delta method; 0 for none. Of a file as many as were drawn when it was
            written.
        every : bool
            Every method's estimate side by side, with numbered notes.
        full : bool
            That, and intervals, correlations and every diagnostic with its figures.
        """
        return str(view_of("as_text", self, draws=draws, every=every, full=full))


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class HasRecords:
    """A result from one record or several under their filters.

    Attributes
    ----------
    problem : Problem
        The records under their filters, with what was chosen for them and what they share.
    set_aside : mapping of str to str
        Records that could not be used, with the reason.
    """

    __slots__ = ()
    problem: Problem
    set_aside: Mapping[str, str] = field(default_factory=dict)

    def with_set_aside(self, unread: Mapping[str, str]) -> Self:
        """Return the result with records that could not be read."""
        return replace(self, set_aside={**unread, **self.set_aside}) if unread else self

    @property
    def data(self) -> FilteredRecord:
        """The filtered record; of several the first."""
        return self.problem.data[0]

    @property
    def record(self) -> Record:
        """The record of the result; of several the first."""
        return self.data.record

    @property
    def records(self) -> tuple[Record, ...]:
        """All records."""
        return tuple(data.record for data in self.problem.data)

    @property
    def prefilter(self) -> Prefilter:
        """The filter, with the choices made for the record."""
        return self.data.prefilter


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Identification(HasRecords, ByMethod[Estimate], Uncached, Presentable, Exact):
    """The estimates of one axis from one record, or from several together.

    Attributes
    ----------
    problem : Problem
        The records under their filters, with what was chosen for them and what they share.
    estimates : mapping of str to Estimate
        By method.
    skipped : mapping of str to str
        Methods that were not asked for by name and that axis or record do not allow, with the
        reason.
    failed : mapping of str to str
        Methods that were not asked for by name and came to nothing, with the reason.
    requested : Prefilter or None
        The prefilter before what it left open was chosen for the record.
    set_aside : mapping of str to str
        Records that could not be used and were to be skipped, by name, with the reason.
    drive_time : DriveTime or None
        The drive's lag or delay where it was estimated; the deviations of all parameters have what
        its own adds.
    levels : Levels
        From when on a check tells something of the model.
    further : tuple of Check
        What else the verdict lists: whether it holds on second records, see `Validation.check`.
    compared_laws : RecordLaws or None
        The control law compared with each record, if that was made with the estimates.
    """

    further: tuple[Check, ...] = ()
    compared_laws: RecordLaws | None = field(default=None, compare=False)

    @property
    def axis(self) -> GeneratedAxis:
        """The identified axis."""
        return self.problem.axis

    @property
    def record_names(self) -> tuple[str, ...]:
        """The name of each record."""
        return record_labels(self.records)

    @property
    def held(self) -> tuple[ParameterAtBound, ...]:
        """Declared parameters that were fixed at a bound, with ``bounded``."""
        return self.problem.held

    @cached_property
    def parts(self) -> "tuple[Identification, ...]":
        """The result of each record: its rows, and the parameters of its own axis.

        What a record leaves of the model can be looked at in its part as of a record by itself; the
        parameters are those of all records. One record is its own part.
        """
        parts = self.case.parts if self.case.has_parts else ()
        whole = (
            replace(self, problem=p.problem, estimates=p.estimates, compared_laws=None)
            for p in parts
        )
        return tuple(whole) or (self,)

    def part(self, number: int) -> "Identification":
        """Return the result of one of its records, by its number from 1; see `parts`.

        Raises
        ------
        UsageError
            There is no such record.
        """
        return self.parts[record_index(number, len(self.problem.data))]

    @cached_property
    def of_records(self) -> tuple[RecordResult, ...]:
        """Results by record of several; empty for one."""
        problem, diagnosis, found = self.problem, self.diagnosis, []
        known = {} if problem.joint_form is None else problem.joint_form.known
        every = zip(self.record_names, problem.data, diagnosis.records, self.parts, strict=False)
        for i, (name, data, measured, own) in enumerate(every):
            part = own.estimates[diagnosis.preferred]
            told = None if isinstance(measured.apart, Missing) else measured.apart
            found.append(
                RecordResult(
                    name=name,
                    record=data.record,
                    sampling=data.sampling,
                    known={name: values[i] for name, values in known.items()},
                    rows=len(part.y),
                    weight=problem.weights[i] if problem.weights else 1.0,
                    noise=float(np.linalg.norm(part.residuals)) / max(len(part.y), 1) ** 0.5,
                    equation_error_percent=part.equation_error_percent,
                    simulation_error_percent=part.simulation_error_percent,
                    share_percent=None if told is None else told.share_percent,
                    p_value=None if told is None else told.p_value,
                )
            )
        return tuple(found)

    @property
    def local_names(self) -> Mapping[str, tuple[str, ...]]:
        """Names of each local parameter by record."""
        return {} if self.problem.joint_form is None else self.problem.joint_form.local

    @property
    def declared_gain(self) -> float | None:
        """The declared drive gain where the gain is identified; None where it is relied on."""
        return None if self.problem.joint_form is None else self.problem.joint_form.gain

    def __repr__(self) -> str:
        return (
            f"identification of {self.axis.name} from {' and '.join(self.record_names)}: "
            f"{', '.join(self.estimates)}"
        )

    @cached_property
    def physical(self) -> PhysicalByMethod:
        """Declared parameters by method; empty where the estimates are of them already.

        From the base parameters and what is declared as known; see `axisid.fix`.
        """
        found = {
            name: physical_parameters(name, e.form, e.distribution)
            for name, e in self.estimates.items()
        }
        return PhysicalByMethod((n, each) for n, each in found.items() if each is not None)

    @property
    def preferred(self) -> Estimate:
        """The reported estimate.

        By output error where every record's control is the declared law's, but where instruments
        differ from it and are the more precise; else by instruments where there are, inverse model
        first.
        """
        return self.estimates[self.case.method]

    @cached_property
    def case(self) -> DiagnosticInputs:
        """The inputs of the checks."""
        return DiagnosticInputs(
            problem=self.problem,
            estimates=self.estimates,
            levels=self.levels,
            compared_laws=self.compared_laws,
        )

    @cached_property
    def diagnosis(self) -> Diagnosis:
        """The measurements of the checks, computed once."""
        found = diagnose(self.case)
        return replace(found, verdict=(*found.verdict, *self.further))

    def judged(self) -> "Identification":
        """Return this result once bias, intervals and verdict are computed.

        An estimate whose intervals cannot be computed keeps its values. The error is raised when
        they are read.
        """
        for estimate in self.estimates.values():
            unless_faulty(partial(attrgetter("inference"), estimate))
        _ = self.diagnosis
        return self

    @property
    def checks(self) -> tuple[Check, ...]:
        """The same as `verdict`."""
        return self.diagnosis.verdict

    def to_dict(self, draws: int = 0) -> dict[str, Any]:
        """Return the content of ``--json``: plain numbers and texts; `draws` as in `summary`."""
        return dict(view_of("as_document", self, draws=draws))
