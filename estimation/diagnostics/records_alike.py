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
either record are looked for in both; where many of them are equally far apart, the samples there
are compared one by one. An axis at rest repeats its rows, so that two records that both rest have
nothing in common. Numbers are compared as 32-bit floats, since files may write them with other
digits, or in other units. Of records that were resampled the rows before are compared, where they
are kept: those of columns of one clock.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.checks import DEFAULT_LEVELS, Check, Levels, first_case
from axisid.estimation.estimates import Estimate, part_of
from axisid.estimation.problems import Problem
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
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing, of_found

_OWN_PART = 1e-3  # of a column, below which others span it: slopes by differences are as exact
_FEWEST = 5.0  # degrees of freedom from which scores tell what is chance
_LOAD_UNITS = ("kg", "kg m^2", "kg*m^2")
# rows, each once in either record and equally far apart
_MIN_COMMON_ROWS = 25
# of the column's largest: one number in other digits or units; files have six or more
_MAX_WRITTEN_APART = 1e-6

_Chosen = NDArray[np.bool_]


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
    """One record beside the others.

    Attributes
    ----------
    names : tuple of str
        Of the parameters that it tells and shares, length p.
    own, others : (p,) array
        As the record alone has them, and as the others have them without it.
    deviations : (p,) array
        Of the difference.
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

    names: tuple[str, ...]
    own: Array
    others: Array
    deviations: Array
    statistic: float
    freedom: tuple[float, float]
    p_value: float
    share_percent: float
    untold: tuple[str, ...] = ()

    @property
    def distances(self) -> Array:
        """Of the record's own from the others, in deviations of the difference, (p,)."""
        return (self.own - self.others) / self.deviations

    def matters(self, levels: Levels) -> bool:
        """Whether it is beyond chance, and makes any force to speak of."""
        return self.p_value < levels.level and self.share_percent > 100 * levels.least_share


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
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

    def only(self, places: Sequence[int]) -> "Difference":
        """Of some of the parameters, whatever the others are."""
        return replace(
            self,
            of=self.of.only(places),
            difference=self.difference[places],
            covariances=tuple(each[np.ix_(places, places)] for each in self.covariances),
        )

    @property
    def explained(self) -> "Difference":
        """The fewest parameters that explain it, one at least."""
        left, chosen = [*range(len(self.difference))], list[int]()
        while not chosen or (left and self.only(left).apart.matters(self.levels)):
            best = min(left, key=lambda j: self.only([i for i in left if i != j]).square)
            left.remove(best)
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
        q, made = len(self.difference), self.of.columns @ self.difference
        return RecordDifference(
            names=self.of.names,
            own=self.of.values + self.difference,
            others=self.of.values,
            deviations=_deviations(self.covariances[0]),
            statistic=self.square / q,
            freedom=(float(q), self.freedom - q + 1),
            p_value=joint_p(self.square, q, self.freedom),
            share_percent=relative_error_percent(made, np.array([self.of.size])),
            untold=self.untold,
        )

    def told(self, whose: str, rest: str) -> str:
        """What each parameter is in the record and in the others."""
        own, others = (_deviations(each) for each in self.covariances[1:])
        figures = zip(self.of.values + self.difference, own, self.of.values, others, strict=True)
        each = [
            f"{name} is {value:.4g} +- {sd:.1g} {unit} in {whose} and {other:.4g} +- {other_sd:.1g}"
            for name, unit, (value, sd, other, other_sd) in zip(
                self.of.names, self.of.units, figures, strict=True
            )
        ]
        first = [f"{each[0]} in {rest}", *each[1:]]
        load = any(unit in _LOAD_UNITS for unit in self.of.units)
        return ", ".join(first) + ", as under another load" * load


