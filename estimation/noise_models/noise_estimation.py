"""The noise of a record, measured in what it is beside its loop at an estimate."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from axisid.estimation.law_replay import law_residual, two_clocks
from axisid.estimation.records import Record, quantisation_step, sensor_steps
from axisid.estimation.regression import InverseForm, is_measured_by_law
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.simulation import Simulation, law_of
from axisid.estimation.thresholds import MIN_STEP_DIFFERENCES
from axisid.support.arrays import Array, ComplexArray, IntArray
from axisid.support.errors import EstimationError

from .noise_model import CORRELATION_TIMES, Autoregressions, Chain, MeasuredChain, spectrum
from .twins import noise_free_record, twins_of

_DRAWS = 16  # of a disturbance, through filter and projection
_BANDS = 22  # at most; of few rows a frequency is a band of its own
_FEWEST_FREQUENCIES = 8  # of the rows, which tell their noise
_MOST_LEVERAGE = 0.8  # of a frequency: where columns take nearly all, nothing is told
_RANK = 1e-6
_ROWS_A_COLUMN = 4
_HIGHEST = 0.6  # of the frequencies of rows: what the filter leaves as it is
_TWINS = 8  # that have position noise and steps alone
_CLASSES = 8  # of speed
#: Squares of second differences for one power: of one degree of freedom, and of their neighbours'.
_CORRELATED = 2 * (1 + 2 * ((4 / 6) ** 2 + (1 / 6) ** 2))
_SURELY = 6.0  # of a logarithm of likelihood: by chance one in 2000
_REFINEMENTS = 2  # of forces beside what twins with them hunt
_MOST_AT_ONCE = 16.0  # times less variance, whose geometric half is taken
_ROUNDS = 400  # of the likelihood's multiplicative updates
_LEAST = 1e-12  # of the largest power: rounding
_SMALLEST = 1e-3  # of a band's power
_ROUNDING = 1e-12  # of the position, or the force
_LEAST_POWER = 0.1  # of what white noise of the position would make in the rows
_LONGEST = 8.0  # times that a correlation time has to fit into a record


def measured_noise(
    data: FilteredRecord, physical: Array, loops: Sequence[Simulation]
) -> MeasuredChain:
    """Measure the noise of a record.

    Steps are those of the grids of what was logged. White noise of the position is what its second
    differences have beyond those of the loop, and of twins with the encoder's steps alone, as much
    as leaves the same in twins with both. What acts beside the control is a sum of autoregressions
    of given correlation times, whose variances are the likeliest by Whittle for the rows of the
    inverse model, without all that the model's columns explain when they may change with time,
    place, speed and direction, and without what twins with noise and steps of the position have
    there in common, beside what each of these has of its own: first of the steps alone, then of
    twins that are disturbed as well. None is there that is not surely likelier than nothing, and
    none is told where friction remembers, which has no rows. How a loop hunts over the steps of its
    encoder is an accident of where it begins, so that twins have disturbances that are the
    likeliest beside the power of one such loop or another.

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
        control_step=0.0 if data.axis.drive.quantisation else control_step(data.record),
        is_measured_by_law=is_measured_by_law(data),
    )
    position, jitter = _position_noise(data, quiet, physical, chain)
    chain = replace(chain, position=position, jitter=jitter)
    if data.axis.states:  # friction that remembers has no rows
        return chain
    # Near turns of either the equation has errors that are no noise of a given colour.
    moving = data.turning_as(quiet.record.position, also=True)
    rows = RowSpectrum.of(moving, quiet)
    by_filter = _residuals(quiet, physical, moving)
    residuals = _residuals(data, physical, moving) - by_filter
    times = [t for t in CORRELATION_TIMES if _LONGEST * t <= data.period * len(data)]
    units = rows.power_of_disturbances(moving, times)
    in_control = _control_noise(data, residuals, moving, rows, chain, times, units)
    chain = replace(chain, control=in_control)

    def errors_of(twin: FilteredRecord) -> Array:
        return _residuals(twin, physical, moving) - by_filter

    # What every twin has again is no noise: a loop hunts alike until something disturbs it.
    errors = _of_twins(errors_of, data, physical, chain)
    repeated, count = errors.mean(axis=0), len(errors)

    def power_of(twin: FilteredRecord) -> Array:
        return rows.power(errors_of(twin) - repeated)

    power = rows.power(residuals - repeated)
    # The mean includes each twin, and not the record.
    steps = power_about_another_mean(count) * np.array(
        [rows.power(each - repeated) for each in errors]
    )
    known = steps.mean(axis=0)
    if rows.counts @ rows.power(residuals) < _LEAST_POWER * (rows.counts @ rows.power(errors.T)):
        raise EstimationError(
            "its position has noise at the highest frequencies that is not white: there is less "
            "in its rows.",
            code="noise",
        )
    if np.linalg.norm(residuals) <= _ROUNDING * np.linalg.norm(moving.reduce(moving.signals.force)):
        return chain  # rounding alone
    backgrounds = np.vstack([known, steps]) if chain.position_step else known[None]
    variances = likeliest_variances(power, units, backgrounds, rows.counts)
    # A little that is not there biases estimates, and would keep twins from hunting alike.
    seen = power, units, backgrounds, _independent(rows.counts, steps)
    surely = _likelihood(variances, *seen) > _likelihood(0 * variances, *seen) + _SURELY
    variances = variances * surely[:, None]

    disturbances = partial(_autoregressions, times, units, power)
    # Where something disturbs a loop it hunts otherwise, which is in what was found. Again, beside
    # twins that are disturbed as much, and half the way of each logarithm: the more is found, the
    # more they hunt.
    for _ in range(_REFINEMENTS if chain.position_step else 0):
        mean = variances.mean(axis=0)
        if not (listed := disturbances(mean)):
            break
        disturbed = _of_twins(power_of, data, physical, replace(chain, disturbances=listed))
        if not disturbed.any():  # none can be simulated
            break
        hunting = np.maximum(disturbed.mean(axis=0) - mean @ units, 0.0)
        beside = backgrounds * (hunting / (known + _LEAST * power.max()))
        again = likeliest_variances(power, units, beside, rows.counts)
        variances = np.sqrt(variances * np.maximum(again, variances / _MOST_AT_ONCE))
    likeliest, *others = map(disturbances, variances)
    return replace(chain, disturbances=likeliest, drawn=tuple(others))


