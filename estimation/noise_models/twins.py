"""Simulated replicas of records: the simulated loops of a record, logged with or without noise."""

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
from axisid.support.checks import is_whole
from axisid.support.errors import DataError, EstimationError, UsageError
from axisid.support.wording import quoted

from .noise_model import AntitheticDraws, Chain

#: Number of replicas that is enough for intervals.
DEFAULT_TWIN_COUNT = 32

_FEWEST, _MOST = 8, 100_000  # replicas, if their number is not 0


def check_twin_count(count: object) -> None:
    """Refuse a number of simulated replicas that is neither 0 nor 8 to 100 000.

    Raises
    ------
    UsageError
        The number is out of range, or no whole number.
    """
    if not (is_whole(count) and (count == 0 or _FEWEST <= count <= _MOST)):
        raise UsageError(
            f"the number of simulated replicas of the bootstrap is {quoted(count)}. Give a whole "
            f"number from {_FEWEST} to {_MOST}, or 0 for none.",
            code="noise",
        )


@dataclass(frozen=True, kw_only=True)
class Twins:
    """Simulated replicas of a problem's records.

    Attributes
    ----------
    problem : Problem
        The records.
    form : Form
        Regression form of the model to which the parameters `at` belong.
    at : (p,) array
        Physical parameters with which the loops are simulated, rounded to the digits of the
        simulation.
    chains : tuple of Chain
        Noise of each record.
    count : int
        Number of replicas that are drawn; results lack replicas that cannot be simulated.
        Without noise all replicas are equal, and one is drawn.
    kinds : tuple of type of Form
        Linear forms whose rows are made together from each replica.
    """

    problem: Problem
    form: Form
    at: Array
    chains: tuple[Chain, ...]
    count: int
    kinds: tuple[type[Form], ...] = ()
    #: Rows by linear form, which do not depend on the parameters of the form.
    _linear: dict[type[Form], list[Equations]] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "at", in_few_digits(self.at))
        if all(each.is_silent for each in self.chains):
            object.__setattr__(self, "count", 1)

    def solutions(self, form: Form, solver: Solver) -> list[Solution]:
        """Return the solution of each replica's rows of a form, by one step from the estimate.

        The list lacks replicas without a solution.
        """
        solutions = []
        for rows in self.rows(form):
            with suppress(EstimationError):
                solution = solver(form, rows)
                if np.isfinite(solution.theta).all():
                    solutions.append(replace(solution, neighbours=self.problem.neighbours))
        return solutions

    def rows(self, form: Form) -> Iterable[Equations]:
        """Return the rows of a form for each replica, one replica after the other.

        Rows of a linear form do not depend on its parameters. They are simulated once, together
        with the rows of the other linear forms (`kinds`), and are stored.
        """
        if not form.is_linear:
            return (rows for (rows,) in self._drawn([form]))
        if type(form) not in self._linear:
            others = (self.problem.form(kind) for kind in self.kinds if kind is not type(form))
            forms = [form, *others]
            drawn = [*self._drawn(forms)]
            for index, each in enumerate(forms):
                self._linear[type(each)] = [rows[index] for rows in drawn]
        return self._linear[type(form)]

    def _drawn(self, forms: Sequence[Form]) -> Iterator[list[Equations]]:
        """Yield the rows of each form for each simulated replica of all records."""
        data = self.problem.data
        physical = [self.form.own(self.at, record) for record in range(len(data))]

        def twins(run: int) -> list[Signals]:
            """Return the filtered signals of the replica of each record in a run."""
            return [
                twin_of(each, theta, chain, _draws(each.record, run)).signals
                for each, theta, chain in zip(data, physical, self.chains, strict=True)
            ]

        for runs in _paired(self.count):
            with suppress(DataError, EstimationError):  # a pair is kept or dropped as a whole
                yield from [
                    [self.problem.reduced(form, signals) for form in forms]
                    for signals in map(twins, runs)
                ]