@dataclass(frozen=True, slots=True, kw_only=True)
class Alike:
    """Several records, one against the others.

    Attributes
    ----------
    records : tuple of RecordDifference or Missing
        By record: beside all of the others; missing where one alone does not tell the parameters.
    against : tuple of int
        Records that speak against the rest, the one that does most first.
    p_value : float
        The least of those that were tested first, allowed for their number.
    rejected : bool
        Whether chance explains it no more; then `against` may still be empty of differences that
        make no force to speak of.
    differing : Difference or None
        The parameters of the first that speaks against the rest, or of the one that differs most,
        that are not theirs; None where chance explains it.
    """

    records: tuple[RecordDifference | Missing, ...]
    against: tuple[int, ...]
    p_value: float
    rejected: bool
    differing: Difference | None = None


def rows_alike(
    problem: Problem, estimate: Estimate, levels: Levels = DEFAULT_LEVELS
) -> Alike | Missing:
    """Hold each record against the others, by the rows of an estimate of all.

    Chance is what twins of the records make of them, or HAC of too few.
    """
    if estimate.is_direct:
        return Missing("the rows of a direct model are accelerations")
    if estimate.counts is not None:
        return Missing("rows count by residuals, in a record alone by others than in all of them")
    weights, told = estimate.row_weights, estimate.inference
    left, off = told.twins_residuals, told.twins_off
    X, Z = (weights[:, None] * each for each in (estimate.X, estimate.score_columns))
    names = [q.label for q in estimate.form.quantities]

    def extended(columns: Array, instruments: Array) -> tuple[Array, Array, Array]:
        every = [*names, *("a record's own" for _ in columns.T)]
        regressor = checked_columns(np.hstack([X, columns]), every, neighbours=estimate.neighbours)
        Z_of_all = factor(np.hstack([Z, instruments]), every)
        found = instrumental_variables(weights * estimate.net_residuals, regressor, Z_of_all)
        told = None
        if left is not None and off is not None:
            moved = found.influence.T @ (weights[:, None] * left)
            # Twins' residuals are beside what each of them has in common, which scatters too.
            moved[: off.shape[1]] += off.T
            told = covariance_of_twins(moved, columns.shape[1])
        applied = told or Hac().applied(found)
        return found.theta, applied.matrix, applied.freedom

    records = []
    for number, span in enumerate(problem.spans):
        part, own = part_of(estimate, problem, number), weights[span]
        records.append(
            RecordRegressor(
                names=tuple(q.name for q in part.quantities),
                units=tuple(q.unit for q in part.quantities),
                values=part.corrected,
                slopes=estimate.form.slopes(number),
                span=span,
                columns=own[:, None] * part.X,
                instruments=own[:, None] * part.score_columns,
                size=float(np.linalg.norm(own * part.y)),
            )
        )
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
    matrix, freedom = np.atleast_2d(np.cov(moved)), np.full(len(moved), pairs)
    return CovarianceEstimate(matrix=matrix, freedom=freedom)


def records_alike(
    instruments: Array,
    records: Sequence[RecordRegressor],
    extended: Solved,
    levels: Levels = DEFAULT_LEVELS,
) -> Alike | Missing:
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
    left, against = [*range(len(records))], list[int]()
    differences = {i: tested((), i) for i in left}
    first = tuple(e if isinstance(e, Missing) else e.apart for e in differences.values())
    chances = [each.p_value for each in first if isinstance(each, RecordDifference)]
    if not chances:
        return next(each for each in first if isinstance(each, Missing))
    aside = list[int]()
    while told := {i: e.apart for i, e in differences.items() if isinstance(e, Difference)}:
        worst = min(told, key=lambda i: (told[i].p_value, -told[i].statistic))
        if _allowed(told[worst].p_value, len(left)) >= levels.level:
            break
        if told[worst].matters(levels):
            against.append(worst)
        aside.append(worst)
        left.remove(worst)
        differences = {i: tested(aside, i) for i in left}
    differing = None
    if aside:
        most = (against or aside)[0]
        of_most = tested([i for i in aside if i != most], most)
        differing = None if isinstance(of_most, Missing) else of_most.explained
    return Alike(
        records=first,
        against=tuple(against),
        p_value=_allowed(min(chances), len(chances)),
        rejected=bool(aside),
        differing=differing,
    )


