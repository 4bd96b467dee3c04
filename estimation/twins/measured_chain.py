"""The chain of a record, from what it is beside its loop at an estimate."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.loops import law_residual, two_clocks
from axisid.estimation.problems import noise_free_record
from axisid.estimation.records import Record, quantisation_step
from axisid.estimation.regression import InverseForm, is_measured_by_law, sensor_steps
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.simulation import Simulation, law_of
from axisid.estimation.thresholds import MIN_STEP_DIFFERENCES
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError

from .chain import CORRELATION_TIMES, Autoregressions, Chain, MeasuredChain, spectrum
from .twins import twins_of

_TWINS = 8  # that have position noise and steps alone
_DRAWS = 16  # of a disturbance, through filter and projection
_BANDS = 22
_CLASSES = 8  # of speed
#: Squares of second differences for one power: of one degree of freedom, and of their neighbours'.
_CORRELATED = 2 * (1 + 2 * ((4 / 6) ** 2 + (1 / 6) ** 2))
_SURELY = 6.0  # of a logarithm of likelihood: by chance one in 2000
_ROUNDS = 400  # of the likelihood's multiplicative updates
_LEAST = 1e-12  # of the largest power: rounding
_SMALLEST = 1e-3  # of a band's power
_ROUNDING = 1e-12  # of the position, or the force
_MOST_LEVERAGE = 0.8  # of a frequency: where columns take nearly all, nothing is told
_RANK = 1e-6
_ROWS_A_COLUMN = 4
_LEAST_FOUND = 0.1  # of what white noise of the position would make in the rows
_HIGHEST = 0.6  # of the frequencies of rows: what the filter leaves as it is
_LONGEST = 8.0  # times that a correlation time has to fit into a record


def measured_chain(
    data: FilteredRecord, physical: Array, loops: Sequence[Simulation]
) -> MeasuredChain:
    """Measure the noise of a record.

    Steps are those of the grids of what was logged. White noise of the position is what its second
    differences have beyond those of the loop, and of twins with the encoder's steps alone, as much
    as leaves the same in twins with both. What acts beside the control is a sum of autoregressions
    of given correlation times, whose variances are the likeliest by Whittle for the rows of the
    inverse model, without all that the model's columns explain when they may change with time,
    place, speed and direction, and beside what twins with noise and steps of the position have
    there. None is there that is not surely likelier than nothing, and none is told where friction
    remembers, which has no rows. How a loop hunts over the steps of its encoder is an
    accident of where it begins, so that twins have disturbances that are the likeliest beside the
    power of one such loop or another.

    Parameters
    ----------
    data : FilteredRecord
    physical : (p,) array
        The estimate, as of this record.
    loops : sequence of Simulation
        Of the record, with it; one for each segment.

    Returns
    -------
    MeasuredChain

    Raises
    ------
    EstimationError
        There are too few rows.
    """
    quiet = noise_free_record(data, loops)
    position_step, velocity_step = sensor_steps(data.axis, data.record)
    chain = MeasuredChain(
        position_step=position_step,
        anywhere=position_step > 0,
        velocity_step=velocity_step,
        velocity=0.0 if velocity_step else _white(data.record, quiet.record, "velocity"),
        acceleration=_white(data.record, quiet.record, "acceleration"),
        control_step=0.0 if data.axis.axis.drive.quantisation else control_step(data.record),
        is_measured_by_law=is_measured_by_law(data),
    )
    position, jitter = _position_noise(data, quiet, physical, chain)
    chain = replace(chain, position=position, jitter=jitter)
    if data.axis.axis.states:  # friction that remembers has no rows
        return chain
    # Near turns of either the equation has errors that are no noise of a given colour.
    moving = data.turning_as(quiet.record.position, also=True)
    rows = _RowBands.of(moving, quiet)
    if rows is None:
        raise EstimationError("its rows are too few to tell their noise.", code="too-short")
    by_filter = _residuals(quiet, physical, moving)
    left = _residuals(data, physical, moving) - by_filter
    found = rows.power(left)
    chain = replace(
        chain, control=_control_noise(data, rows.without_basis(left), moving, rows, chain)
    )

    def power_of_twins(noise: Chain) -> Array:
        """Of each, (m, b)."""
        twins = twins_of(data, physical, noise, _TWINS)
        made = [rows.power(_residuals(each, physical, moving) - by_filter) for each in twins]
        return np.reshape(made, (-1, len(found))) if made else np.zeros((1, len(found)))

    steps = power_of_twins(chain)
    known = steps.mean(axis=0)
    if rows.counts @ found < _LEAST_FOUND * (rows.counts @ known):
        raise EstimationError(
            "its position has noise at the highest frequencies that is not white: there is less "
            "in its rows.",
            code="noise",
        )
    if np.linalg.norm(left) <= _ROUNDING * np.linalg.norm(moving.reduce(moving.signals.force)):
        return chain  # rounding alone
    times = [t for t in CORRELATION_TIMES if _LONGEST * t <= data.period * len(data)]
    units = rows.power_of_disturbances(moving, times)
    beside = np.vstack([known, steps]) if chain.position_step else known[None]
    every = likeliest_variances(found, units, beside, rows.counts)
    # A little that is not there biases estimates, and would keep twins from hunting alike.
    seen = found, units, beside, _independent(rows.counts, steps)
    surely = _likelihood(every, *seen) > _likelihood(0 * every, *seen) + _SURELY
    every = every * surely[:, None]

    def disturbances(variances: Array) -> Autoregressions:
        return _autoregressions(times, variances, units, found)

    mean = every.mean(axis=0)
    if chain.position_step and (listed := disturbances(mean)):
        # It hunts the more, the more it is disturbed: not in proportion, so that of what was found
        # it takes less to leave the same in the rows.
        whole = power_of_twins(replace(chain, disturbances=listed)).mean(axis=0)
        added = np.maximum(whole - known, 0.0)[None]
        if added.any():
            shares = likeliest_variances(found, added, beside, rows.counts)
            every = shares * mean * every.any(axis=1, keepdims=True)
    told, *others = map(disturbances, every)
    return replace(chain, disturbances=told, drawn=tuple(others))


def _control_noise(
    data: FilteredRecord, left: Array, moving: FilteredRecord, rows: "_RowBands", chain: Chain
) -> Autoregressions:
    """What the recorded control has beside the one that acts, as the law gives that.

    It is in the rows, as what is wrong about the law is not: their share of what the law leaves.

    Parameters
    ----------
    data : FilteredRecord
    left : (n,) array
        What neither the inverse model nor the basis of the rows explains.
    moving : FilteredRecord
        The record without rows near turns.
    rows : _RowBands
        Its rows.
    chain : Chain
        With the rest of what is measured.
    """
    record, law = data.record, law_of(data.axis)
    exact = chain.is_measured_by_law and not (law.takes_velocity or law.continuous)
    clocks = [two_clocks(data.axis, record, span) for span in record.spans]
    if record.control is None or record.force is not None or not exact or any(clocks):
        return ()
    segments = [law_residual(data.axis, record, span) for span in record.spans]
    residual, counted = map(np.concatenate, zip(*segments, strict=True))
    if np.linalg.norm(residual) <= _ROUNDING * np.linalg.norm(record.control):
        return ()
    in_rows = rows.without_basis(moving.reduce(moving.force_by(residual)))
    share = float(np.clip(left @ in_rows / (in_rows @ in_rows), 0.0, 1.0))
    times = [t for t in CORRELATION_TIMES if _LONGEST * t <= record.period * len(residual)]
    bands = np.unique(np.geomspace(1.0, len(residual) / 2, _BANDS + 1).astype(np.int64))
    counts = np.diff(bands).astype(float)

    def by_band(values: Array) -> Array:
        return np.asarray(np.add.reduceat(values, bands)[:-1] / counts)

    found = by_band(np.abs(np.fft.rfft(residual)) ** 2 / np.count_nonzero(counted))
    units = np.array([by_band(spectrum(time / record.period, len(residual))) for time in times])
    powers = found, units, np.full(len(found), chain.control_step**2 / 12), counts
    variances = likeliest_variances(*powers)
    if _likelihood(variances, *powers) <= _likelihood(0 * variances, *powers) + _SURELY:
        return ()
    return _autoregressions(times, share**2 * variances, units, share**2 * found)


def _autoregressions(
    times: Sequence[float], variances: Array, units: Array, found: Array
) -> Autoregressions:
    """Those of variances (m,) that make more than a thousandth of the power of a band."""
    there = np.any(variances[:, None] * units > _SMALLEST * found, axis=1)
    sizes = map(float, np.sqrt(variances))
    return tuple((t, sd) for t, sd, is_ in zip(times, sizes, there, strict=True) if is_)


def control_step(record: Record) -> float:
    """What a record's force, or else its control, is rounded to; 0 for none."""
    values = record.control if record.force is None else record.force
    if values is None:
        return 0.0
    return quantisation_step(values, int(MIN_STEP_DIFFERENCES.value))


