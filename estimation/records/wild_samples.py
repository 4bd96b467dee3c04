"""Search and replacement of wild samples: single outliers that jump away and back in one step.

A position and a velocity are smooth, as the axis has inertia. A wild sample has opposite steps
before and after it, larger than the second differences anywhere else. The first and the last
position are wild if they do not continue their neighbours. A reference is smooth like a motion, but
it may have an impulse, to which the control then responds. A control, a force, an acceleration, a
test signal or another signal may jump to any value of its range, and so may the ends of any column,
which have only one neighbour. In these cases a sample is wild only if it is far outside the range.
A column may jump further where another column jumps: the control of a differentiating law follows
a step of the reference. Without a recorded reference this step is unknown, and the control is
compared with the limit of the drive only.

Wild samples are masked and replaced by a straight line between their neighbours, so that no filter
and no replay of the control law spreads them.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.raw_tables import Repair, Samples
from axisid.estimation.records.columns import Mask, RoleColumns
from axisid.estimation.thresholds import MAX_EVEN_STEP
from axisid.support.arrays import Array, IntArray, runs

from .clocks import long_steps
from .quantisation import quantisation_step, rounding
from .segments import Span

# Smallest excursion of a wild sample, relative to the largest movement elsewhere.
_MIN_EXCURSION = 2.0
_FEWEST = 6  # smallest number of samples of a piece between gaps that is searched
# Largest number of wild samples in a column: a number plus a share of the samples, but at most
# another number, and at most another share.
_SOME, _PART, _MOST, _MOST_PART = 10, 0.002, 100, 0.1
_GRAIN = 1e-9  # of the range: difference within which two values are equal
_PASSES = 4  # searches of a column: a wild sample may be hidden by a larger one next to it
# Samples before and after a jump of one column within which another column may respond: a step
# changes a second difference before the sample at which the law reads the step, and a control may
# be logged some samples later or earlier.
_RESPONSE = (-3, 3)

_SMOOTH = ("position", "velocity")  # roles of columns that are smooth, as the axis has inertia
_REFERENCE = "reference"

#: Numbers of samples, (k,).
Places = NDArray[np.intp]


def without_wild_samples(
    columns: RoleColumns, moduli: Mapping[str, float], limit: float = math.inf, delay: int = 0
) -> RoleColumns:
    """Return columns with wild samples masked and replaced, and with the repair that reports them.

    Columns without wild samples are returned unchanged. Position and velocity are searched first,
    then the reference, then the other columns, whose jumps may respond to the reference. Each
    column is searched in a few passes; the wild samples that a pass finds are replaced before the
    next pass.

    Parameters
    ----------
    columns : RoleColumns
        Columns by role, each with its times; every value is finite.
    moduli : mapping of str to float
        Moduli of a position and its reference by role, SI.
    limit : float
        Limit of the control, in its unit.
    delay : int
        Samples by which the control law acts late, and by which its control is logged late.
    """
    # Known range of control and force: 0 if it is unknown, infinite if no sample can be judged.
    widths = {"control": 2 * limit if math.isfinite(limit) else 0.0, "force": 0.0}
    if _REFERENCE not in columns.samples:
        widths |= {role: math.inf for role, width in widths.items() if not width}
    courses = {
        role: _Course.of(
            samples,
            moduli.get(role, 0.0),
            widths.get(role, 0.0),
            has_ends=role == "position",
            delay=delay,
        )
        for role, samples in columns.samples.items()
    }
    found: dict[str, Places] = {}
    first = [role for role in (*_SMOOTH, _REFERENCE) if role in courses]
    for role in dict.fromkeys((*first, *courses)):
        course, wild = courses[role], np.zeros(len(courses[role].values), dtype=bool)
        most = _most_wild(len(wild))
        for _ in range(_PASSES):
            # Candidates; the number of wild samples of a column is limited (`most`).
            places = course.out_of_range(most)
            if role in (*_SMOOTH, _REFERENCE):
                places = np.union1d(places, course.out_of_course(most))
            if role not in _SMOOTH:
                # A jump is not wild if another column jumps there as well.
                times = [courses[other].times[at] for other, at in found.items()]
                places = _unexplained(role, places, courses, np.concatenate([np.empty(0), *times]))
            places = places[~wild[places]]
            if not len(places):
                break
            wild[places] = True
            course = course.bridged(wild)
        if wild.any():
            found[role], courses[role] = np.flatnonzero(wild), course
    if not found:
        return columns
    texts = [_named(role, columns.samples[role], at) for role, at in found.items()]
    repair = Repair(
        kind="wild",
        count=sum(map(len, found.values())),
        text="single outliers, which jump away and back within one step, further than the column "
        f"moves anywhere else, are masked with the rows whose filters reach them: "
        f"{'; '.join(texts)}",
    )
    changed = {role: replace(columns.samples[role], values=courses[role].values) for role in found}
    masks = {role: _mask(at, len(courses[role].values)) for role, at in found.items()}
    return replace(columns.repaired(changed, repair), masks={**columns.masks, **masks})


def wild_steps(position: Array, spans: Sequence[Span]) -> Places:
    """Return the steps of a position that are outliers among the steps.

    Parameters
    ----------
    position : (N,) array
        Sampled evenly within each piece.
    spans : sequence of (int, int)
        First sample and the one after the last of each piece without gaps. Each step is compared
        with its neighbours of the same piece, and with the changes of the steps in all pieces.

    Returns
    -------
    (K,) array of int
        The sample before each outlying step; at most a tenth of all samples are returned.
    """
    places = np.concatenate([np.arange(start, stop - 1) for start, stop in spans])
    if not len(places):
        return places
    piece = np.repeat(np.arange(len(spans)), [stop - start - 1 for start, stop in spans])
    # Pieces are far apart on this clock, so that none continues another.
    steps = Samples(values=position[places + 1] - position[places], clock=places + 1e3 * piece)
    course = _Course.of(steps, 0.0, 0.0, has_ends=False, delay=0)
    return places[course.spikes(int(_MOST_PART * len(position)))]


def _most_wild(size: int) -> int:
    """Return the largest number of wild samples in a column of the given size."""
    return min(_SOME + int(_PART * size), _MOST, int(_MOST_PART * size))


def _mask(places: Places, size: int) -> Mask:
    """Return a mask, (size,), that is True for the given samples (`places`) of a column."""
    mask = np.zeros(size, dtype=bool)
    mask[places] = True
    return mask


def _named(role: str, samples: Samples, places: Places) -> str:
    """Return a text on the wild samples of a column: the first, and the number of the others."""
    first, others = places[0], len(places) - 1
    more = f", and {others} more" if others else ""
    return f"{role} {samples.values[first]:.6g} at {samples.times[first]:.9g} s{more}"


def leading_zeros_note(columns: RoleColumns) -> list[str]:
    """Return a note on rows at the start of a log in which every column is exactly 0.

    The list is empty if there are fewer than six such rows, or only one column.

    Parameters
    ----------
    columns : RoleColumns
        Columns by role, each with its times.
    """
    begins = []
    for samples in columns.samples.values():
        others = np.flatnonzero(samples.values)
        if len(others):
            begins.append(float(samples.times[others[0]]))
    clock = columns.motion.times
    rows = int(np.sum(clock < min(begins, default=clock[0])))
    if rows < _FEWEST or len(columns.samples) < 2:
        return []
    return [
        f"every column is 0 in the first {rows} rows, perhaps because the recorder had not "
        "started. Unless the axis was at standstill there, leave them out with windows = "
        f'["{min(begins):.9g}.."] in run.toml'
    ]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Course:
    """A column with its second differences, in which wild samples are searched.

    The excursion of a sample is its distance from both neighbours, to one side: the smallest of the
    second differences before and after it, and of half its own second difference. A wild sample has
    a large excursion; a jump to a new value has none.

    Attributes
    ----------
    values, times : (N,) array
        Values of the column, SI, and times, s.
    spans : tuple of (int, int)
        First sample and the one after the last of each piece without gaps.
    modulus : float
        Modulus after which the values restart; 0 for none.
    width : float
        Width of the known range of the column; 0 for an unknown range, infinite if no sample is to
        be found by the range.
    has_ends : bool
        True if the first and the last sample must continue the others, as the column is smooth.
    delay : int
        Number of samples by which the control law acts late.
    excursions : (N,) array
        Excursion of each sample; 0 if it has none.
    bends : (N,) array
        Absolute second difference; 0 at the ends.
    """

    values: Array
    times: Array
    spans: tuple[Span, ...]
    modulus: float
    width: float
    has_ends: bool
    delay: int
    excursions: Array
    bends: Array

    @classmethod
    def of(
        cls, samples: Samples, modulus: float, width: float, *, has_ends: bool, delay: int
    ) -> "_Course":
        """Return a column with its second differences and excursions; arguments are attributes."""
        cuts = long_steps(samples.times, MAX_EVEN_STEP.value) + 1
        ends = [0, *cuts.tolist(), len(samples.values)]
        spans = tuple(pairwise(ends))
        values = samples.values
        excursions, bends = _excursions(values, spans, modulus)
        return cls(
            values=values,
            times=samples.times,
            spans=spans,
            modulus=modulus,
            width=width,
            has_ends=has_ends,
            delay=delay,
            excursions=excursions,
            bends=bends,
        )

    def out_of_course(self, most: int) -> Places:
        """Return the samples whose excursion exceeds all second differences of the other samples.

        At most `most` samples with the largest excursions are compared.
        """
        excursions = self.excursions if self.has_ends else self._inner_excursions()
        order = _largest(excursions, most)
        return self._standing_out(excursions, order, self._largest_bends(order))

    def spikes(self, most: int) -> Places:
        """Return the samples whose excursion exceeds the second differences without candidates.

        Candidates are the samples with the largest excursions, at most `most`.
        """
        excursions = self._inner_excursions()
        order = _largest(excursions, most)
        elsewhere = self._largest_bends(order)[-1]
        return self._standing_out(excursions, order, np.full(len(order) + 1, elsewhere))

    def _inner_excursions(self) -> Array:
        """Return the excursions, with 0 at the ends."""
        excursions = np.array(self.excursions)
        for start, stop in self.spans:
            excursions[[start, stop - 1]] = 0.0
        return excursions

    def out_of_range(self, most: int) -> Places:
        """Return the samples whose excursion exceeds the range of the other samples.

        At most `most` samples with the largest excursions are compared.
        """
        order = _largest(self.excursions, most)
        return self._standing_out(self.excursions, order, self._ranges(order))

    def _standing_out(self, excursions: Array, order: Places, moves: Array) -> Places:
        """Return the samples whose excursion exceeds twice the movement of the other samples.

        The movement is at least two quantisation steps. If a sample stands out, all samples with
        larger excursions are returned too.

        Parameters
        ----------
        excursions : (N,) array
            Excursion of each sample, see `_Course`.
        order : (K,) array of int
            Samples in the order of decreasing excursions.
        moves : (K + 1,) array
            Movement of the column, such as its largest second difference, without the first 0 to K
            of these samples.
        """
        others = np.delete(self.values, order)
        if not len(order) or not len(others) or np.ptp(others) == 0:
            return order[:0]
        # A differentiated position has whole steps too, except for rounding of its differences.
        grain = _GRAIN * float(np.ptp(others))
        rough = quantisation_step(grain * np.round(others / grain))
        quantum = max(quantisation_step(others), rough, rounding(others))
        least = _MIN_EXCURSION * np.maximum(moves[1:], 2 * quantum)
        standing = np.flatnonzero(excursions[order] > least)
        if not len(standing):
            return order[:0]
        return np.sort(order[: standing[-1] + 1])

    def _largest_bends(self, order: Places) -> Array:
        """Return the largest second differences without the first 0 to K of K samples, (K + 1,)."""
        rank = _ranks(order, len(self.values))
        padded = np.full(len(rank) + 2, len(order))
        padded[1:-1] = rank
        # A second difference counts until the first of its three samples is left out.
        least = np.minimum(np.minimum(padded[:-2], padded[1:-1]), padded[2:])
        largest = np.zeros(len(order) + 1)
        np.maximum.at(largest, least, self.bends)
        return _from_the_end(np.maximum, largest)

    def _ranges(self, order: Places) -> Array:
        """Return the ranges without the first 0 to K of K samples, (K + 1,).

        A range is at least the known width of the column.
        """
        rank = _ranks(order, len(self.values))
        highest = np.full(len(order) + 1, -np.inf)
        lowest = np.full(len(order) + 1, np.inf)
        np.maximum.at(highest, rank, self.values)
        np.minimum.at(lowest, rank, self.values)
        ranges = _from_the_end(np.maximum, highest) - _from_the_end(np.minimum, lowest)
        return np.maximum(ranges, self.width)

    def jumps(self, time: float, times: Array) -> bool:
        """Return True if the column jumps near a time, s.

        The largest second difference near the time must then exceed twice the largest one that is
        not near any of the given times, (k,), s.
        """
        kept = np.ones(len(self.values), dtype=bool)
        for each in times:
            kept[self._near(each)] = False
        here = float(self.bends[self._near(time)].max(initial=0.0))
        elsewhere = float(self.bends[kept].max(initial=0.0))
        return here > _MIN_EXCURSION * max(elsewhere, rounding(self.values))

    def _near(self, time: float) -> slice:
        """Return the samples near a time, s, in which the column may respond to another column."""
        place = int(np.searchsorted(self.times, time))
        before, after = _RESPONSE
        return slice(max(place + before - self.delay, 0), place + after + 1)

    def bridged(self, wild: Mask) -> "_Course":
        """Return the column with its wild samples, (N,), replaced by straight lines.

        The lines are rounded to the quantisation step of the column.
        """
        values = np.array(self.values)
        quantum = quantisation_step(values[~wild])
        for start, stop in self.spans:
            for first, end in runs(wild[start:stop], start):
                _bridge(values, first, end, (start, stop), self.modulus, quantum)
        excursions, bends = _excursions(values, self.spans, self.modulus)
        return replace(self, values=values, excursions=excursions, bends=bends)


def _largest(excursions: Array, most: int) -> Places:
    """Return at most `most` samples with an excursion, the largest first."""
    if not most:
        return np.zeros(0, dtype=np.intp)
    order = np.argpartition(-excursions, most - 1)[:most]
    order = order[np.argsort(-excursions[order], kind="stable")]
    return order[excursions[order] > 0]


def _ranks(order: Places, size: int) -> IntArray:
    """Return the rank of each of `size` samples in an order of samples, (size,).

    Samples that are not in the order have its length as rank.
    """
    rank = np.full(size, len(order))
    rank[order] = np.arange(len(order))
    return rank


def _from_the_end(extreme: np.ufunc, values: Array) -> Array:
    """Return the maximum or minimum (`extreme`) of each value and all later values, (n,)."""
    return np.asarray(extreme.accumulate(values[::-1])[::-1], dtype=float)


def _excursions(values: Array, spans: Sequence[Span], modulus: float) -> tuple[Array, Array]:
    """Return the excursion and the absolute second difference of each sample, (N,) each.

    Both are explained in `_Course`; they are 0 in pieces (`spans`) that are too short to search.
    """
    excursions, bends = np.zeros(len(values)), np.zeros(len(values))
    for start, stop in spans:
        if stop - start < _FEWEST:
            continue
        steps = _steps(values[start:stop], modulus)
        second = np.diff(steps)
        bend = np.abs(second)
        # A single wild sample has second differences of 1, -2 and 1 times its distance.
        inner = -second / 2
        before = np.concatenate([inner[:1], second[:-1]])
        after = np.concatenate([second[1:], inner[-1:]])
        up = np.minimum(np.minimum(before, inner), after)
        down = np.minimum(np.minimum(-before, -inner), -after)
        bends[start + 1 : stop - 1] = bend
        excursions[start + 1 : stop - 1] = np.maximum(np.maximum(up, down), 0.0)
        # An end whose neighbour is wild has a second difference too, smaller than its neighbour's.
        excursions[start] = max(bend[0] - 3 * bend[1], 0.0)
        excursions[stop - 1] = max(bend[-1] - 3 * bend[-2], 0.0)
    return excursions, bends


def _steps(values: Array, modulus: float) -> Array:
    """Return the differences of consecutive values, without jumps by a modulus, (n - 1,)."""
    steps = np.diff(values)
    return steps - modulus * np.round(steps / modulus) if modulus else steps


def _bridge(
    values: Array, first: int, end: int, span: Span, modulus: float, quantum: float
) -> None:
    """Replace the values from sample `first` to before `end` by a line through their neighbours.

    Parameters
    ----------
    values : (N,) array
        Values of the column, which are changed.
    first, end : int
        First replaced sample, and the one after the last.
    span : (int, int)
        First sample and the one after the last of the piece without gaps.
    modulus : float
        Modulus after which the values restart; 0 for none.
    quantum : float
        Quantisation step of the column; 0 if it is unknown.
    """
    left, right = first - 1, end
    has_left, has_right = left >= span[0], right < span[1]
    if not has_left and not has_right:
        return
    origin = left if has_left else right
    slope = 0.0
    if has_left and has_right:
        if modulus and abs(values[right] - values[left]) > modulus / 2:
            values[first:end] = values[left]  # the values restart here, so no line is drawn
            return
        slope = (values[right] - values[left]) / (right - left)
    elif has_right and right + 1 < span[1]:
        slope = _steps(values[right : right + 2], modulus)[0]
    elif has_left and left - 1 >= span[0]:
        slope = _steps(values[left - 1 : left + 1], modulus)[0]
    moved = slope * (np.arange(first, end) - origin)
    if quantum:
        moved = quantum * np.round(moved / quantum)
    values[first:end] = values[origin] + moved


def _unexplained(
    role: str, places: Places, courses: Mapping[str, _Course], wild_times: Sequence[float] | Array
) -> Places:
    """Return the samples of a column whose jumps no other column explains.

    Another column explains a jump if it jumps near the same time, unless it is wild at that time.

    Parameters
    ----------
    role : str
        Role of the searched column.
    places : (k,) array of int
        Samples of the column that jump.
    courses : mapping of str to _Course
        All columns by role.
    wild_times : (m,) array
        Times of the wild samples of other columns, s.
    """
    times = courses[role].times[places]
    others = [course for other, course in courses.items() if other != role]
    wild = [
        place
        for place, time in zip(places, times, strict=True)
        if time in wild_times or not any(course.jumps(time, times) for course in others)
    ]
    return np.array(wild, dtype=np.intp)