def power_about_another_mean(count: int) -> float:
    """Ratio ``(m + 1)/(m - 1)`` of the power about an independent mean to that about the own mean.

    Of m independent series: about the mean of all m each has ``1 - 1/m`` of its variance, and a
    further series has ``1 + 1/m`` about it. One series alone has no power about its own mean.

    Parameters
    ----------
    count : int
        m.
    """
    return (count + 1) / max(count - 1, 1)


def _of_twins(
    figures_of: Callable[[FilteredRecord], Array],
    data: FilteredRecord,
    physical: Array,
    chain: Chain,
) -> Array:
    """Figures (b,) of twins with a chain's noise, (m, b); 0 without, or where none is simulated."""
    figures = [figures_of(twin) for twin in twins_of(data, physical, chain, _TWINS)]
    return np.array(figures) if figures else np.zeros((1, len(figures_of(data))))


def _control_noise(
    data: FilteredRecord,
    residuals: Array,
    moving: FilteredRecord,
    rows: "RowSpectrum",
    chain: Chain,
    times: Sequence[float],
    units: Array,
) -> Autoregressions:
    """Noise that the recorded control has beside the one that acts, which the law gives.

    It is in what the law leaves of the control, and in the rows: of it is what both have in common,
    by band. What is wrong about the law is in the one alone, a force beside the control in the
    other.

    Parameters
    ----------
    data : FilteredRecord
    residuals : (n,) array
        What the inverse model leaves of the rows.
    moving : FilteredRecord
        The record without rows near turns.
    rows : RowSpectrum
        Its rows.
    chain : Chain
        With the rest of what is measured.
    times : sequence of float
        Correlation times that are looked for.
    units : (m, b) array
        Power by band of noise of each time and of deviation 1.
    """
    record, law = data.record, law_of(data.axis)
    clocks = [two_clocks(data.axis, record, span) for span in record.spans]
    is_logged = record.reference is not None and not (record.integrated or any(clocks))
    reads_log = chain.is_measured_by_law and not (law.takes_velocity or law.continuous)
    if record.control is None or record.force is not None or not (is_logged and reads_log):
        return ()
    noise = np.concatenate([law_residual(data.axis, record, span)[0] for span in record.spans])
    if np.linalg.norm(noise) <= _ROUNDING * np.linalg.norm(record.control):
        return ()
    in_rows = moving.reduce(moving.force_by(noise))
    power = np.clip(rows.power(residuals, in_rows), 0.0, rows.power(in_rows))
    steps = units[0] * chain.control_step**2 / 12
    variances = likeliest_variances(power, units, steps, rows.counts)
    # Without it the rows are surely likelier.
    before, after = rows.power(residuals), rows.power(residuals - in_rows)
    gained = float(rows.counts @ np.log(before / (after + _LEAST * before.max())))
    return _autoregressions(times, units, power, variances) if gained > _SURELY else ()