@of_found
def alike_check(
    found: Alike,
    names: Sequence[str],
    levels: Levels = DEFAULT_LEVELS,
    output: str = "force",
) -> Check:
    """Whether the records are alike, as a check; each record has a name."""
    shares = [each.share_percent for each in found.records if isinstance(each, RecordDifference)]
    own = ",".join(found.differing.of.names if found.differing else ())
    advice = (
        "; say what is known to differ, as a payload that the axis declares (known NAME=V1,V2), or "
        f"let each record have its own (local {own})"
    )
    untold = "; ".join(
        f"{name} alone would not tell {'them' if isinstance(e, Missing) else ', '.join(e.untold)}"
        for name, e in zip(names, found.records, strict=True)
        if isinstance(e, Missing) or e.untold
    )
    return Check(
        name="records alike",
        status="fail" if found.against else "note" if found.rejected else "pass",
        figure=max(shares),
        threshold=100 * levels.least_share,
        p_value=found.p_value,
        source=f"percent of a record's {output} that the parameters it has alone make otherwise "
        "than those of the others; fails where that is more, and chance would make as much in less "
        f"than {100 * levels.level:g} % (Hotelling's test, allowed for the number of records)",
        meaning=_meaning(found, names, levels, output)
        + f" ({untold})" * bool(untold)
        + advice * bool(found.against and found.differing),
    )