def _draws(record: Record, run: int) -> AntitheticDraws:
    """Return the random numbers of a run, seeded by the record's positions.

    The replicas of a record therefore do not depend on other records. Every second run has the
    numbers of the run before with the opposite sign: effects that are linear in the noise cancel in
    the mean of the two, so that a few replicas are enough to show a bias.
    """
    seed = crc32(np.ascontiguousarray(record.position).tobytes())
    return AntitheticDraws(np.random.default_rng((seed, run // 2)), -1.0 if run % 2 else 1.0)


def _paired(count: int) -> list[range]:
    """Return the numbers of `count` runs in pairs, which have opposite noise."""
    return [range(first, min(first + 2, count)) for first in range(0, count, 2)]


def pair_freedom(count: int) -> float:
    """Return the degrees of freedom of the variance over replicas in pairs of opposite noise.

    The estimates of a pair are ``theta + q + d`` and ``theta + q - d``, with d odd and q even in
    the noise; q is hardly random. So ``sum_r (theta_r - mean)^2`` is ``2 sum d^2``, twice a
    chi-squared variable of ``count / 2`` degrees of freedom: the second replica of a pair adds no
    information on the variance. Antithetic variates: [HammersleyMorton1956]_.

    Parameters
    ----------
    count : int
        Number of replicas.
    """
    return float(count // 2)


def twins_of(
    data: FilteredRecord, physical: Array, chain: Chain, count: int, *, paired: bool = False
) -> Iterator[FilteredRecord]:
    """Yield simulated replicas of one record, one after the other, so that few are in memory.

    Replicas that cannot be simulated are not yielded. A chain without noise has no replicas.

    Parameters
    ----------
    data : FilteredRecord
    physical : (p,) array
        Parameters of the record's axis.
    chain : Chain
        Noise of the record.
    count : int
        Number of replicas.
    paired : bool
        True for pairs of replicas with opposite noise; by default all are independent.
    """
    if chain.is_silent:
        return
    # Every second run only: the run after it has the same numbers with the opposite sign.
    groups = [range(2 * run, 2 * run + 1) for run in range(count)]
    if paired:
        groups = _paired(count)
    for runs in groups:
        with suppress(DataError, EstimationError):
            yield from [twin_of(data, physical, chain, _draws(data.record, run)) for run in runs]


def noise_free_record(data: FilteredRecord, loops: Sequence[Simulation]) -> FilteredRecord:
    """Return a record with the columns of simulated loops in place of its own, with its filter.

    Each recorded column has the values that its sensor would measure in the loops, one for each
    segment, without noise.
    """
    record = data.record
    # A sensor at a sample where the force jumps reads the mean of the values before and after it.
    # The prefilter for a held force ("zoh") needs the value that is held from the sample on.
    jumps = data.axis.jumps
    force_jumps = jumps and data.prefilter.hold != "zoh"
    measured: dict[str, Callable[[Simulation], Array]] = {
        "position": lambda s: s.position,
        "velocity": lambda s: s.velocity,
        "acceleration": lambda s: hold_mean(s.acceleration, [0]) if jumps else s.acceleration,
        "control": lambda s: logged_control(data.axis, s),
        "force": lambda s: hold_mean(s.force, [0]) if force_jumps else s.force,
    }
    columns = {
        role: np.concatenate([measure(loop) for loop in loops])
        for role, measure in measured.items()
        if getattr(record, role) is not None
    }
    return data.with_columns(**columns)


def twin_of(
    data: FilteredRecord, physical: Array, chain: Chain, rng: AntitheticDraws
) -> FilteredRecord:
    """Return one simulated replica of a record with the noise of a chain, under the same filter.

    The loops are simulated with the disturbance, and with the position noise if the law reads it.
    The columns of the replica are what the record's sensors measure, with their noise. A
    disturbance moves the axis, but is in neither the logged control nor a logged force.

    Parameters
    ----------
    data : FilteredRecord
    physical : (p,) array
        Parameters of the record's axis.
    chain : Chain
        Noise of the record.
    rng : AntitheticDraws
        Random numbers of the replica.

    Raises
    ------
    DataError, EstimationError
        The loop cannot be simulated.
    """
    record, samples = data.record, len(data.record)
    by_law, step = chain.is_measured_by_law, chain.position_step
    # Random numbers, always drawn in the same order.
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
            # Jitter holds each control for longer or shorter than a period.
            loops = simulated(disturbance=disturbance)
            control = np.concatenate([loop.control for loop in loops]) - disturbance
            disturbance = disturbance + control * np.diff(late) / record.period
    # The logged control and force do not include the disturbance.
    loops = simulated(disturbance=disturbance)
    control = np.concatenate([loop.control for loop in loops]) - disturbance
    disturbed, alone = (
        data.drive.force(each, data.motion, data.recorded)
        for each in (control + disturbance, control)
    )
    # Measured positions, and the logged control and force, of each segment.
    logged = []
    for loop, (a, b) in zip(loops, record.spans, strict=True):
        if by_law:
            measured = loop.measured_position
        else:
            measured = measured_positions(loop.position, noise[a:b], step)
        logged.append(
            replace(
                loop,
                position=measured - offset,
                control=control[a:b],
                force=loop.force - (disturbed - alone)[a:b],
            )
        )
    twin = noise_free_record(data, logged)
    return twin.with_columns(**chain.logged(twin.record, rng, rng))
