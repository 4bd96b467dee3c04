"""Whether several records are of one machine, or one differs from the rest by more than chance.

A record gets parameters of its own beside those of all: its columns of them, zero in every other
record, are added to the estimate, which is solved once more. What is found of them is the record's
difference from the others; its covariance is that of twins, and without them HAC for rows, and for
a fit that of its errors. ``d' V^-1 d`` is held against Hotelling's distribution with the degrees of
freedom of that. A record that differs most keeps parameters of its own while those that are left
are tested again: what one record does to the estimate of all would else speak against the others.

Where one parameter differs, what is left of the difference is chance: parameters are named, the one
that explains most first, until chance explains the rest, or it makes no output to speak of.

Samples may also be among records more than once: a record given twice, or an overlap. Two files of
one recorder may hold the same samples, with times of their own: rows 1 to 10000 of a log, and rows
5000 to 15000. Times are therefore not looked at. Rows of what was measured that occur once in
either record are looked for in both. An axis at rest repeats its rows, so that two records that
both rest have nothing in common. Numbers are compared as 32-bit floats. Of records that were
resampled the rows before are compared, where they are kept: those of columns of one clock.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.diagnostic_checks import DEFAULT_LEVELS, Check, Levels, first_case
from axisid.estimation.estimates import Estimate, estimate_of_record
from axisid.estimation.estimation_problem import Problem
from axisid.estimation.records import Record, record_labels
from axisid.estimation.regression import (
    CovarianceEstimate,
    Hac,
    checked_columns,
    factor,
    instrumental_variables,
    joint_p,
    wald,
)
from axisid.estimation.thresholds import MAX_REPEATED_SAMPLES, MIN_COMMON_SAMPLES
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import EstimationError, Missing, unless_missing

_OWN_PART = 1e-3  # of a column, below which others span it: slopes by differences are as exact
_FEWEST = 5.0  # degrees of freedom from which scores tell what is chance
_LOAD_UNITS = ("kg", "kg m^2", "kg*m^2")
_MIN_COMMON_ROWS = 25  # each once in either record


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordRegressor:
    """What a record has of an estimate's rows, by parameters that may be its own.

    Attributes
    ----------
    names, units : tuple of str
        Of its p parameters.
    values : (p,) array
        As all records have them.
    slopes : (p, k) array
        Of those by the parameters of all.
    span : slice
        Its rows.
    columns, instruments : (n, p) array
        There.
    size : float
        Norm of what their part is told of.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    slopes: Array
    span: slice
    columns: Array
    instruments: Array
    size: float

    def only(self, places: Sequence[int]) -> "RecordRegressor":
        """Of some of the parameters."""
        return replace(
            self,
            names=tuple(self.names[j] for j in places),
            units=tuple(self.units[j] for j in places),
            values=self.values[places],
            slopes=self.slopes[places],
            columns=self.columns[:, places],
            instruments=self.instruments[:, places],
        )


