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
from axisid.support.checks import is_whole
from axisid.support.errors import UsageError
from axisid.support.missing import Missing
from axisid.support.presentable import Presentable, view_of
from axisid.support.wording import quoted

#: A record, or its description in a file, without its samples.
RecordInfo: TypeAlias = Record | Any


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordResult:
    """Results of one of several records, by the reported estimate.

    Attributes
    ----------
    name : str
    record : RecordInfo
    sampling : Sampling
    known : mapping of str to (float, float)
        Known values of the record, with their standard deviations, SI.
    rows : int
    weight : float
        Weight of the record's rows; the mean square of the weights of all rows is 1.
    noise : float
        Root mean square of the residuals, in the unit of the left side.
    equation_error_percent : float
    simulation_error_percent : float or None
    share_percent : float or None
        Effect of the difference between the parameters of this record alone and those of the
        others, percent of the force; None where this record alone does not identify them.
    p_value : float or None
        Probability that such a difference occurs by chance; None where `share_percent` is None.
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
    """Return the index from 0 of a record, by its number from 1.

    Parameters
    ----------
    number : object
        Number of the record, as given by the user.
    records : int
        Number of records of the result.

    Raises
    ------
    UsageError
        There is no such record.
    """
    count = max(records, 1)
    if not is_whole(number) or not 1 <= number <= count:
        choice = "There is 1" if count == 1 else f"There are {count}, numbered from 1"
        raise UsageError(f"the result has no record {quoted(number)}. {choice}.", code="result")
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
        Declaration of the lag or delay.
    value, deviation : float
        Value and standard error, s. The standard error is that of the delay between force and
        motion.
    interval : (float, float)
        95 % confidence interval, s.
    """

    name: str
    parameter: Parameter
    value: float
    deviation: float
    interval: tuple[float, float]

    def __str__(self) -> str:
        """Return the name and the value of the lag or delay with its standard error, ms."""
        return (
            f"{self.name} {self.parameter.name} = {1e3 * self.value:.4g} +- "
            f"{1e3 * self.deviation:.2g} ms"
        )


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class ByMethod(Checked, Generic[Estimated]):
    """Estimates by method: ``result["idm-iv"]``. Iterating over it gives the names of the methods.

    The fields are described in `Identification`.
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
        """Checks, each with a name, a status, a finding and a figure."""
        return tuple(self.checks)

    @property
    def local(self: Any) -> dict[str, tuple[Value | None, ...]]:
        """Values of each local parameter in the reported estimate, one for each record, by name.

        None in place of a value for a record that does not have the parameter.
        """
        values = self.preferred.parameters
        return {
            name: tuple(map(values.get, names_in_records))
            for name, names_in_records in self.local_names.items()
        }

    def __getitem__(self, method: str) -> Estimated:
        """Return the estimate by a method; UsageError where there is none by that method."""
        name = str(method).lower()
        if name not in self.estimates:
            raise UsageError(
                f"the result has no estimate by {quoted(method)}. Choose from "
                f"{', '.join(self.estimates)}.",
                code="result",
            )
        return self.estimates[name]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the methods."""
        return iter(self.estimates)

    def __contains__(self, method: object) -> bool:
        """Return True for the name of a method that gave an estimate."""
        return isinstance(method, str) and method.lower() in self.estimates

    def __len__(self) -> int:
        """Return the number of estimates."""
        return len(self.estimates)

    def summary(self, draws: int = 0, *, every: bool = False, full: bool = False) -> str:
        """Return the reported estimate as text, with the verdict.

        Parameters
        ----------
        draws : int
            Number of draws from the distribution of each estimate, for a table of intervals without
            the delta method; 0 for none. A result from a file has the draws made when it was
            written.
        every : bool
            Add the estimates of all methods in one table, with numbered notes.
        full : bool
            Add the estimates of all methods, intervals, correlations and every diagnostic with its
            figures.
        """
        return str(view_of("as_text", self, draws=draws, every=every, full=full))


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class HasRecords:
    """A result from one or several filtered records.

    Attributes
    ----------
    problem : Problem
        The filtered records, with the choices made for them and the parameters that they share.
    set_aside : mapping of str to str
        Records that could not be used, with the reason.
    """

    __slots__ = ()
    problem: Problem
    set_aside: Mapping[str, str] = field(default_factory=dict)

    def with_set_aside(self, unread: Mapping[str, str]) -> Self:
        """Return the result with further records in `set_aside`.

        `unread` has the names of records that could not be read, with the reasons.
        """
        return replace(self, set_aside={**unread, **self.set_aside}) if unread else self

    @property
    def data(self) -> FilteredRecord:
        """Filtered record; the first of several."""
        return self.problem.data[0]

    @property
    def record(self) -> Record:
        """Record of the result; the first of several."""
        return self.data.record

    @property
    def records(self) -> tuple[Record, ...]:
        """All records of the result, in the order in which they were given."""
        return tuple(data.record for data in self.problem.data)

    @property
    def prefilter(self) -> Prefilter:
        """Prefilter with the choices made for the record; that of the first of several records."""
        return self.data.prefilter


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Identification(HasRecords, ByMethod[Estimate], Uncached, Presentable, Exact):
    """Estimates of one axis from one record, or from several together.

    Attributes
    ----------
    problem : Problem
        The filtered records, with the choices made for them and the parameters that they share.
    estimates : mapping of str to Estimate
        Estimates by method.
    skipped : mapping of str to str
        Methods that were not requested by name and that axis or record do not allow, with the
        reason.
    failed : mapping of str to str
        Methods that were not requested by name and failed, with the reason.
    requested : Prefilter or None
        Prefilter as requested, before missing settings were chosen for the record.
    set_aside : mapping of str to str
        Records that could not be used and were to be skipped, by name, with the reason.
    drive_time : DriveTime or None
        Lag or delay of the drive where it was estimated; the standard errors of all parameters
        include its uncertainty.
    levels : Levels
        Thresholds above which a check reports a model error.
    further : tuple of Check
        Further checks of the verdict: validations on second records, see `Validation.check`.
    compared_laws : RecordLaws or None
        Comparison of the control law with each record, if made with the estimates.
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
        """Result for each record: its rows with the estimates from all records.

        The residuals of a record can be examined in its part as for a single record. The parameters
        are expressed in those of the record's axis, but are not estimated again from the record. A
        result of a single record has itself as its only part.
        """
        if not (self.case.has_parts and self.case.parts):
            return (self,)
        return tuple(
            replace(self, problem=part.problem, estimates=part.estimates, compared_laws=None)
            for part in self.case.parts
        )

    def part(self, number: int) -> "Identification":
        """Return the member of `parts` for one record, by the number of the record from 1.

        Raises
        ------
        UsageError
            There is no such record.
        """
        return self.parts[record_index(number, len(self.problem.data))]

    @cached_property
    def of_records(self) -> tuple[RecordResult, ...]:
        """Results of each record with the reported estimate; empty for a single record."""
        problem, diagnosis, found = self.problem, self.diagnosis, []
        known = {} if problem.joint_form is None else problem.joint_form.known
        # `diagnosis.records` is empty for a single record.
        every = zip(self.record_names, problem.data, diagnosis.records, self.parts, strict=False)
        for i, (name, data, measured, result_of_record) in enumerate(every):
            part = result_of_record.estimates[diagnosis.preferred]
            # Difference between the parameters of this record and those of the other records.
            difference = None if isinstance(measured.apart, Missing) else measured.apart
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
                    share_percent=None if difference is None else difference.share_percent,
                    p_value=None if difference is None else difference.p_value,
                )
            )
        return tuple(found)

    @property
    def local_names(self) -> Mapping[str, tuple[str, ...]]:
        """Names by which the estimates list each local parameter, one for each record.

        The keys are the declared names. Empty where records share all parameters.
        """
        return {} if self.problem.joint_form is None else self.problem.joint_form.local

    @property
    def declared_gain(self) -> float | None:
        """Declared drive gain where the gain is identified; None where the declared gain is used.

        The unit is that of the drive's declaration, force per unit of the control.
        """
        return None if self.problem.joint_form is None else self.problem.joint_form.gain

    def __repr__(self) -> str:
        """Return the names of axis, records and methods."""
        return (
            f"identification of {self.axis.name} from {' and '.join(self.record_names)}: "
            f"{', '.join(self.estimates)}"
        )

    @cached_property
    def physical(self) -> PhysicalByMethod:
        """Physical parameters from base parameters and known values, by method; see `axisid.fix`.

        Empty where the parameters of the estimates are the declared parameters already.
        """
        found = PhysicalByMethod()
        for method, estimate in self.estimates.items():
            physical = physical_parameters(method, estimate.form, estimate.distribution)
            if physical is not None:
                found[method] = physical
        return found

    @property
    def preferred(self) -> Estimate:
        """The reported estimate.

        It is the estimate by output error (DIDIM) if the control of every record follows the
        declared law, except if the estimate by instruments differs significantly and is more
        precise. Otherwise it is the estimate by instruments where there are any, with the inverse
        model before the direct one.
        """
        return self.estimates[self.case.method]

    @cached_property
    def case(self) -> DiagnosticInputs:
        """The result as input of the checks, with quantities that several checks use."""
        return DiagnosticInputs(
            problem=self.problem,
            estimates=self.estimates,
            levels=self.levels,
            compared_laws=self.compared_laws,
        )

    @cached_property
    def diagnosis(self) -> Diagnosis:
        """Measurements and checks of all diagnostics, with the `further` checks; computed once."""
        found = diagnose(self.case)
        return replace(found, verdict=(*found.verdict, *self.further))

    def judged(self) -> "Identification":
        """Return this result once bias, intervals and verdict are computed.

        An estimate whose intervals cannot be computed keeps its values, and so does a result whose
        verdict cannot be computed. The error is raised when they are read.
        """
        for estimate in self.estimates.values():
            unless_faulty(partial(attrgetter("inference"), estimate))
        unless_faulty(partial(attrgetter("diagnosis"), self))
        return self

    @property
    def checks(self) -> tuple[Check, ...]:
        """Checks, the same as `verdict`."""
        return self.diagnosis.verdict

    def to_dict(self, draws: int = 0) -> dict[str, Any]:
        """Return the content of ``--json``: plain numbers and texts; `draws` as in `summary`."""
        return dict(view_of("as_document", self, draws=draws))