def _autoregressions(
    times: Sequence[float], units: Array, power: Array, variances: Array
) -> Autoregressions:
    """Those of variances (m,) that make more than a thousandth of the power of a band."""
    counts = np.any(variances[:, None] * units > _SMALLEST * power, axis=1)
    return tuple(
        (time, float(sd))
        for time, sd, counted in zip(times, np.sqrt(variances), counts, strict=True)
        if counted
    )


def control_step(record: Record) -> float:
    """What a record's force, or else its control, is rounded to; 0 for none."""
    values = record.control if record.force is None else record.force
    if values is None:
        return 0.0
    return quantisation_step(values, int(MIN_STEP_DIFFERENCES.value))


def likeliest_variances(power: Array, units: Array, known: Array, counts: Array) -> Array:
    """Variances, (..., m), for which powers by band are the likeliest, by Whittle.

    Parameters
    ----------
    power : (b,) array
        Mean by band.
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
    if not (power.any() and len(units)):
        return np.zeros((*known.shape[:-1], len(units)))
    variances: Array = power.mean() / units.mean(axis=1) / len(units)
    counted, least = counts * power, _LEAST * power.max()
    for _ in range(_ROUNDS):
        expected = variances @ units + known + least
        up, down = counted / expected**2, counts / expected
        variances = variances * (up @ units.T) / (down @ units.T)
    return variances


def _likelihood(variances: Array, power: Array, units: Array, known: Array, counts: Array) -> Array:
    """Logarithm of Whittle's likelihood, (...)."""
    expected = variances @ units + known + _LEAST * power.max()
    return np.asarray(-(np.log(expected) + power / expected) @ counts)


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

    def power_of(other: FilteredRecord) -> Array:
        second = np.diff(other.record.position - quiet.record.position, 2) ** 2
        return np.array([second[each - 1].mean() for each in classes])

    # Without steps of the encoder nothing is measured of the position but its noise.
    steps = _of_twins(power_of, data, physical, chain if chain.position_step else Chain())
    power, known = power_of(data), steps.mean(axis=0)
    squares = np.array([np.mean(speed[each] ** 2) for each in classes])
    units = 6 * np.stack([np.ones(len(classes)), squares])  # 1, -2, 1
    counts = _independent(np.array([*map(len, classes)]) / _CORRELATED, steps)
    seen = power, units, known, counts
    both = likeliest_variances(*seen)
    without = np.append(likeliest_variances(power, units[:1], known, counts), 0.0)
    # A little jitter is mostly noise in how it is measured, and biases estimates.
    likelier = _likelihood(both, *seen) > _likelihood(without, *seen) + _SURELY
    position, jitter = map(float, np.sqrt(both if likelier else without))
    rounding = _ROUNDING * float(np.abs(data.record.position).max())
    # Noise dithers the steps, and the law feeds it back: not in proportion, as above.
    noisy = replace(chain, position=position, jitter=jitter)
    of_noisy = _of_twins(power_of, data, physical, noisy).mean(axis=0)
    added, measured = (float(counts @ (each - known)) for each in (of_noisy, power))
    share = float(np.sqrt(max(measured, 0.0) / added)) if added > 0 else 1.0
    position, jitter = share * position, share * jitter
    return position * (position > rounding), jitter * (jitter * float(speed.max()) > rounding)


def _independent(counts: Array, steps: Array) -> Array:
    """How many independent powers twins with an encoder's steps, (m, b), have by band, (b,).

    Their errors come again with the motion; one twin alone, without noise, does not tell.
    """
    if len(steps) == 1:
        return counts
    mean, variance = steps.mean(axis=0), steps.var(axis=0, ddof=1)
    independent = np.divide(mean**2, variance, out=np.full_like(mean, np.inf), where=variance > 0)
    return np.asarray(np.minimum(counts, independent))


def _white(record: Record, quiet: Record, role: str) -> float | None:
    """Deviation of white noise of a role, by its second differences; None if not measured."""
    if getattr(record, role) is None:
        return None
    noise = getattr(record, role) - getattr(quiet, role)
    second = np.concatenate([np.diff(noise[a:b], 2) for a, b in record.spans])
    return float(np.sqrt(np.mean(second**2) / 6)) if len(second) else 0.0


def _residuals(record: FilteredRecord, physical: Array, data: FilteredRecord) -> Array:
    """What the inverse model leaves of a record, in the rows of another of its kind, (n,)."""
    form = InverseForm(data.axis).at(physical)
    rows = form.equations(record.signals).reduced(data)
    return rows.residuals(form.regressed(physical))