#: An estimate of all, once more with further columns and their instruments, (N, q) each: its change
#: from the estimate of all, and from zero, (m,), and the covariance and the degrees of freedom of
#: that, (m, m) and (m,).
Solved = Callable[[Array, Array], tuple[Array, Array, Array]]


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordDifference:
    """A record alone beside the others, in the parameters that both tell.

    Attributes
    ----------
    own : mapping of str to float
        As the record alone has them, SI.
    common : mapping of str to float
        As the others have them without it, SI.
    deviations : mapping of str to float
        Of the difference, as twins scatter, or HAC.
    statistic : float
        Hotelling's, over its degrees of freedom.
    freedom : (float, float)
        Of F.
    p_value : float
        That chance alone makes as much, of one record.
    share_percent : float
        What the difference makes, percent of the record's force, or of what the largest parameter
        makes of its output.
    untold : tuple of str
        Parameters that the record alone does not tell.
    """

    own: Mapping[str, float]
    common: Mapping[str, float]
    deviations: Mapping[str, float]
    statistic: float
    freedom: tuple[float, float]
    p_value: float
    share_percent: float
    untold: tuple[str, ...] = ()

    @property
    def distances(self) -> dict[str, float]:
        """Of the record's own from the others, in deviations of the difference."""
        return {n: (own - self.common[n]) / self.deviations[n] for n, own in self.own.items()}

    def matters(self, levels: Levels) -> bool:
        """Whether it is beyond chance, and makes any force to speak of."""
        return self.p_value < levels.level and self.share_percent > 100 * levels.least_share


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimateDifference:
    """Parameters of a record, length p, beside those of the others.

    Attributes
    ----------
    number : int
        Of the record.
    of : RecordRegressor
        The record's, with values as the others have them without it.
    difference : (p,) array
        What the record alone has more.
    covariances : tuple of (p, p) array
        Of the difference, of the record's own and of the others'.
    freedom : float
    untold : tuple of str
        Parameters that the record alone does not tell.
    levels : Levels
        From when on it tells something.
    """

    number: int
    of: RecordRegressor
    difference: Array
    covariances: tuple[Array, ...]
    freedom: float
    untold: tuple[str, ...]
    levels: Levels

    def only(self, places: Sequence[int]) -> "EstimateDifference":
        """Of some of the parameters, whatever the others are."""
        return replace(
            self,
            of=self.of.only(places),
            difference=self.difference[places],
            covariances=tuple(each[np.ix_(places, places)] for each in self.covariances),
        )

    @property
    def explained(self) -> "EstimateDifference":
        """The fewest parameters that explain it, one at least."""
        rest, chosen = [*range(len(self.difference))], list[int]()
        while not chosen or (rest and self.only(rest).apart.matters(self.levels)):
            best = min(rest, key=lambda j: self.only([i for i in rest if i != j]).square)
            rest.remove(best)
            chosen.append(best)
        return self.only(chosen)

    @property
    def changed(self) -> tuple[str, ...]:
        """Parameters that are others; none where it is chance, or makes no force to speak of."""
        return self.explained.of.names if self.apart.matters(self.levels) else ()

    @property
    def square(self) -> float:
        """``d' V^-1 d``."""
        return wald(self.difference, self.covariances[0])[0]

    @property
    def apart(self) -> RecordDifference:
        """The test of it."""
        q, square, names = len(self.difference), self.square, self.of.names
        return RecordDifference(
            own=dict(zip(names, self.of.values + self.difference, strict=True)),
            common=dict(zip(names, self.of.values, strict=True)),
            deviations=dict(zip(names, _deviations(self.covariances[0]), strict=True)),
            statistic=square / q,
            freedom=(float(q), self.freedom - q + 1),
            p_value=joint_p(square, q, self.freedom),
            share_percent=relative_error_percent(
                self.of.columns @ self.difference, np.array([self.of.size])
            ),
            untold=self.untold,
        )

    def told(self, whose: str, rest: str) -> str:
        """What each parameter is in the record and in the others."""
        of, own = self.of, self.of.values + self.difference
        deviations, other_deviations = map(_deviations, self.covariances[1:])
        figures = zip(of.names, own, deviations, of.units, of.values, other_deviations, strict=True)
        first, *further = (
            f"{name} is {value:.4g} +- {sd:.1g} {unit} in {whose} and {other:.4g} +- {other_sd:.1g}"
            for name, value, sd, unit, other, other_sd in figures
        )
        load = ", as under another load" * any(unit in _LOAD_UNITS for unit in of.units)
        return ", ".join([f"{first} in {rest}", *further]) + load


@dataclass(frozen=True, slots=True, kw_only=True)
class PoolingTest:
    """Whether several records may be pooled: one against the others.

    Attributes
    ----------
    records : tuple of RecordDifference or Missing
        By record: beside all of the others; missing where one alone does not tell the parameters.
    against : tuple of int
        Records that speak against the rest, the one that does most first; none whose difference
        makes no force to speak of.
    p_value : float
        The least of those that were tested first, allowed for their number.
    differing : EstimateDifference or None
        The parameters of the first that speaks against the rest, or of the one that differs most,
        that are not theirs; None where chance explains it.
    """

    records: tuple[RecordDifference | Missing, ...]
    against: tuple[int, ...]
    p_value: float
    differing: EstimateDifference | None = None


