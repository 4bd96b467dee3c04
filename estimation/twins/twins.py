"""Twins: the loops of records at parameters, once more with noise, and estimates of them."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from zlib import crc32

import numpy as np

from axisid.estimation.problems import ControlSteps, Problem, Solver, loop_record
from axisid.estimation.records import Record
from axisid.estimation.regression import Equations, Form, Solution, simulated_loops
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.simulation import Simulation
from axisid.support.arrays import Array, in_few_digits
from axisid.support.errors import DataError, EstimationError, UsageError
from axisid.support.real_numbers import is_whole
from axisid.support.user_values import quoted

from .chain import Chain

_FEWEST, _MOST = 8, 100_000  # but for none


def check_count(count: object) -> None:
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
            code="bootstrap-count",
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
        Physical parameters of their loops.
    chains : tuple of Chain
        One for each record.
    count : int
        How many are drawn: one whose loop cannot be simulated is left out.
    """

    problem: Problem
    form: Form
    at: Array
    chains: tuple[Chain, ...]
    count: int

    def solutions(self, form: Form, solver: Solver) -> list[Solution]:
        """What a solver makes of each: one step from an estimate, with its own instruments."""
        found = []
        for rows in self._rows(form):
            try:
                solution = solver(form, rows)
            except EstimationError:
                continue
            if np.isfinite(solution.theta).all():
                found.append(replace(solution, neighbours=self.problem.neighbours))
        return found

    def _rows(self, form: Form) -> list[Equations]:
        if not form.is_linear:
            return list(self._drawn(form))
        if type(form) not in self._linear:
            self._linear[type(form)] = list(self._drawn(form))
        return self._linear[type(form)]

    @cached_property
    def _linear(self) -> dict[type[Form], list[Equations]]:
        """Rows by form, which are the same wherever they are asked for if the axis is linear."""
        return {}

    def _drawn(self, form: Form) -> Iterator[Equations]:
        data = self.problem.data
        own = [self.form.own(self.at, place) for place in range(len(data))]
        for run in range(self.count):
            try:
                twins = [
                    twin_of(each, theta, chain, _generator(each.record, run))
                    for each, theta, chain in zip(data, own, self.chains, strict=True)
                ]
                yield self.problem.reduced(form, [twin.signals for twin in twins])
            except (DataError, EstimationError):
                continue


def _generator(record: Record, run: int) -> np.random.Generator:
    """Random numbers of a record's own digits: its twins are the same in whatever company."""
    return np.random.default_rng((crc32(np.ascontiguousarray(record.position).tobytes()), run))


def twins_of(
    data: FilteredRecord, physical: Array, chain: Chain, count: int
) -> list[FilteredRecord]:
    """Some twins of one record, but for those that cannot be simulated; none of a silent chain."""
    made = []
    for run in range(0 if chain.is_silent else count):
        try:
            made.append(twin_of(data, physical, chain, _generator(data.record, run)))
        except (DataError, EstimationError):
            continue
    return made


def twin_of(
    data: FilteredRecord, physical: Array, chain: Chain, rng: np.random.Generator
) -> FilteredRecord:
    """A record as its loop would have been logged with the noise of a chain, under its filter.

    What disturbs the motion is neither in the control that is logged nor in a logged force.

    Parameters
    ----------
    data : FilteredRecord
    physical : (p,) array
        Of its axis.
    chain : Chain
    rng : numpy.random.Generator

    Raises
    ------
    DataError, EstimationError
        Its loop cannot be simulated.
    """
    record, samples = data.record, len(data.record)
    away = chain.position_step * rng.uniform(-0.5, 0.5)
    noise = chain.drawn_position(rng, samples) + away
    disturbance = chain.drawn_disturbance(rng, samples, record.period)
    if chain.jitter:
        late = chain.jitter * rng.standard_normal(samples + 1)
        noise += data.motion[1] * late[:-1]
        # Each control is held for longer or shorter than a period.
        loops = _noisy_loops(data, physical, chain, noise, away, disturbance)
        control = np.concatenate([loop.control for loop in loops]) - disturbance
        disturbance = disturbance + control * np.diff(late) / record.period
    loops = _noisy_loops(data, physical, chain, noise, away, disturbance)
    control = np.concatenate([loop.control for loop in loops]) - disturbance
    disturbed, alone = (
        data.drive.force(each, data.motion, data.recorded)
        for each in (control + disturbance, control)
    )
    logged = [
        replace(
            loop.as_measured(-away),
            control=control[a:b],
            force=loop.force - (disturbed - alone)[a:b],
        )
        for loop, (a, b) in zip(loops, record.spans, strict=True)
    ]
    twin = loop_record(data, logged, measured=False)
    if not chain.control_step:
        return twin
    return ControlSteps.role_of(record, chain.control_step).rounded(twin, rng.uniform(-0.5, 0.5))


def _noisy_loops(
    data: FilteredRecord,
    physical: Array,
    chain: Chain,
    noise: Array,
    away: float,
    disturbance: Array,
) -> tuple[Simulation, ...]:
    return simulated_loops(
        data.axis,
        data.record,
        in_few_digits(physical),
        resolution=chain.position_step,
        away=away,
        position_noise=noise,
        disturbance=disturbance,
    )