def _meaning(found: Alike, names: Sequence[str], levels: Levels, output: str) -> str:
    of, several = " and ".join(names[i] for i in found.against), len(found.against) > 1
    lead = f"{of} {'speak' if several else 'speaks'} against the rest"
    rest, said = "the rest", ""
    if len(names) == 2:
        lead = f"{names[0]} and {names[1]} speak against one another"
    if (differing := found.differing) is not None:
        rest = names[1 - differing.number] if len(names) == 2 else rest
        said = f": {differing.told(names[differing.number], rest)}"
    return first_case(
        (
            not found.rejected,
            "each record alone would give the same parameters, but for chance",
        ),
        (
            not found.against,
            "the records differ by more than chance, in what makes less than "
            f"{100 * levels.least_share:g} % of the {output}{said}",
        ),
        (
            True,
            f"{lead}{said}. What is estimated of all is no record's, nor need the other "
            "parameters be",
        ),
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
) -> Difference | Missing:
    """A record against those that have no parameters of their own, as records aside have."""
    columns = instruments = np.zeros((len(base), 0))
    alone, own = list[int](), list[int]()
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
        change, covariance, freedoms = extended(columns, instruments)
    except EstimationError as error:
        return Missing(str(error))
    record, q = records[number], len(own)
    freedom = float(np.min(freedoms[-q:]))
    if freedom - q + 1 < _FEWEST:
        return Missing("too few of the residuals are independent to tell what is chance")
    chosen = [alone[j] for j in own]
    to_own = np.eye(len(change))[-q:]
    to_others = np.zeros_like(to_own)
    to_others[:, : base.shape[1]] = record.slopes[chosen]
    mapped = (to_own, to_own + to_others, to_others)
    covariances = tuple(each @ covariance @ each.T for each in mapped)
    part = record.only(chosen)
    return Difference(
        number=number,
        of=replace(part, values=part.values + to_others @ change),
        difference=to_own @ change,
        covariances=covariances,
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Overlap:
    """Samples that two records have in common.

    Attributes
    ----------
    records : (int, int)
        Which two.
    samples : ((N,) array of bool, (M,) array of bool)
        Which of the one, and which of the other.
    times : ((float, float), (float, float))
        First and last of them, s, as each record's own time counts.
    """

    records: tuple[int, int]
    samples: tuple[_Chosen, _Chosen]
    times: tuple[tuple[float, float], tuple[float, float]]

    @property
    def is_whole(self) -> bool:
        """Whether both records are these samples."""
        return all(bool(chosen.all()) for chosen in self.samples)

    def told(self, names: Sequence[str]) -> str:
        """Which samples these are, in words."""
        (i, j), (first, second) = self.records, self.times
        if self.is_whole:
            return f"{names[i]} and {names[j]} have the same samples"
        return (
            f"{names[i]} and {names[j]} have {int(self.samples[0].sum())} samples in common, from "
            f"{first[0]:.6g} to {first[1]:.6g} s of the first and from {second[0]:.6g} to "
            f"{second[1]:.6g} s of the second"
        )


def overlaps(records: Sequence[Record]) -> tuple[Overlap, ...]:
    """What every two of the records have in common, in their order."""
    pairs = combinations(range(len(records)), 2)
    found = (_overlap((i, j), records[i], records[j]) for i, j in pairs)
    return tuple(each for each in found if each is not None)


def repeated_check(records: Sequence[Record]) -> Check | None:
    """Whether samples are given more than once, which says nothing new; None where none are."""
    found = overlaps(records)
    if not found:
        return None
    counts = [np.ones(len(record)) for record in records]
    for each in found:
        for record, chosen in zip(each.records, each.samples, strict=True):
            counts[record] += chosen
    times, names = float(np.mean(np.concatenate(counts))), record_labels(records)
    return Check(
        name="repeated records",
        status="fail" if times > MAX_REPEATED_SAMPLES.value else "note",
        figure=times,
        threshold=MAX_REPEATED_SAMPLES.value,
        source="how often a sample is among the records, on average: variances are too small by as "
        "much",
        meaning=f"{'; '.join(each.told(names) for each in found)}; deviations are up to "
        f"{times**0.5:.3g} times too small: give each sample once",
    )


def _overlap(pair: tuple[int, int], one: Record, other: Record) -> Overlap | None:
    records, written = (one, other), [each.sampled or each for each in (one, other)]
    rows = _measured(*written)
    if rows is None:
        return None
    (values, places), (others, there) = map(_once, rows)
    _, i, j = np.intersect1d(values, others, assume_unique=True, return_indices=True)
    apart = there[j] - places[i]
    found = [np.zeros(len(each), dtype=bool) for each in rows]
    distances, counts = np.unique(apart, return_counts=True)
    for distance in distances[counts >= _MIN_COMMON_ROWS]:
        a, b = max(0, -distance), max(0, distance)
        n = min(len(rows[0]) - a, len(rows[1]) - b)
        off = np.abs(rows[0][a : a + n] - rows[1][b : b + n])
        same = np.all(off <= _MAX_WRITTEN_APART * np.abs(rows[0]).max(axis=0), axis=1)
        matched = places[i][apart == distance] - a
        # Rows that two runs of one motion have alike by chance have others between.
        if np.mean(same[matched.min() : matched.max() + 1]) >= MIN_COMMON_SAMPLES.value:
            found[0][a : a + n] |= same
            found[1][b : b + n] |= same
    first, second = (
        each if rows is record else np.interp(record.time, rows.time, each) == 1
        for record, rows, each in zip(records, written, found, strict=True)
    )
    if not (first.any() and second.any()):
        return None
    (a, b), (c, d) = one.time[first][[0, -1]], other.time[second][[0, -1]]
    times = (float(a), float(b)), (float(c), float(d))
    return Overlap(records=pair, samples=(first, second), times=times)


def _measured(*records: Record) -> list[NDArray[np.float32]] | None:
    """What both records measured of the motion and of the drive, by row; None without either.

    A reference is the same whenever it is run, and a position in few steps may be.
    """
    columns = [record.channels() for record in records]
    roles = [*records[0].motion, "control", "force"]
    both = [role for role in roles if all(role in each for each in columns)]
    if not {"control", "force"} & {*both} or len(both) < 2:
        return None
    with np.errstate(all="ignore"):
        rows = [np.column_stack([each[role] for role in both]) for each in columns]
        return [each.astype(np.float32) + np.float32(0) for each in rows]  # -0 is 0


def _once(rows: NDArray[np.float32]) -> tuple[NDArray[np.void], NDArray[np.intp]]:
    """Rows that occur once, as their bytes, and where."""
    values = np.ascontiguousarray(rows).view(f"V{rows[0].nbytes}")[:, 0]
    found, places, counts = np.unique(values, return_index=True, return_counts=True)
    return found[counts == 1], places[counts == 1]