def pooling_test(
    problem: Problem, estimate: Estimate, levels: Levels = DEFAULT_LEVELS
) -> PoolingTest | Missing:
    """Hold each record against the others, by the rows of an estimate of all.

    Chance is what twins of the records make of them, or HAC of too few.
    """
    if estimate.is_direct:
        return Missing("the rows of a direct model are accelerations")
    if estimate.counts is not None:
        return Missing("rows count by residuals, in a record alone by others than in all of them")
    weights, inference = estimate.weights, estimate.inference
    residuals, common = inference.twins_residuals, inference.twin_errors
    X, Z = (weights[:, None] * each for each in (estimate.X, estimate.score_columns))

    def extended(columns: Array, instruments: Array) -> tuple[Array, Array, Array]:
        names = [
            *(q.label for q in estimate.form.quantities),
            *["a record's own"] * columns.shape[1],
        ]
        regressor = checked_columns(np.hstack([X, columns]), names, neighbours=estimate.neighbours)
        solution = instrumental_variables(
            weights * estimate.net_residuals,
            regressor,
            factor(np.hstack([Z, instruments]), names),
        )
        by_twins = None
        if residuals is not None and common is not None:
            moved = solution.influence.T @ (weights[:, None] * residuals)
            # Twins' residuals are beside what each of them has in common, which scatters too.
            moved[: common.shape[1]] += common.T
            by_twins = covariance_of_twins(moved, columns.shape[1])
        applied = by_twins or Hac().applied(solution)
        return solution.theta, applied.matrix, applied.freedom

    parts = [estimate_of_record(estimate, problem, i) for i in range(len(problem.spans))]
    records = [
        RecordRegressor(
            names=tuple(q.name for q in part.quantities),
            units=tuple(q.unit for q in part.quantities),
            values=part.corrected,
            slopes=estimate.form.record_jacobian(number),
            span=span,
            columns=weights[span, None] * part.X,
            instruments=weights[span, None] * part.score_columns,
            size=float(np.linalg.norm(weights[span] * part.y)),
        )
        for number, (span, part) in enumerate(zip(problem.spans, parts, strict=True))
    ]
    return records_alike(Z, records, extended, levels)


def covariance_of_twins(moved: Array, columns: int) -> CovarianceEstimate | None:
    """Covariance of an estimate by what twins make of it, (m, R); None of too few.

    Parameters
    ----------
    moved : (m, R) array
    columns : int
        Parameters that are held against zero.
    """
    pairs = moved.shape[1] / 2  # opposite twins are one sample
    if pairs - columns + 1 < _FEWEST:
        return None
    return CovarianceEstimate(
        matrix=np.atleast_2d(np.cov(moved)), freedom=np.full(len(moved), pairs)
    )


def records_alike(
    instruments: Array,
    records: Sequence[RecordRegressor],
    extended: Solved,
    levels: Levels = DEFAULT_LEVELS,
) -> PoolingTest | Missing:
    """Hold each record against the others.

    Parameters
    ----------
    instruments : (N, k) array
        Of the parameters of all records: what residuals are without.
    records : sequence of RecordRegressor
    extended : callable
        Solves the estimate of all once more, see `Solved`.
    levels : Levels
    """
    tested = partial(_tested, instruments, records, extended, levels)
    left, aside, against = [*range(len(records))], list[int](), list[int]()
    differences = {i: tested((), i) for i in left}
    first = tuple(e if isinstance(e, Missing) else e.apart for e in differences.values())
    chances = [each.p_value for each in first if isinstance(each, RecordDifference)]
    if not chances:
        return next(each for each in first if isinstance(each, Missing))
    while tests := {
        i: e.apart for i, e in differences.items() if isinstance(e, EstimateDifference)
    }:
        worst = min(tests, key=lambda i: (tests[i].p_value, -tests[i].statistic))
        if _allowed(tests[worst].p_value, len(left)) >= levels.level:
            break
        against += [worst] * tests[worst].matters(levels)
        aside.append(worst)
        left.remove(worst)
        differences = {i: tested(aside, i) for i in left}
    most = next(iter(against or aside), None)
    of_most = None if most is None else tested([i for i in aside if i != most], most)
    return PoolingTest(
        records=first,
        against=tuple(against),
        p_value=_allowed(min(chances), len(chances)),
        differing=of_most.explained if isinstance(of_most, EstimateDifference) else None,
    )