def likeliest_variances(found: Array, units: Array, known: Array, counts: Array) -> Array:
    """Variances, (..., m), for which powers by band are the likeliest, by Whittle.

    Parameters
    ----------
    found : (b,) array
        Mean power by band.
    units : (m, b) array
        What is expected of each variance of 1.
    known : (..., b) array
        What is there besides.
    counts : (b,) array
        Independent powers of each band, of two degrees of freedom each.

    Notes
    -----
    By multiplicative updates, which keep what is not negative so.
    """
    if not (found.any() and len(units)):
        return np.zeros((*known.shape[:-1], len(units)))
    variances: Array = found.mean() / units.mean(axis=1) / len(units)
    for _ in range(_ROUNDS):
        expected = _expected(variances, found, units, known)
        up, down = counts * found / expected**2, counts / expected
        variances = variances * (up @ units.T) / (down @ units.T)
    return variances


def _expected(variances: Array, found: Array, units: Array, known: Array) -> Array:
    return np.asarray(variances @ units + known + _LEAST * found.max(), dtype=float)


def _likelihood(variances: Array, found: Array, units: Array, known: Array, counts: Array) -> Array:
    """Logarithm of Whittle's likelihood, (...)."""
    expected = _expected(variances, found, units, known)
    return np.asarray(-(np.log(expected) + found / expected) @ counts)


