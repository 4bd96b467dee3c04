"""Twins: records as their loops would have been logged, with noise or without."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from zlib import crc32

import numpy as np

from axisid.estimation.estimation_problem import Problem, Solver
from axisid.estimation.records import Record
from axisid.estimation.regression import Equations, Form, Solution, recorded_loops
from axisid.estimation.signals import FilteredRecord, Signals, hold_mean
from axisid.estimation.simulation import Simulation, logged_control, measured_positions
from axisid.support.arrays import Array, in_few_digits
from axisid.support.errors import DataError, EstimationError, UsageError, is_whole, quoted

from .noise_model import AntitheticDraws, Chain

#: Enough for intervals.
DEFAULT_TWIN_COUNT = 32

_FEWEST, _MOST = 8, 100_000  # but for none


def check_twin_count(count: object) -> None:
    """Refuse a number of twins that tells nothing.

    Raises
    ------
    UsageError
        It is none from 8 on, nor 0.
    """
    if not (is_whole(count) and (count == 0 or _FEWEST <= count <= _MOST)):
        raise UsageError(
            f"the twins of the bootstrap are {quoted(count)}; give a whole number from {_FEWEST} "
            f"to {_MOST}, or 0 for none.",
            code="noise",
        )


@dataclass(frozen=True, kw_only=True)
class Twins:
    """Twins of a problem's records.

    Attributes
    ----------
    problem : Problem
    form : Form
        In which the parameters are the problem's.
    at : (p,) array
        Physical parameters of their loops, to as many digits as these are simulated with.
    chains : tuple of Chain
        One for each record.
    count : int
        How many are drawn: one whose loop cannot be simulated is left out. Without noise all are
        alike, and one is.
    kinds : tuple of type of Form
        Linear forms whose rows are made of each twin together.
    """

    problem: Problem
    form: Form
    at: Array
    chains: tuple[Chain, ...]
    count: int
    kinds: tuple[type[Form], ...] = ()
    #: Rows by form, which are the same wherever they are asked for if the axis is linear.
    _linear: dict[type[Form], list[Equations]] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "at", in_few_digits(self.at))
        if all(each.is_silent for each in self.chains):
            object.__setattr__(self, "count", 1)

    def solutions(self, form: Form, solver: Solver) -> list[Solution]:
        """What a solver makes of each: one step from an estimate, with its own instruments."""
        solutions = []
        for rows in self.rows(form):
            with suppress(EstimationError):
                solution = solver(form, rows)
                if np.isfinite(solution.theta).all():
                    solutions.append(replace(solution, neighbours=self.problem.neighbours))
        return solutions

    def rows(self, form: Form) -> Iterable[Equations]:
        """Their rows, one after the other."""
        if not form.is_linear:
            return (rows for (rows,) in self._drawn([form]))
        if type(form) not in self._linear:
            others = (self.problem.form(kind) for kind in self.kinds if kind is not type(form))
            forms = [form, *others]
            drawn = [*self._drawn(forms)]
            for place, each in enumerate(forms):
                self._linear[type(each)] = [rows[place] for rows in drawn]
        return self._linear[type(form)]

    def _drawn(self, forms: Sequence[Form]) -> Iterator[list[Equations]]:
        data = self.problem.data
        physical = [self.form.own(self.at, place) for place in range(len(data))]

        def twins(run: int) -> list[Signals]:
            return [
                twin_of(each, theta, chain, _draws(each.record, run)).signals
                for each, theta, chain in zip(data, physical, self.chains, strict=True)
            ]

        for runs in _paired(self.count):
            with suppress(DataError, EstimationError):  # one alone would not cancel
                yield from [
                    [self.problem.reduced(form, own) for form in forms] for own in map(twins, runs)
                ]


def _draws(record: Record, run: int) -> AntitheticDraws:
    """Random numbers of a record's own digits: its twins are the same in whatever company.

    Every other twin has the opposite of those of the one before: what is a straight line of the
    noise cancels in the mean of the two, so that few tell a bias.
    """
    seed = crc32(np.ascontiguousarray(record.position).tobytes())
    return AntitheticDraws(np.random.default_rng((seed, run // 2)), -1.0 if run % 2 else 1.0)


def _paired(count: int) -> list[range]:
    """Runs of opposite noise together."""
    return [range(first, min(first + 2, count)) for first in range(0, count, 2)]


def pair_freedom(count: int) -> float:
    """Degrees of freedom of a variance of estimates over so many twins in pairs of opposite noise.

    The estimates of a pair are ``theta + q + d`` and ``theta + q - d``. The noise moves them by d,
    which is an odd function of the noise, and its squares by q, which is hardly random. So
    ``sum_r (theta_r - mean)^2`` is ``2 sum d^2``, twice a chi-squared variable of ``count / 2``
    degrees of freedom: the second twin of a pair tells nothing new of the variance. Antithetic
    variates: [HammersleyMorton1956]_.
    """
    return float(count // 2)


def twins_of(
    data: FilteredRecord, physical: Array, chain: Chain, count: int, *, paired: bool = False
) -> Iterator[FilteredRecord]:
    """Some twins of one record, one after the other, so that few are held at a time.

    Those that cannot be simulated are left out, and none is of a silent chain.

    They are independent of each other, or `paired` with those of the opposite noise, which tell
    nothing new of what does not change its sign with the noise.
    """
    if chain.is_silent:
        return
    for runs in _paired(count) if paired else [range(2 * run, 2 * run + 1) for run in range(count)]:
        with suppress(DataError, EstimationError):
            yield from [twin_of(data, physical, chain, _draws(data.record, run)) for run in runs]


def noise_free_record(data: FilteredRecord, loops: Sequence[Simulation]) -> FilteredRecord:
    """The record as its simulated loops have it, under the same filter.

    A column that was recorded is made of the loops as its sensor would see them.
    """
    record = data.record
    jumps = data.axis.jumps
    sensed = jumps and data.prefilter.hold != "zoh"  # else it is what is held from the sample on
    simulated: dict[str, Callable[[Simulation], Array]] = {
        "position": lambda s: s.position,
        "velocity": lambda s: s.velocity,
        "acceleration": lambda s: hold_mean(s.acceleration, [0]) if jumps else s.acceleration,
        "control": lambda s: logged_control(data.axis, s),
        "force": lambda s: hold_mean(s.force, [0]) if sensed else s.force,
    }
    columns = {
        role: np.concatenate([seen(loop) for loop in loops])
        for role, seen in simulated.items()
        if getattr(record, role) is not None
    }
    return data.with_columns(**columns)


def twin_of(
    data: FilteredRecord, physical: Array, chain: Chain, rng: AntitheticDraws
) -> FilteredRecord:
    """A record as its loop would have been logged with the noise of a chain, under its filter.

    What disturbs the motion is neither in the control that is logged nor in a logged force.

    Parameters
    ----------
    data : FilteredRecord
    physical : (p,) array
        Of its axis.
    chain : Chain
    rng : AntitheticDraws

    Raises
    ------
    DataError, EstimationError
        Its loop cannot be simulated.
    """
    record, samples = data.record, len(data.record)
    by_law, step = chain.is_measured_by_law, chain.position_step
    offset = chain.drawn_offset(rng)
    noise = chain.position * rng.normal(samples) + offset
    disturbance = chain.drawn_disturbance(rng, samples, record.period)
    simulated = partial(
        recorded_loops,
        data,
        in_few_digits(physical),
        resolution=step * by_law,
        away=offset * by_law,
        position_noise=noise if by_law else None,
    )
    if chain.jitter:
        late = chain.jitter * rng.normal(samples + 1)
        noise += data.motion[1] * late[:-1]
        if by_law:
            # Each control is held for longer or shorter than a period.
            loops = simulated(disturbance=disturbance)
            control = np.concatenate([loop.control for loop in loops]) - disturbance
            disturbance = disturbance + control * np.diff(late) / record.period
    loops = simulated(disturbance=disturbance)
    control = np.concatenate([loop.control for loop in loops]) - disturbance
    disturbed, alone = (
        data.drive.force(each, data.motion, data.recorded)
        for each in (control + disturbance, control)
    )
    logged = [
        replace(
            loop,
            position=loop.measured_position - offset
            if by_law
            else measured_positions(loop.position, noise[a:b], step) - offset,
            control=control[a:b],
            force=loop.force - (disturbed - alone)[a:b],
        )
        for loop, (a, b) in zip(loops, record.spans, strict=True)
    ]
    twin = noise_free_record(data, logged)
    return twin.with_columns(**chain.logged(twin.record, rng, rng))
