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
from axisid.support.checks import check_among, is_among, refuse
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

# ratio to the smallest held-out error that does not justify a parameter, even if it is significant
_EQUAL_ERROR = 1.01
_MAX_TIED_ERROR = 1.1  # ratio to the smallest for an excess within its standard error


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
        Candidates that this record does not identify, with the reason.
    tests : tuple of NestedTest
        Tests of each model against the next larger models that contain it.
    same : tuple of (str, str)
        Candidates that are one model in different parameters.
    blocks, gap : int
        Number of held-out blocks, and of the rows left out on both sides of each.
    recommended : str or None
        None if no candidate predicts the held-out force.
    tied : tuple of str
        Candidates with a held-out error equal to the smallest, including that one and the
        recommended one.
    reason : str
        Reason of the recommendation, or of a missing one, in one sentence.
    law : LawAgreement or Missing
        Comparison of the first candidate's control law with the record.
    set_aside : mapping of str to str
        Records that could not be used, with the reason.
    result : Identification or None
        Identification of the recommended candidate.
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
        """Checks of the recommended candidate, or one check with the reason why it is missing."""
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
    if not is_among(method, names := comparison_methods()):
        why = ", whose loop is simulated with all rows, so that none is held out of it"
        raise UsageError(
            f"there is no comparison by {quoted(method)}{why * is_output_error(str(method))}; "
            f"choose {' or '.join(names)}.",
            code="comparison",
        )
    levels, records = Levels(level=level, least_share=least_share), records_of(record)
    named = _named(axes)
    common = _CommonRows.of(named, records, prefilter, local, known, gain, skip_bad=skip_bad)
    fits: dict[str, Identification] = {}
    candidates: list[Candidate] = []
    failures: dict[str, str] = {}
    for name, axis in with_progress(named.items(), progress, lambda item: f"estimate of {item[0]}"):
        lead = ""
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
        owner = first
        asked = [local] if isinstance(local, str) else local
        if local_names := {*asked} - {""}:
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
    """Return the axes by name; refuse axes that do not explain the same force and motion."""
    if not isinstance(axes, Iterable):
        axes = (axes,)
    listed = list(axes.items()) if isinstance(axes, Mapping) else [(None, axis) for axis in axes]
    if len(listed) < 2:
        raise UsageError(
            f"{len(listed)} candidate{'' if len(listed) == 1 else 's'} cannot be compared; "
            "give two axes or more, or a friction ladder (ladder) of one.",
            code="comparison",
        )
    named: dict[str, GeneratedAxis] = {}
    for name, axis in listed:
        generated = as_generated(axis)
        label = generated.axis.name if name is None else name
        twin = next((n for n, a in named.items() if a.signature == generated.signature), None)
        refuse(
            UsageError,
            (twin is not None, f"{label!r} is the same axis as {twin!r}; give each one once"),
            (
                label in named,
                f"two candidates are named {label!r}; give each axis a name of its own",
            ),
            code="comparison",
        )
        named[label] = generated
    (first, reference), *others = ((name, axis.axis) for name, axis in named.items())
    for name, axis in others:
        q, p = axis.coordinate, reference.coordinate
        pairs = (
            (each.name, *(getattr(of.drive, each.name, None) for of in (axis, reference)))
            for each in fields(axis.drive)
        )
        told = ", ".join(f"{of} {one} against {other}" for of, one, other in pairs if one != other)
        refuse(
            UsageError,
            (
                q != p,
                f"{name!r} has the coordinate {q.name} in {q.unit}, {first!r} {p.name} in "
                f"{p.unit}; candidates explain one motion, so declare them with the same one",
            ),
            (
                axis.drive != reference.drive,
                f"{name!r} and {first!r} have different drives ({told or 'of other kinds'}), so "
                "they would explain different forces; declare them with the same one",
            ),
            code="comparison",
        )
    return named


def _recommend(
    candidates: Sequence[Candidate], blocks: int
) -> tuple[str | None, tuple[str, ...], str]:
    """Return the recommended candidate, the candidates of equal error, and the reason.

    Candidates are given by their names. The first is None if no candidate predicts the held-out
    force. `blocks` is the number of held-out blocks.
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
            "do not predict the others. Record several speeds in both directions, more than once",
        )
    if len(candidates) == 1:
        reason = "the only candidate that this record identifies"
    elif len(tied) > 1:
        is_alone = sum(c.size == chosen.size for c in tied) == 1
        why = f"{'' if is_alone else 'the smallest error at '}the fewest parameters"
        reason = (
            f"held-out error {error:.4g} %: this record cannot tell "
            f"{', '.join(names[:-1])} and {names[-1]} apart (within one standard error over "
            f"{blocks} blocks, or one percent of the error), and {chosen.name} has {why} of them"
        )
    else:
        others = [c for c in candidates if c is not chosen]
        second = min(others, key=lambda c: c.equation.error_percent)
        excess, deviation = second.equation.excess(chosen.equation)
        ahead = f"{excess / deviation:.1f} standard errors" if deviation else "in every block"
        reason = (
            f"its held-out error {error:.4g} % is the smallest, against "
            f"{second.equation.error_percent:.4g} % of {second.name} ({ahead} over {blocks} blocks)"
        )
        if chosen.size > max(c.size for c in others):
            reason += "; it is the richest candidate, so a richer law may do better still"
    return chosen.name, names, reason


def _is_as_good(candidate: Candidate, best: Candidate) -> bool:
    """Return True if a candidate's held-out error equals the best one's within its uncertainty.

    The ratio is at most 1.1 for an excess within its standard error, which for an excess in a
    single block is as large as the excess, and 1.01 otherwise.
    """
    excess, deviation = candidate.equation.excess(best.equation)
    times = _MAX_TIED_ERROR if excess <= deviation else _EQUAL_ERROR
    return candidate.equation.error_percent <= times * best.equation.error_percent
