"""Choosing between models: candidates fitted to the same rows, and which to take.

Held-out error comes first and parsimony second: of the candidates within one standard error, or one
percent, of the smallest held-out error, the one with the fewest parameters.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, as_generated
from axisid.estimation.choices import INSTRUMENT_STARTS, comparison_methods, is_output_error
from axisid.estimation.diagnostics.control_law import LawAgreement, first_failing
from axisid.estimation.estimates import Estimate
from axisid.estimation.identification import (
    HasRecords,
    Identification,
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
from axisid.support.errors import (
    EstimationError,
    Missing,
    ModelError,
    UsageError,
    check_among,
    is_among,
    quoted,
    refuse,
)
from axisid.support.one_thread import in_one_thread
from axisid.support.presentable import Presentable
from axisid.support.progress import Progress, with_progress

from .held_out import (
    HeldOut,
    Regression,
    contiguous_blocks,
    held_out_equation,
    regression_rows,
)
from .nested_models import NestedTest, nested_tests

# of the least held-out error, however precise both are: it is not worth a parameter
_EQUAL_ERROR = 1.01
_MAX_TIED_ERROR = 1.1  # of the least, where the excess is within its standard error


@dataclass(frozen=True, slots=True, kw_only=True)
class Criteria:
    """Information criteria of the least-squares fit; only differences mean anything.

    Rows of filtered data are not independent, so that both overrate every further parameter.

    Attributes
    ----------
    log_likelihood : float
        Gaussian, at the variance that maximises it.
    aic, bic : float
        ``-2 logL + 2 k`` and ``-2 logL + k log n``: for independent rows.
    """

    log_likelihood: MaybeNan
    aic: MaybeNan
    bic: MaybeNan


def criteria(rows: Regression) -> Criteria:
    """Information criteria of a regression by least squares."""
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
    """One model of the comparison.

    Attributes
    ----------
    name : str
    axis : GeneratedAxis
    estimate : Estimate
        From all rows.
    criteria : Criteria
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
        """How many parameters."""
        return len(self.estimate.physical)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Comparison(HasRecords, Checked, Presentable, Exact):
    """Candidates on the same rows of one record or several, with a recommendation.

    Attributes
    ----------
    problem : Problem
        The records, under the filter that suits all candidates.
    method : str
        Of those that `compare` knows.
    candidates : tuple of Candidate
        In the order that they were given.
    failures : mapping of str to str
        Candidates that this record does not identify, with the reason.
    tests : tuple of NestedTest
        Each model against the next richer ones that contain it.
    same : tuple of (str, str)
        Candidates that are one model in different parameters.
    blocks, gap : int
        Held-out blocks, and the rows left out on both sides of each.
    recommended : str or None
        None where no candidate explains any of what is held out.
    tied : tuple of str
        Candidates that the held-out error cannot tell from the best, with it and the recommended
        one.
    reason : str
        Why that one, or none, in one sentence.
    law : LawAgreement or Missing
        The first candidate's control law against the record.
    set_aside : mapping of str to str
        Records that could not be used, with the reason.
    result : Identification or None
        Of the recommended candidate.
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
        """Of the recommended candidate; without one, why there is none."""
        none = (Check.unless("recommendation", self.reason),)
        return none if self.result is None else self.result.checks

    @property
    def known(self) -> KnownValues:
        """What is known of each record."""
        return {} if self.problem.joint_form is None else self.problem.joint_form.known

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
        Two or more, of one coordinate and one drive; see `friction_ladder` for a set of them.
    record : Record or sequence of Record
        Several are one regression, as in `identify`.
    prefilter : Prefilter, optional
        The same for all.
    method : str
        ``idm-ls``, ``idm-iv`` or another one whose row in `axisid.estimation.choices` says so.
        Estimator of the tables, of the held-out errors and of the Wald tests.
    progress : callable, optional
        Told before each step how many are done, of how many, and which it is.
    local, known, gain, skip_bad
        As in `identify`, of several records, and of every candidate.
    start : str
        Of instruments, as in `identify`.
    level, least_share : float
        As in `identify`, by which the recommended candidate is judged.

    Raises
    ------
    UsageError
        The axes cannot be compared, or the method is another.
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
    # The same rows for all: those that suit the candidate with the most friction.
    first = min(named.values(), key=lambda axis: (axis.is_linear, not axis.has_direction))
    suited = Prefilter.given(prefilter).at_rate_of(records[0].period)
    # Parameters that are each record's own are those of a candidate that has them all.
    own_names = ({local} if isinstance(local, str) else {*local}) - {""}
    able = (
        axis
        for axis in named.values()
        if {*declared_names(axis, own_names)} <= {p.name for p in axis.declared.parameters}
    )
    owner = next(able, first) if own_names else first
    shared = joint_records(owner, records, suited, local, known, gain, skip_bad=skip_bad)
    problem = shared.problem(first, suited)
    gap = max(data.sampling.filter.memory for data in problem.data)
    fits: dict[str, Identification] = {}
    candidates: list[Candidate] = []
    failures: dict[str, str] = {}
    for name, axis in with_progress(named.items(), progress, lambda item: f"estimate of {item[0]}"):
        lead = ""
        try:
            joint = shared.joint_form(axis)
            pairs = zip(problem.data, shared.axes(axis, joint), strict=True)
            data = tuple(replace(each, axis=of_record) for each, of_record in pairs)
            own = replace(problem, axis=axis, data=data, joint_form=joint)
            found = identify_problem(
                own, own.data[0].prefilter, [method], start=start, levels=levels
            )
            estimate, lead = found[method], "with a tenth of the rows held out, "
            blocks = contiguous_blocks(len(estimate.y), gap, len(estimate.physical))
            rows = regression_rows(estimate)
            with np.errstate(all="ignore"):
                candidates.append(
                    Candidate(
                        name=name,
                        axis=axis,
                        estimate=estimate,
                        criteria=criteria(rows),
                        equation=held_out_equation(
                            rows, blocks, float(np.linalg.norm(estimate.weights * estimate.y))
                        ),
                    )
                )
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
        problem=problem,
        method=method,
        candidates=tuple(candidates),
        failures=failures,
        tests=tests,
        same=same,
        blocks=len(blocks),
        gap=gap,
        recommended=recommended,
        tied=tied,
        reason=reason,
        law=first_failing(next(iter(fits.values())).case.laws),
        set_aside=shared.set_aside,
        result=None if recommended is None else fits[recommended],
    )


def _named(
    axes: Mapping[str, Axis | GeneratedAxis] | Sequence[Axis | GeneratedAxis],
) -> dict[str, GeneratedAxis]:
    """Axes by name, which explain the same force by the same motion."""
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
    best = min(candidates, key=lambda c: (c.equation.error_percent, c.size))
    tied = [c for c in candidates if c is best or _is_as_good(c, best)]
    chosen = min(tied, key=lambda c: (c.size, c.equation.error_percent))
    names, error = tuple(c.name for c in tied), chosen.equation.error_percent
    if not best.equation.error_percent < NO_RELATION.value:
        return (
            None,
            names,
            f"the smallest held-out error, {best.equation.error_percent:.4g} % of {best.name}, is "
            "no smaller than the force itself: what one part of the record tells does not hold in "
            "the others. Record several speeds in both directions, more than once",
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
    """Whether the held-out error is the best one's, as far as the blocks can tell or anyone cares.

    The second condition is for an excess that lies in one block: its standard error is as large.
    """
    excess, deviation = candidate.equation.excess(best.equation)
    times = _MAX_TIED_ERROR if excess <= deviation else _EQUAL_ERROR
    return candidate.equation.error_percent <= times * best.equation.error_percent
