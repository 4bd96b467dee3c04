"""Choice between models: candidates fitted to the same rows, and a recommendation.

The recommended candidate has the fewest parameters of those whose held-out error is within one
standard error, or one percent, of the smallest.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, as_generated
from axisid.estimation.choices import INSTRUMENT_STARTS, comparison_methods, is_output_error
from axisid.estimation.diagnostics.control_law import LawAgreement, first_failing
from axisid.estimation.estimates import Estimate
from axisid.estimation.estimation_problem import Problem
from axisid.estimation.identification import (
    HasRecords,
    Identification,
    JointRecords,
    identify_problem,
    joint_records,
    records_of,
)
from axisid.estimation.records import Record
from axisid.estimation.signals import Prefilter
from axisid.estimation.thresholds import NO_RELATION
from axisid.estimation.unknowns import KnownValue, KnownValues, declared_names
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Check, Checked, Levels
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Exact, MaybeNan
from axisid.support.checks import check_among, is_among, listed, refuse
from axisid.support.errors import EstimationError, ModelError, UsageError
from axisid.support.missing import Missing
from axisid.support.one_thread import in_one_thread
from axisid.support.presentable import Presentable
from axisid.support.progress import Progress, with_progress
from axisid.support.wording import quoted

from .held_out import (
    HeldOut,
    HeldOutBlock,
    Regression,
    contiguous_blocks,
    held_out_equation,
    regression_rows,
)
from .nested_models import NestedTest, nested_tests

# ratio to the smallest held-out error up to which errors are equal, even if the excess of the
# larger error is significant
_EQUAL_ERROR = 1.01
_MAX_TIED_ERROR = 1.1  # the same ratio for an excess within its standard error


@dataclass(frozen=True, slots=True, kw_only=True)
class Criteria:
    """Information criteria of the least-squares fit; only differences are meaningful.

    Rows of filtered data are not independent, so that both favour too many parameters.

    Attributes
    ----------
    log_likelihood : float
        Gaussian log-likelihood at the variance that maximises it.
    aic, bic : float
        ``-2 logL + 2 k`` and ``-2 logL + k log n``, for independent rows.
    """

    log_likelihood: MaybeNan
    aic: MaybeNan
    bic: MaybeNan


def criteria(rows: Regression) -> Criteria:
    """Return the information criteria of a regression by least squares."""
    solution = rows.solved(by_instruments=False)
    e, (n, k) = solution.residuals, solution.influence.shape
    likelihood = -n / 2 * (math.log(2 * math.pi) + float(np.log(e @ e / n)) + 1)
    return Criteria(
        log_likelihood=likelihood,
        aic=2 * k - 2 * likelihood,
        bic=k * math.log(n) - 2 * likelihood,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Candidate(Exact):
    """One model of a comparison.

    Attributes
    ----------
    name : str
    axis : GeneratedAxis
    estimate : Estimate
        Estimate from all rows.
    criteria : Criteria
        Information criteria of the least-squares fit.
    equation : HeldOut
        Held-out error of the equation.
    """

    name: str
    axis: GeneratedAxis
    estimate: Estimate
    criteria: Criteria
    equation: HeldOut

    @property
    def size(self) -> int:
        """Number of parameters."""
        return len(self.estimate.physical)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Comparison(HasRecords, Checked, Presentable, Exact):
    """Candidates on the same rows of one or several records, with a recommendation.

    Attributes
    ----------
    problem : Problem
        The records, with the filter that suits all candidates.
    method : str
        One of the methods of `compare`.
    candidates : tuple of Candidate
        In the given order.
    failures : mapping of str to str
        Reason by name of each candidate that the records do not identify.
    tests : tuple of NestedTest
        Tests of each model against the next larger models that contain it.
    same : tuple of (str, str)
        Candidates that are one model in different parameters.
    blocks, gap : int
        Number of held-out blocks, and number of rows on both sides of each block that are not used
        for the estimate.
    recommended : str or None
        Name of the recommended candidate; None if no candidate predicts the held-out force.
    tied : tuple of str
        Names of the candidates whose held-out error equals the smallest within its uncertainty,
        including the recommended candidate.
    reason : str
        Reason of the recommendation, or of a missing recommendation, as text.
    law : LawAgreement or Missing
        Comparison of the first candidate's control law with the record.
    set_aside : mapping of str to str
        Records that could not be used, with the reason.
    result : Identification or None
        Identification of the recommended candidate; None without a recommendation.
    """

    method: str
    candidates: tuple[Candidate, ...]
    failures: Mapping[str, str]
    tests: tuple[NestedTest, ...]
    same: tuple[tuple[str, str], ...]
    blocks: int
    gap: int
    recommended: str | None
    tied: tuple[str, ...]
    reason: str
    law: LawAgreement | Missing
    result: Identification | None = None

    @property
    def checks(self) -> tuple[Check, ...]:
        """Checks of the recommended candidate; without one, a failed check with the reason."""
        if self.result is None:
            return (Check.unless("recommendation", self.reason),)
        return self.result.checks

    @property
    def known(self) -> KnownValues:
        """Known values of each record by name; empty if there are none."""
        if self.problem.joint_form is None:
            return {}
        return self.problem.joint_form.known

    def __getitem__(self, name: str) -> Candidate:
        found = {candidate.name: candidate for candidate in self.candidates}
        check_among(("candidate", name, found))
        return found[name]


@in_one_thread
def compare(
    axes: Mapping[str, Axis | GeneratedAxis] | Sequence[Axis | GeneratedAxis],
    record: Record | Sequence[Record],
    prefilter: Prefilter | None = None,
    method: str = "idm-ls",
    *,
    progress: Progress | None = None,
    local: str | Sequence[str] = (),
    known: Mapping[str, Sequence[KnownValue]] | None = None,
    gain: str = "identified",
    skip_bad: bool = False,
    start: str = INSTRUMENT_STARTS[0],
    level: float = DEFAULT_LEVELS.level,
    least_share: float = DEFAULT_LEVELS.least_share,
) -> Comparison:
    """Fit several models of one axis to the same rows and recommend one.

    Parameters
    ----------
    axes : mapping of str to Axis, or sequence of Axis
        Two or more, of one coordinate and one drive; see `friction_ladder` for a set of models.
    record : Record or sequence of Record
        Several records form one regression, as in `identify`.
    prefilter : Prefilter, optional
        The same for all candidates.
    method : str
        ``idm-ls``, ``idm-iv`` or another method for comparisons in `axisid.estimation.choices`: the
        estimator of the tables, of the held-out errors and of the Wald tests.
    progress : callable, optional
        Called before each step with the number of finished steps, their total, and a text.
    local, known, gain, skip_bad
        As in `identify` of several records, for every candidate.
    start : str
        Start of the instruments, as in `identify`.
    level, least_share : float
        As in `identify`, for the checks of the recommended candidate.

    Raises
    ------
    UsageError
        The axes cannot be compared, or the method is not for comparisons.
    DataError
        The record is too short to hold rows out.
    EstimationError
        The record identifies none of the candidates.
    """
    names = comparison_methods()
    if not is_among(method, names):
        reason = ""
        if is_output_error(str(method)):
            reason = " Its closed loop is simulated over all rows, so that no rows can be held out."
        raise UsageError(
            f"the method {quoted(method)} cannot compare candidates.{reason} "
            f"Choose {' or '.join(names)}.",
            code="comparison",
        )
    levels, records = Levels(level=level, least_share=least_share), records_of(record)
    named = _named(axes)
    common = _CommonRows.of(named, records, prefilter, local, known, gain, skip_bad=skip_bad)
    fits: dict[str, Identification] = {}
    candidates: list[Candidate] = []
    failures: dict[str, str] = {}
    for name, axis in with_progress(named.items(), progress, lambda item: f"estimate of {item[0]}"):
        lead = ""  # beginning of the reason if the candidate fails
        try:
            found = common.identified(axis, method, start, levels)
            estimate, lead = found[method], "with a tenth of the rows held out, "
            blocks = contiguous_blocks(len(estimate.y), common.gap, len(estimate.physical))
            candidates.append(_candidate(name, axis, estimate, blocks))
            fits[name] = found
        except (EstimationError, ModelError) as error:
            failures[name] = f"{lead}{error!s}"
    if not candidates:
        raise EstimationError(
            f"none of the candidates is identified: {'; '.join(dict.fromkeys(failures.values()))}",
            code="comparison",
        )
    tests, same = nested_tests({c.name: regression_rows(c.estimate) for c in candidates})
    recommended, tied, reason = _recommend(candidates, len(blocks))
    return Comparison(
        problem=common.problem,
        method=method,
        candidates=tuple(candidates),
        failures=failures,
        tests=tests,
        same=same,
        blocks=len(blocks),
        gap=common.gap,
        recommended=recommended,
        tied=tied,
        reason=reason,
        law=first_failing(next(iter(fits.values())).case.laws),
        set_aside=common.shared.set_aside,
        result=None if recommended is None else fits[recommended],
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _CommonRows:
    """Records and rows that all candidates have in common.

    Attributes
    ----------
    shared : JointRecords
        Records with their known values and local parameters.
    problem : Problem
        The records with the filter that suits the candidate with the most friction.
    gap : int
        Memory of the filters, rows.
    """

    shared: JointRecords
    problem: Problem
    gap: int

    @classmethod
    def of(
        cls,
        named: Mapping[str, GeneratedAxis],
        records: Sequence[Record],
        prefilter: Prefilter | None,
        local: str | Sequence[str],
        known: Mapping[str, Sequence[KnownValue]] | None,
        gain: str,
        *,
        skip_bad: bool,
    ) -> "_CommonRows":
        """Return the records and rows that all candidates have in common.

        The arguments are those of `compare`; `named` are the candidates by name.
        """
        # The filter suits the candidate with the most friction.
        first = min(named.values(), key=lambda axis: (axis.is_linear, not axis.has_direction))
        suited = Prefilter.given(prefilter).at_rate_of(records[0].period)
        # Records are joined by a candidate that declares the local parameters.
        owner = first
        local_names = {*listed(local)} - {""}
        if local_names:
            owner = _axis_with(local_names, named, first)
        shared = joint_records(owner, records, suited, local, known, gain, skip_bad=skip_bad)
        problem = shared.problem(first, suited)
        gap = max(data.sampling.filter.memory for data in problem.data)
        return cls(shared=shared, problem=problem, gap=gap)

    def identified(
        self, axis: GeneratedAxis, method: str, start: str, levels: Levels
    ) -> Identification:
        """Return the identification of one candidate from the common rows."""
        joint = self.shared.joint_form(axis)
        pairs = zip(self.problem.data, self.shared.axes(axis, joint), strict=True)
        data = tuple(replace(each, axis=of_record) for each, of_record in pairs)
        own = replace(self.problem, axis=axis, data=data, joint_form=joint)
        return identify_problem(own, own.data[0].prefilter, [method], start=start, levels=levels)


def _axis_with(
    names: set[str], named: Mapping[str, GeneratedAxis], otherwise: GeneratedAxis
) -> GeneratedAxis:
    """Return the first candidate that declares all names of parameters.

    The axis `otherwise` if there is none.
    """
    for axis in named.values():
        if {*declared_names(axis, names)} <= {p.name for p in axis.declared.parameters}:
            return axis
    return otherwise


@np.errstate(all="ignore")
def _candidate(
    name: str, axis: GeneratedAxis, estimate: Estimate, blocks: Sequence[HeldOutBlock]
) -> Candidate:
    """Return a candidate with its information criteria and held-out error.

    Raises
    ------
    EstimationError
        Without some block the parameters cannot be separated.
    """
    rows = regression_rows(estimate)
    signal = float(np.linalg.norm(estimate.weights * estimate.y))
    return Candidate(
        name=name,
        axis=axis,
        estimate=estimate,
        criteria=criteria(rows),
        equation=held_out_equation(rows, blocks, signal),
    )


def _named(
    axes: Mapping[str, Axis | GeneratedAxis] | Sequence[Axis | GeneratedAxis],
) -> dict[str, GeneratedAxis]:
    """Return two or more axes by name, by default the names of the axes themselves.

    Equal axes and equal names are refused, and so are axes that do not explain the same force and
    motion: they must have the same coordinate and the same drive.
    """
    if not isinstance(axes, Iterable):
        axes = (axes,)
    given: list[tuple[str | None, Axis | GeneratedAxis]] = []
    if isinstance(axes, Mapping):
        given.extend(axes.items())
    else:
        given.extend((None, axis) for axis in axes)
    if len(given) < 2:
        raise UsageError(
            f"{len(given)} candidate{'' if len(given) == 1 else 's'} cannot be compared. "
            "Give two or more axes, or the friction ladder of one axis (ladder).",
            code="comparison",
        )
    named: dict[str, GeneratedAxis] = {}
    for name, axis in given:
        generated = as_generated(axis)
        label = generated.axis.name if name is None else name
        equal = next((n for n, a in named.items() if a.signature == generated.signature), None)
        refuse(
            UsageError,
            (equal is not None, f"{label!r} is the same axis as {equal!r}. Give each axis once"),
            (
                label in named,
                f"two candidates are named {label!r}. Give each axis a different name",
            ),
            code="comparison",
        )
        named[label] = generated
    (first, reference), *others = ((name, axis.axis) for name, axis in named.items())
    for name, axis in others:
        q, p = axis.coordinate, reference.coordinate
        differences = []
        for each in fields(axis.drive):
            own = getattr(axis.drive, each.name, None)
            wanted = getattr(reference.drive, each.name, None)
            if own != wanted:
                differences.append(f"{each.name} {own} and {wanted}")
        refuse(
            UsageError,
            (
                q != p,
                f"{name!r} has the coordinate {q.name} in {q.unit}, but {first!r} has {p.name} in "
                f"{p.unit}. Candidates must explain the same motion. Declare both axes with the "
                "same coordinate",
            ),
            (
                axis.drive != reference.drive,
                f"{name!r} and {first!r} have different drives "
                f"({', '.join(differences) or 'of different types'}), so that they would explain "
                "different forces. Declare both axes with the same drive",
            ),
            code="comparison",
        )
    return named


def _recommend(
    candidates: Sequence[Candidate], blocks: int
) -> tuple[str | None, tuple[str, ...], str]:
    """Return the names of the recommended candidate and of those of equal error, and the reason.

    The recommended candidate has the fewest parameters of those whose held-out error equals the
    smallest; it is None if no candidate predicts the held-out force. `blocks` is the number of
    held-out blocks.
    """
    best = min(candidates, key=lambda c: (c.equation.error_percent, c.size))
    tied = [c for c in candidates if c is best or _is_as_good(c, best)]
    chosen = min(tied, key=lambda c: (c.size, c.equation.error_percent))
    names, error = tuple(c.name for c in tied), chosen.equation.error_percent
    if not best.equation.error_percent < NO_RELATION.value:
        return (
            None,
            names,
            f"the smallest held-out error, {best.equation.error_percent:.4g} % of the force with "
            f"{best.name}, is as large as the force itself: estimates from one part of the record "
            "do not predict the other parts. Record several speeds in both directions, more than "
            "once",
        )
    if len(candidates) == 1:
        reason = "this is the only candidate that the record identifies"
    elif len(tied) > 1:
        why = "the fewest parameters"
        if sum(c.size == chosen.size for c in tied) > 1:
            why = "the smallest error among those with the fewest parameters"
        reason = (
            f"its held-out error is {error:.4g} % of the force. This record cannot tell "
            f"{', '.join(names[:-1])} and {names[-1]} apart: their errors are equal within one "
            f"standard error over {blocks} blocks, or within one percent of the error. Of these "
            f"candidates, {chosen.name} has {why}"
        )
    else:
        others = [c for c in candidates if c is not chosen]
        second = min(others, key=lambda c: c.equation.error_percent)
        excess, deviation = second.equation.excess(chosen.equation)
        larger = f"larger by the same amount in each of {blocks} blocks"
        if deviation:
            larger = f"{excess / deviation:.1f} standard errors larger over {blocks} blocks"
        reason = (
            f"its held-out error, {error:.4g} % of the force, is the smallest. The second smallest "
            f"is {second.equation.error_percent:.4g} % with {second.name} ({larger})"
        )
        if chosen.size > max(c.size for c in others):
            reason += (
                ". This is the richest candidate, so that a model with more terms may have a "
                "smaller error still"
            )
    return chosen.name, names, reason


def _is_as_good(candidate: Candidate, best: Candidate) -> bool:
    """Return True if a candidate's held-out error equals the best one's within its uncertainty.

    Errors are equal up to a ratio of 1.1 if the excess of squared errors is within its standard
    error, and up to a ratio of 1.01 otherwise. An excess in a single block is as large as its
    standard error.
    """
    excess, deviation = candidate.equation.excess(best.equation)
    largest_ratio = _EQUAL_ERROR
    if excess <= deviation:
        largest_ratio = _MAX_TIED_ERROR
    return candidate.equation.error_percent <= largest_ratio * best.equation.error_percent