def _position_noise(
    data: FilteredRecord, quiet: FilteredRecord, physical: Array, chain: Chain
) -> tuple[float, float]:
    """Deviations of white noise of the position, and of the instants of sampling.

    The second differences of the first are alike everywhere, those of the second in proportion to
    the speed: by classes of speed, beyond what steps of the encoder make.
    """
    if data.record.integrated:
        return 0.0, 0.0
    speed = np.abs(data.motion[1])
    inner = np.concatenate([np.arange(a + 1, b - 1) for a, b in data.record.spans])
    order = inner[np.argsort(speed[inner], kind="stable")]
    classes = [each for each in np.array_split(order, _CLASSES) if len(each)]

    def power(other: FilteredRecord) -> Array:
        apart = other.record.position - quiet.record.position
        second = np.zeros(len(apart))
        second[1:-1] = np.diff(apart, 2) ** 2
        return np.array([second[each].mean() for each in classes])

    several = _TWINS if chain.position_step else 0
    steps = [power(each) for each in twins_of(data, physical, chain, several)]
    known = np.mean(steps, axis=0) if steps else np.zeros(len(classes))
    squares = np.array([np.mean(speed[each] ** 2) for each in classes])
    units = 6 * np.stack([np.ones(len(classes)), squares])  # 1, -2, 1
    counts = np.array([len(each) for each in classes]) / _CORRELATED
    if steps:
        counts = _independent(counts, np.array(steps))
    seen = power(data), units, known, counts
    both = likeliest_variances(*seen)
    alone = likeliest_variances(seen[0], units[:1], known, counts)
    without = np.append(alone, 0.0)
    # A little jitter is mostly noise in how it is measured, and biases estimates.
    likelier = _likelihood(both, *seen) > _likelihood(without, *seen) + _SURELY
    position, jitter = map(float, np.sqrt(both if likelier else without))
    rounding = _ROUNDING * float(np.abs(data.record.position).max())
    fast = float(speed.max())
    # Noise dithers the steps, and the law feeds it back: not in proportion, as above.
    noisy = replace(chain, position=position, jitter=jitter)
    if made := [power(each) for each in twins_of(data, physical, noisy, _TWINS)]:
        more, found = (float(counts @ (each - known)) for each in (np.mean(made, axis=0), seen[0]))
        share = math.sqrt(max(found, 0.0) / more) if more > 0 else 1.0
        position, jitter = share * position, share * jitter
    return position * (position > rounding), jitter * (jitter * fast > rounding)


def _independent(counts: Array, steps: Array) -> Array:
    """How many independent powers twins with an encoder's steps, (m, b), have by band, (b,).

    Their errors come again with the motion; one twin alone, without noise, does not tell.
    """
    if len(steps) == 1:
        return counts
    known = steps.mean(axis=0)
    scatter = np.var(steps, axis=0, ddof=1)
    told = np.divide(known**2, scatter, out=np.full_like(known, np.inf), where=scatter > 0)
    return np.asarray(np.minimum(counts, told))


def _white(record: Record, quiet: Record, role: str) -> float | None:
    """Deviation of white noise of a role, by its second differences; None if not measured."""
    if getattr(record, role) is None:
        return None
    apart = getattr(record, role) - getattr(quiet, role)
    second = np.concatenate([np.diff(apart[a:b], 2) for a, b in record.spans])
    return float(np.sqrt(np.mean(second**2) / 6)) if len(second) else 0.0


def _residuals(record: FilteredRecord, physical: Array, data: FilteredRecord) -> Array:
    """What the inverse model leaves of a record, in the rows of another of its kind, (n,)."""
    form = InverseForm(data.axis).at(physical)
    rows = form.equations(record.signals).reduced(data)
    return np.asarray(rows.left - rows.intercept - rows.regressor @ form.regressed(physical))