@dataclass(frozen=True, kw_only=True)
class RowSpectrum:
    """A record's rows in time, without what columns explain of them.

    Attributes
    ----------
    places : (n,) array of int
        Of the rows, among those that no rest and no gap leaves out.
    basis : (n, r) array
        Orthonormal, of the columns.
    bands : (b + 1,) array of int
        First frequency of each band, and the one after the last.
    counts : (b,) array
        Frequencies of each, less what the columns take.
    """

    places: IntArray
    basis: Array
    bands: IntArray
    counts: Array

    @classmethod
    def of(cls, data: FilteredRecord, quiet: FilteredRecord) -> "RowSpectrum":
        """Of a record, with the columns of its loop.

        Raises
        ------
        EstimationError
            There are too few rows.
        """
        numbers = np.round(data.sampling.rows).astype(np.int64)
        places = (numbers - numbers[:1]) // data.prefilter.decimate
        count = int(places.max(initial=0)) + 1
        highest = _HIGHEST * count / 2
        if highest < _FEWEST_FREQUENCIES:
            raise EstimationError(
                f"its {len(places)} rows in motion are too few to tell their noise; record a "
                "longer motion.",
                code="too-short",
            )
        bands = np.unique(np.geomspace(1.0, highest, _BANDS + 1).astype(np.int64))
        rows = cls(
            places=places,
            basis=_basis(data, quiet),
            bands=bands,
            counts=np.ones(len(bands) - 1),
        )
        return rows.counted()

    def counted(self) -> "RowSpectrum":
        """The same with the frequencies of each band counted, less what the columns take."""
        taken = np.sum(np.abs(self._transform(self.basis)) ** 2, axis=1) / len(self.places)
        return replace(self, counts=self._by_band(1 - np.minimum(taken, _MOST_LEVERAGE)))

    def power(self, rows: Array, others: Array | None = None) -> Array:
        """Mean power by band of rows, (n,) or of several (n, m), (b,); or what others share of it.

        Of what the columns do not explain of either.
        """
        every = (rows,) if others is None else (rows, others)
        lacking = [self._transform(each - self.basis @ (self.basis.T @ each)) for each in every]
        power = np.real(np.conj(lacking[0]) * lacking[-1]).mean(axis=1) / len(rows)
        return self._by_band(power) / self.counts

    def _by_band(self, values: Array) -> Array:
        """Sums of values by frequency."""
        return np.asarray(np.add.reduceat(values, self.bands)[:-1], dtype=float)

    def _transform(self, rows: Array) -> ComplexArray:
        """Of rows (n,) or columns (n, m), by frequency, (f, m)."""
        placed = np.zeros((self.places[-1] + 1, *rows.shape[1:]))
        placed[self.places] = rows
        return np.asarray(np.fft.rfft(placed.reshape(len(placed), -1), axis=0))

    def power_of_disturbances(self, data: FilteredRecord, times: Sequence[float]) -> Array:
        """Power by band of disturbances of deviation 1 and correlation times, (m, b).

        White ones pass the record's filter; others have their colour put on the rows.
        """
        whole, rng = data.without(()), np.random.default_rng(0)
        first, every = round(float(data.sampling.rows[0])), data.prefilter.decimate
        places = (np.round(whole.sampling.rows).astype(np.int64) - first) // every
        white = np.zeros((int(places[-1] - places[0]) + 1, _DRAWS))
        for draw in range(_DRAWS):
            noise = rng.standard_normal(len(data))
            white[places - places[0], draw] = whole.reduce(whole.force_by(noise))
        here = self.places - places[0]
        weights = data.sampling.weights / whole.sampling.weights.max()
        transformed = np.fft.rfft(white, axis=0)
        powers = []
        for time in times:
            colour = spectrum(time / data.period, len(white), every)
            rows = np.fft.irfft(transformed * np.sqrt(colour)[:, None], len(white), axis=0)
            powers.append(self.power(weights[:, None] * rows[here]))
        return np.array(powers)


def _basis(data: FilteredRecord, quiet: FilteredRecord) -> Array:
    """Orthonormal columns of the model and what it may lack, with what changes each, (n, r)."""
    signals = quiet.signals
    time = np.linspace(-1.0, 1.0, len(data))
    ones, speed = np.ones_like(time), np.abs(signals.velocity)
    lacking = [ones, signals.position, signals.velocity, signals.direction]
    forces = np.abs(signals.force), np.gradient(signals.force)
    declared = InverseForm(data.axis).equations(signals).regressor
    columns = np.column_stack([declared, *lacking, *forces])
    changing = [ones, time, np.sign(time), signals.position, speed, signals.direction]
    most = max(len(data.sampling.rows) // (_ROWS_A_COLUMN * columns.shape[1]), 1)
    # One after the other: all samples of all columns are much more than their rows.
    every = np.hstack([data.reduce(columns * each[:, None]) for each in changing[:most]])
    norms = np.linalg.norm(every, axis=0)
    basis, sizes, _ = np.linalg.svd(every[:, norms > 0] / norms[norms > 0], full_matrices=False)
    return np.asarray(basis[:, sizes > _RANK * sizes[0]])