@unless_missing
def alike_check(
    found: PoolingTest,
    names: Sequence[str],
    levels: Levels = DEFAULT_LEVELS,
    output: str = "force",
) -> Check:
    """Whether the records are alike, as a check; each record has a name."""
    untold = "; ".join(
        f"{name} alone would not tell {'them' if isinstance(e, Missing) else ', '.join(e.untold)}"
        for name, e in zip(names, found.records, strict=True)
        if isinstance(e, Missing) or e.untold
    )
    against, differing, said = [names[i] for i in found.against], found.differing, ""
    lead = (
        f"{names[0]} and {names[1]} speak against one another"
        if len(names) == 2
        else f"{' and '.join(against)} {'speak' if len(against) > 1 else 'speaks'} against the rest"
    )
    if differing is not None:
        rest = names[1 - differing.number] if len(names) == 2 else "the rest"
        said = f": {differing.told(names[differing.number], rest)}"
    meaning = first_case(
        (
            against,
            f"{lead}{said}. What is estimated of all is no record's, nor need the other "
            "parameters be",
        ),
        (
            differing,
            "the records differ by more than chance, in what makes less than "
            f"{100 * levels.least_share:g} % of the {output}{said}",
        ),
        (True, "each record alone would give the same parameters, but for chance"),
    )
    advice = (
        "; say what is known to differ, as a payload that the axis declares (known NAME=V1,V2), or "
        f"let each record have its own (local {','.join(differing.of.names)})"
        if against and differing
        else ""
    )
    return Check(
        name="records alike",
        status="fail" if against else "note" if differing else "pass",
        figure=max(e.share_percent for e in found.records if isinstance(e, RecordDifference)),
        threshold=100 * levels.least_share,
        p_value=found.p_value,
        source=f"percent of a record's {output} that the parameters it has alone make otherwise "
        "than those of the others; fails where that is more, and chance would make as much in less "
        f"than {100 * levels.level:g} % (Hotelling's test, allowed for the number of records)",
        meaning=f"{meaning}{f' ({untold})' * bool(untold)}{advice}",
    )


def _allowed(p_value: float, tests: int) -> float:
    """Bonferroni's; of two records there is one difference, which both tests are of."""
    return min(1.0, p_value * (tests if tests > 2 else 1))


def _tested(
    base: Array,
    records: Sequence[RecordRegressor],
    extended: Solved,
    levels: Levels,
    aside: Sequence[int],
    number: int,
) -> EstimateDifference | Missing:
    """A record against those that have no parameters of their own, as records aside have."""
    columns = instruments = np.zeros((len(base), 0))
    for i in (*aside, number):
        record = records[i]
        alone = _independent(record.instruments, record.instruments[:, :0])
        around = (record.span.start, len(base) - record.span.stop), (0, 0)
        X, Z = (np.pad(each[:, alone], around) for each in (record.columns, record.instruments))
        own = _independent(Z, np.hstack([base, instruments]))
        columns, instruments = np.hstack([columns, X[:, own]]), np.hstack([instruments, Z[:, own]])
    if not own:
        return Missing("this record tells no parameter that it shares with the others")
    try:
        change, covariance, dof = extended(columns, instruments)
    except EstimationError as error:
        return Missing(str(error))
    record, q = records[number], len(own)
    freedom = float(np.min(dof[-q:]))
    if freedom - q + 1 < _FEWEST:
        return Missing("too few of the residuals are independent to tell what is chance")
    part, to_own = record.only([alone[j] for j in own]), np.eye(len(change))[-q:]
    to_others = np.pad(part.slopes, ((0, 0), (0, len(change) - base.shape[1])))
    return EstimateDifference(
        number=number,
        of=replace(part, values=part.values + to_others @ change),
        difference=to_own @ change,
        covariances=tuple(
            each @ covariance @ each.T for each in (to_own, to_own + to_others, to_others)
        ),
        freedom=freedom,
        untold=tuple(name for j, name in enumerate(record.names) if j not in alone),
        levels=levels,
    )