@dataclass(frozen=True, kw_only=True)
class _RowBands:
    """A record's rows in time, without what columns explain of them.

    Attributes
    ----------
    places : (n,) array of int
        Of the rows, among those that no rest and no gap leaves out.
    count : int
        Of these.
    basis : (n, r) array
        Orthonormal, of the columns.
    bands : (b + 1,) array of int
        First frequency of each band, and the one after the last.
    counts : (b,) array
        Frequencies of each, less what the columns take.
    """

    places: NDArray[np.int64]
    count: int
    basis: Array
    bands: NDArray[np.int64]
    counts: Array

    @classmethod
    def of(cls, data: FilteredRecord, quiet: FilteredRecord) -> "_RowBands | None":
        """Of a record, with the columns of its loop; None of too few rows for a band."""
        every = data.prefilter.decimate
        numbers = np.round(data.sampling.rows).astype(np.int64)
        places = (numbers - numbers[:1]) // every
        count = int(places.max(initial=0)) + 1
        if _HIGHEST * count / 2 < _BANDS:
            return None
        bands = np.unique(np.geomspace(1.0, _HIGHEST * count / 2, _BANDS + 1).astype(np.int64))
        rows = cls(
            places=places,
            count=count,
            basis=_basis(data, quiet),
            bands=bands,
            counts=np.ones(len(bands) - 1),
        )
        taken = rows._periodogram(rows.basis).sum(axis=1) / len(places)
        taken = np.minimum(taken, _MOST_LEVERAGE)
        return replace(rows, counts=rows._by_band(1 - taken))

    def power(self, rows: Array) -> Array:
        """Mean power by band of rows, (n,) or of several (n, m), (b,)."""
        rows = rows.reshape(len(rows), -1)
        power = self._periodogram(self.without_basis(rows)).mean(axis=1) / len(rows)
        return self._by_band(power) / self.counts

    def without_basis(self, rows: Array) -> Array:
        """What the columns do not explain of rows, (n,) or (n, m)."""
        return np.asarray(rows - self.basis @ (self.basis.T @ rows))

    def _by_band(self, values: Array) -> Array:
        """Sums of values by frequency."""
        return np.asarray(np.add.reduceat(values, self.bands)[:-1], dtype=float)

    def _periodogram(self, rows: Array) -> Array:
        """Of columns (n, m), (count // 2 + 1, m)."""
        placed = np.zeros((self.count, rows.shape[1]))
        placed[self.places] = rows
        return np.asarray(np.abs(np.fft.rfft(placed, axis=0)) ** 2)

    def power_of_disturbances(self, data: FilteredRecord, times: Sequence[float]) -> Array:
        """Power by band of disturbances of deviation 1 and correlation times, (m, b).

        White ones pass the record's filter; others have their colour put on the rows.
        """
        whole, rng = data.without(()), np.random.default_rng(0)
        places = np.round(whole.sampling.rows).astype(np.int64) - round(
            float(data.sampling.rows[0])
        )
        places //= data.prefilter.decimate
        white = np.zeros((int(places[-1] - places[0]) + 1, _DRAWS))
        for draw in range(_DRAWS):
            noise = rng.standard_normal(len(data))
            white[places - places[0], draw] = whole.reduce(whole.force_by(noise))
        here = self.places - places[0]
        weights = data.sampling.weights / whole.sampling.weights.max()
        transformed = np.fft.rfft(white, axis=0)
        found = []
        for time in times:
            colour = spectrum(time / data.period, len(white), data.prefilter.decimate)
            rows = np.fft.irfft(transformed * np.sqrt(colour)[:, None], len(white), axis=0)
            found.append(self.power(weights[:, None] * rows[here]))
        return np.array(found)


def _basis(data: FilteredRecord, quiet: FilteredRecord) -> Array:
    """Orthonormal columns of the model and what it may lack, with what changes each, (n, r)."""
    signals = quiet.signals
    time = np.linspace(-1.0, 1.0, len(data))
    speed = np.abs(signals.velocity)
    lacking = [np.ones_like(time), signals.position, signals.velocity, signals.direction]
    lacking += [np.abs(signals.force), np.gradient(signals.force)]
    declared = InverseForm(data.axis).equations(signals).regressor
    columns = np.column_stack([declared, *lacking])
    changing = [np.ones_like(time), time, np.sign(time), signals.position, speed, signals.direction]
    most = len(data.sampling.rows) // (_ROWS_A_COLUMN * columns.shape[1])
    changing = changing[: max(most, 1)]
    every = data.reduce(np.hstack([columns * each[:, None] for each in changing]))
    norms = np.linalg.norm(every, axis=0)
    basis, sizes, _ = np.linalg.svd(every[:, norms > 0] / norms[norms > 0], full_matrices=False)
    return np.asarray(basis[:, sizes > _RANK * sizes[0]])