def _independent(columns: Array, beside: Array) -> list[int]:
    """Which columns neither others nor those before them span."""
    every = np.hstack([beside, columns])
    sizes = np.linalg.norm(every, axis=0)
    own = np.diag(np.linalg.qr(every / np.where(sizes > 0, sizes, 1.0), mode="r"))
    return [*map(int, np.flatnonzero(np.abs(own[beside.shape[1] :]) > _OWN_PART))]


def _deviations(covariance: Array) -> Array:
    return np.sqrt(np.maximum(np.diag(covariance), 0.0))


def common_samples(one: Record, other: Record) -> tuple[NDArray[np.bool_], ...] | None:
    """Which samples of either record are in the other, (N,) and (M,); None where none are.

    Of those between the first and the last row that occurs once in either and is in both, where in
    one of them nearly every row between them that occurs once is.
    """
    written = [each.sampled or each for each in (one, other)]
    rows = _measured(*written)
    if rows is None:
        return None
    _, number = np.unique(np.concatenate(rows), return_inverse=True)
    numbers = np.split(number, [len(rows[0])])
    counts = [np.bincount(own, minlength=len(number)) for own in numbers]
    matched = (counts[0] == 1) & (counts[1] == 1)
    if matched.sum() < _MIN_COMMON_ROWS:
        return None
    found, shares = [], []
    for k, (record, own) in enumerate(zip((one, other), numbers, strict=True)):
        first, last = np.flatnonzero(matched[own])[[0, -1]]
        # Rows that two runs of one motion have alike by chance have others between.
        shares.append(matched.sum() / np.sum(counts[k][own[first : last + 1]] == 1))
        same = counts[1 - k][own] > 0
        if not np.array_equal(numbers[0], numbers[1]):  # else the same as they rest at the ends too
            same[:first] = same[last + 1 :] = False
        found.append(np.interp(record.time, written[k].time, same) == 1)
    return tuple(found) if max(shares) >= MIN_COMMON_SAMPLES.value else None


def repeated_check(records: Sequence[Record]) -> Check | None:
    """Whether samples are given more than once, which says nothing new; None where none are."""
    counts, names = [np.ones(len(record)) for record in records], record_labels(records)
    said = []
    for i, j in combinations(range(len(records)), 2):
        common = common_samples(records[i], records[j])
        if common is None:
            continue
        counts[i] += common[0]
        counts[j] += common[1]
        what = "the same samples"
        if not all(each.all() for each in common):
            first, second = (
                "from {:.6g} to {:.6g} s".format(*records[k].time[each][[0, -1]])
                for k, each in zip((i, j), common, strict=True)
            )
            what = (
                f"{common[0].sum()} samples in common, {first} of the first and {second} of the "
                "second"
            )
        said.append(f"{names[i]} and {names[j]} have {what}")
    if not said:
        return None
    times = float(np.mean(np.concatenate(counts)))
    return Check(
        name="repeated records",
        status="fail" if times > MAX_REPEATED_SAMPLES.value else "note",
        figure=times,
        threshold=MAX_REPEATED_SAMPLES.value,
        source="how often a sample is among the records, on average: variances are too small by as "
        "much",
        meaning=f"{'; '.join(said)}; deviations are up to {times**0.5:.3g} times too small: give "
        "each sample once",
    )


@np.errstate(all="ignore")
def _measured(*records: Record) -> list[NDArray[np.void]] | None:
    """What two records measured of the motion and of the drive, by row, as bytes; None without.

    A reference is the same whenever it is run, and a position in few steps may be.
    """
    columns = [record.channels() for record in records]
    roles = [*records[0].motion, "control", "force"]
    both = [role for role in roles if all(role in each for each in columns)]
    if not {"control", "force"} & {*both} or len(both) < 2:
        return None
    rows = [np.column_stack([each[role] for role in both]) for each in columns]
    single = [each.astype(np.float32, order="C") + np.float32(0) for each in rows]  # -0 is 0
    return [each.view(f"V{each.itemsize * len(both)}")[:, 0] for each in single]
