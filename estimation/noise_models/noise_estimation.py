"""Estimate the noise of a record: sensor noise, noise of the logged control, and disturbances."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

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

_DISTURBANCE_DRAWS = 16  # white disturbances, passed through filter and projection for their power
_MAX_BANDS = 22  # frequency bands; with few rows each frequency is a band
_MIN_FREQUENCIES = 8  # fewest frequencies of rows whose noise is estimated
_MAX_LEVERAGE = 0.8  # largest leverage of the basis columns at a frequency that is counted
_MIN_SINGULAR_VALUE_RATIO = 1e-6  # of the basis, relative to the largest singular value
_MIN_ROWS_PER_COLUMN = 4
_MAX_FREQUENCY = 0.6  # of the Nyquist frequency of the rows: the pass band of the filters
_REPLICAS = 8  # simulated replicas with position noise and encoder steps
_SPEED_CLASSES = 8
#: Squared second differences per independent power of two degrees of freedom: 2 for their one
#: degree of freedom, times the sum of the squared autocorrelations 1, -4/6, 1/6 of second
#: differences.
_SQUARES_PER_POWER = 2 * (1 + 2 * ((4 / 6) ** 2 + (1 / 6) ** 2))
_MIN_LIKELIHOOD_GAIN = 6.0  # of the log-likelihood; exceeded by chance in one of 2000 cases
_REFINEMENTS = 2  # corrections of the disturbances for the limit cycle of disturbed replicas
_MAX_REDUCTION = 16.0  # of a variance in one refinement, of which the geometric mean is taken
_LIKELIHOOD_STEPS = 400  # multiplicative updates
_RELATIVE_FLOOR = 1e-12  # relative to the largest power: rounding
_MIN_BAND_SHARE = 1e-3  # of the power of a band, below which a disturbance is ignored
_ROUNDING = 1e-12  # relative to the position, the control or the force
_MIN_POWER_RATIO = 0.1  # of the power that white position noise would cause in the rows
_MIN_RECORD_LENGTH = 8.0  # correlation times that a record must cover


def measured_noise(
    data: FilteredRecord, physical: Array, loops: Sequence[Simulation]
) -> MeasuredChain:
    """Estimate the noise of a record at an estimate of its parameters.

    The five steps are: sensor noise and quantisation (`_sensor_noise`); noise of the logged control
    (`_control_noise`); power of the residual about its systematic part (`_power_about_replicas`);
    variances of the disturbances by Whittle's likelihood (`_significant_variances`); correction for
    the limit cycle of a disturbed loop (`_corrected_for_limit_cycle`). Friction with internal state
    has no rows of measured signals, so that such a record has sensor noise only.

    Parameters
    ----------
    data : FilteredRecord
    physical : (p,) array
        Parameters of this record's axis.
    loops : sequence of Simulation
        Loops of the record, simulated with these parameters; one for each segment.

    Returns
    -------
    MeasuredChain

    Raises
    ------
    EstimationError
        The record has too few rows in motion, or position noise that is not white.
    """
    quiet = noise_free_record(data, loops)
    chain = _sensor_noise(data, quiet, physical)
    if data.axis.states:
        return chain
    rows = _InverseModelRows.of(data, quiet, physical)
    residuals = rows.residuals(data)
    chain = replace(chain, control=_control_noise(data, residuals, rows, chain))
    powers = _power_about_replicas(data, residuals, rows, chain)
    force = rows.data.reduce(rows.data.signals.force)
    if np.linalg.norm(residuals) <= _ROUNDING * np.linalg.norm(force):
        return chain
    variances = _significant_variances(powers, rows)
    variances = _corrected_for_limit_cycle(variances, powers, data, rows, chain)
    # The first background is the mean of the replicas; the others give alternative estimates.
    likeliest, *alternatives = [
        _autoregressions(rows.times, rows.unit_power, powers.power, each) for each in variances
    ]
    return replace(chain, disturbances=likeliest, drawn=tuple(alternatives))


def _sensor_noise(data: FilteredRecord, quiet: FilteredRecord, physical: Array) -> MeasuredChain:
    """Return the quantisation steps and white sensor noise of a record, from second differences.

    A step is that of the grid of the logged values. A signal minus the noise-free signal has second
    differences ``d_t = e_(t-1) - 2 e_t + e_(t+1)``; white noise of standard deviation sigma gives
    them the mean square ``E d^2 = 6 sigma^2``.

    Parameters
    ----------
    data : FilteredRecord
    quiet : FilteredRecord
        The noise-free record from the simulated loops.
    physical : (p,) array
        Parameters of this record's axis.
    """
    position_step, velocity_step = sensor_steps(data.axis, data.record)
    velocity: float | None = 0.0
    if not velocity_step:
        velocity = _white_noise_level(data.record, quiet.record, "velocity")
    step_of_control = 0.0
    if not data.axis.drive.quantisation:
        step_of_control = control_step(data.record)
    chain = MeasuredChain(
        position_step=position_step,
        anywhere=position_step > 0,
        velocity_step=velocity_step,
        velocity=velocity,
        acceleration=_white_noise_level(data.record, quiet.record, "acceleration"),
        control_step=step_of_control,
        is_measured_by_law=is_measured_by_law(data),
    )
    position, jitter = _position_noise(data, quiet, physical, chain)
    return replace(chain, position=position, jitter=jitter)


@dataclass(frozen=True, kw_only=True)
class _InverseModelRows:
    """Rows of the inverse model at an estimate, from whose residuals disturbances are estimated.

    Attributes
    ----------
    data : FilteredRecord
        The record without samples near velocity reversals of record or simulation, where the
        residual is not noise of a fixed spectrum.
    physical : (p,) array
        Parameters of this record's axis.
    spectrum : RowSpectrum
        Power spectrum of the rows by frequency band.
    filter_residuals : (n,) array
        Residuals of the noise-free record, which are due to the filter alone.
    times : tuple of float
        Those of `CORRELATION_TIMES`, s, of which the record covers 8 or more.
    unit_power : (m, b) array
        Power by band of a disturbance of each correlation time and standard deviation 1.
    """

    data: FilteredRecord
    physical: Array
    spectrum: "RowSpectrum"
    filter_residuals: Array
    times: tuple[float, ...]
    unit_power: Array

    @classmethod
    def of(
        cls, data: FilteredRecord, quiet: FilteredRecord, physical: Array
    ) -> "_InverseModelRows":
        """Return the rows of a record.

        Raises
        ------
        EstimationError
            There are too few rows.
        """
        # Without samples near reversals of record or simulation, unless the prefilter keeps them.
        moving = data.turning_as(quiet.record.position, also=True)
        row_spectrum = RowSpectrum.of(moving, quiet)
        duration = data.period * len(data)
        times = tuple(t for t in CORRELATION_TIMES if _MIN_RECORD_LENGTH * t <= duration)
        return cls(
            data=moving,
            physical=physical,
            spectrum=row_spectrum,
            filter_residuals=_residuals(quiet, physical, moving),
            times=times,
            unit_power=row_spectrum.power_of_disturbances(moving, times),
        )

    def residuals(self, record: FilteredRecord) -> Array:
        """Return the residuals of a record or replica minus `filter_residuals`, (n,)."""
        return _residuals(record, self.physical, self.data) - self.filter_residuals


@dataclass(frozen=True, kw_only=True)
class _BandPowers:
    """Power by band of the record's residual and of the residuals of simulated replicas.

    All powers are about the mean residual of the replicas, which is systematic.

    Attributes
    ----------
    power : (b,) array
        Power of the record's residual.
    known : (b,) array
        Mean power of the replicas.
    backgrounds : (1 + m, b) array
        Power that is not due to disturbances, by which their variances are estimated: `known`, then
        the power of each of m replicas. Without encoder steps, `known` alone: (1, b).
    counts : (b,) array
        Independent powers by band, of two degrees of freedom each.
    replicas : (m, b) array
        Power of each replica.
    repeated : (n,) array
        Mean residual of the replicas: the systematic part.
    """

    power: Array
    known: Array
    backgrounds: Array
    counts: Array
    replicas: Array
    repeated: Array


def _power_about_replicas(
    data: FilteredRecord, residuals: Array, rows: _InverseModelRows, chain: Chain
) -> _BandPowers:
    """Return the power by band of the residual about the mean residual of simulated replicas.

    Replicas have the position noise and encoder steps of the chain but no disturbance. Their mean
    residual is systematic: an undisturbed loop repeats its limit cycle over the encoder steps. With
    the discrete Fourier transform F of rows and the set B of the frequencies of a band,

        ``P_B = sum_(f in B) |F(r - mean r*)_f|^2 / (n n_B)``.

    The mean of m replicas includes each replica and excludes the record, so that the power of a
    replica is multiplied by ``(m + 1)/(m - 1)``.

    Raises
    ------
    EstimationError
        The record has less than a tenth of the power that white position noise would cause.
    """
    row_spectrum = rows.spectrum
    errors = _replica_statistics(rows.residuals, data, rows.physical, chain)
    repeated = errors.mean(axis=0)
    power = row_spectrum.power(residuals - repeated)
    replicas = power_about_another_mean(len(errors)) * np.array(
        [row_spectrum.power(each - repeated) for each in errors]
    )
    known = replicas.mean(axis=0)
    counts = row_spectrum.counts
    of_record, of_replicas = row_spectrum.power(residuals), row_spectrum.power(errors.T)
    if counts @ of_record < _MIN_POWER_RATIO * (counts @ of_replicas):
        raise EstimationError(
            "the position noise is not white. The residual has less than a tenth of the power "
            "that white noise with the same second differences would cause.",
            code="noise",
        )
    backgrounds = known[None]
    if chain.position_step:
        backgrounds = np.vstack([known, replicas])
    return _BandPowers(
        power=power,
        known=known,
        backgrounds=backgrounds,
        counts=counts,
        replicas=replicas,
        repeated=repeated,
    )


def _significant_variances(powers: _BandPowers, rows: _InverseModelRows) -> Array:
    """Return the maximum-likelihood variances of the disturbances where they are significant.

    The variances maximise Whittle's likelihood of `_log_likelihood` for each background. They are
    set to 0 where the log-likelihood gains 6 or less over no disturbance: a disturbance that does
    not exist biases estimates and keeps replicas from their limit cycle.

    Returns
    -------
    (1 + m, k) array
        Variances of k disturbances for each background.
    """
    variances = likeliest_variances(
        powers.power, rows.unit_power, powers.backgrounds, powers.counts
    )
    independent = _independent_powers(powers.counts, powers.replicas)
    observed = powers.power, rows.unit_power, powers.backgrounds, independent
    with_disturbances = _log_likelihood(variances, *observed)
    without = _log_likelihood(0 * variances, *observed)
    is_significant = with_disturbances > without + _MIN_LIKELIHOOD_GAIN
    return np.asarray(variances * is_significant[:, None])


def _corrected_for_limit_cycle(
    variances: Array,
    powers: _BandPowers,
    data: FilteredRecord,
    rows: _InverseModelRows,
    chain: Chain,
) -> Array:
    """Return the variances of disturbances, corrected for the limit cycle of a disturbed loop.

    Without encoder steps there is no limit cycle, and the variances are not changed.

    A disturbance changes the limit cycle over the encoder steps, and the change is part of the
    estimated variances. Replicas with the disturbances have the mean power ``D_b``, of which
    ``H_b = max(D_b - sum_k v_k U_kb, 0)`` is limit cycle. The backgrounds are scaled by
    ``H_b / K_b``, the likelihood is maximised again for variances w, and

        ``v_k <- sqrt(v_k max(w_k, v_k / 16))``,

    half of the change of each logarithm, as larger disturbances leave more limit cycle.

    Returns
    -------
    (1 + m, k) array
        Variances of k disturbances for each background.
    """
    refinements = 0
    if chain.position_step:
        refinements = _REFINEMENTS

    def power_of(replica: FilteredRecord) -> Array:
        """Return the power by band of the residual of a replica with disturbances, (b,).

        The mean residual of the replicas without disturbances is subtracted first. Those replicas
        have the position noise and encoder steps of the chain, see `_power_about_replicas`.
        """
        return rows.spectrum.power(rows.residuals(replica) - powers.repeated)

    for _ in range(refinements):
        mean = variances.mean(axis=0)
        found = _autoregressions(rows.times, rows.unit_power, powers.power, mean)
        if not found:
            break
        disturbed = _replica_statistics(
            power_of, data, rows.physical, replace(chain, disturbances=found)
        )
        if not disturbed.any():  # no replica can be simulated
            break
        limit_cycle = np.maximum(disturbed.mean(axis=0) - mean @ rows.unit_power, 0.0)
        floor = _RELATIVE_FLOOR * powers.power.max()
        backgrounds = powers.backgrounds * (limit_cycle / (powers.known + floor))
        again = likeliest_variances(powers.power, rows.unit_power, backgrounds, powers.counts)
        variances = np.sqrt(variances * np.maximum(again, variances / _MAX_REDUCTION))
    return variances


def power_about_another_mean(count: int) -> float:
    """Return ``(m + 1)/(m - 1)``, the power about an independent mean relative to the own mean.

    Of m independent series, each has ``1 - 1/m`` of its variance about the mean of all m, and a
    further series has ``1 + 1/m``. A single series has no power about its own mean; the factor is
    then 2.

    Parameters
    ----------
    count : int
        m.
    """
    return (count + 1) / max(count - 1, 1)


def _replica_statistics(
    statistic: Callable[[FilteredRecord], Array],
    data: FilteredRecord,
    physical: Array,
    chain: Chain,
) -> Array:
    """Return a statistic of m simulated replicas with the noise of a chain, (m, b).

    `statistic` is a function of a replica that returns b numbers. The result is one row of zeros
    for a chain without noise, or if no replica can be simulated.
    """
    found = [statistic(replica) for replica in twins_of(data, physical, chain, _REPLICAS)]
    if found:
        return np.array(found)
    return np.zeros((1, len(statistic(data))))


def _control_noise(
    data: FilteredRecord, residuals: Array, rows: _InverseModelRows, chain: Chain
) -> Autoregressions:
    """Return the noise that only the log adds to the control, as autoregressions.

    The control error of the law, ``n = u - u_law``, contains the noise and errors of the law. The
    residual r of the inverse model contains the noise, filtered like the force, and disturbances.
    The noise is the part that both have in common, with the cross-power by band

        ``C_B = sum_(f in B) Re(F(r)_f conj(F(n)_f)) / (n n_B)``, limited to ``0 <= C_B <= P_B(n)``.

    Its variances maximise Whittle's likelihood of C next to the rounding noise ``step^2 / 12``. The
    noise is returned where removing it is significant: the log-likelihood gain
    ``sum_B n_B log(P_B(r) / P_B(r - n))`` exceeds 6.

    Parameters
    ----------
    data : FilteredRecord
    residuals : (n,) array
        Residuals of the inverse model.
    rows : _InverseModelRows
        Rows of the inverse model at the estimate.
    chain : Chain
        Sensor noise.

    Returns
    -------
    Autoregressions
        Empty where the noise is not significant, or the record does not allow to replay the law.
    """
    # The law can be replayed if the log has all signals that it read, at the same samples.
    record, law = data.record, law_of(data.axis)
    clocks = [two_clocks(data.axis, record, span) for span in record.spans]
    is_logged = record.reference is not None and not (record.integrated or any(clocks))
    reads_log = chain.is_measured_by_law and not (law.takes_velocity or law.continuous)
    if record.control is None or record.force is not None or not (is_logged and reads_log):
        return ()
    # Variances from the part that the control error and the residual have in common.
    noise = np.concatenate([law_residual(data.axis, record, span)[0] for span in record.spans])
    if np.linalg.norm(noise) <= _ROUNDING * np.linalg.norm(record.control):
        return ()
    row_spectrum = rows.spectrum
    in_rows = rows.data.reduce(rows.data.force_by(noise))
    power = np.clip(row_spectrum.power(residuals, in_rows), 0.0, row_spectrum.power(in_rows))
    steps = rows.unit_power[0] * chain.control_step**2 / 12
    variances = likeliest_variances(power, rows.unit_power, steps, row_spectrum.counts)
    # Log-likelihood that the removal of the noise gains.
    before, after = row_spectrum.power(residuals), row_spectrum.power(residuals - in_rows)
    gain = row_spectrum.counts @ np.log(before / (after + _RELATIVE_FLOOR * before.max()))
    if not float(gain) > _MIN_LIKELIHOOD_GAIN:
        return ()
    return _autoregressions(rows.times, rows.unit_power, power, variances)


def _autoregressions(
    times: Sequence[float], unit_power: Array, power: Array, variances: Array
) -> Autoregressions:
    """Return the correlation time, s, and standard deviation of each visible autoregression.

    An autoregression is visible if it has more than a thousandth of the power of some band.

    Parameters
    ----------
    times : sequence of float
        Correlation times, s.
    unit_power : (m, b) array
        Power by band of an autoregression of each time with standard deviation 1.
    power : (b,) array
        Observed power.
    variances : (m,) array
        Variance of the autoregression of each time.
    """
    is_visible = np.any(variances[:, None] * unit_power > _MIN_BAND_SHARE * power, axis=1)
    return tuple(
        (time, float(sd))
        for time, sd, visible in zip(times, np.sqrt(variances), is_visible, strict=True)
        if visible
    )


def control_step(record: Record) -> float:
    """Return the quantisation step of a record's force, or else of its control; 0 for none."""
    values = record.control if record.force is None else record.force
    if values is None:
        return 0.0
    return quantisation_step(values, int(MIN_STEP_DIFFERENCES.value))


def likeliest_variances(power: Array, units: Array, known: Array, counts: Array) -> Array:
    """Return the variances, (..., m), that maximise Whittle's likelihood of powers by band.

    Parameters
    ----------
    power : (b,) array
        Mean power P_b of each band.
    units : (m, b) array
        Expected power U_kb for each variance of 1.
    known : (..., b) array
        Expected power K_b of everything else.
    counts : (b,) array
        Independent powers n_b of each band, of two degrees of freedom each.

    Notes
    -----
    With the expected power ``S_b = sum_k v_k U_kb + K_b`` the log-likelihood [Whittle1953]_ is
    ``-sum_b n_b (log S_b + P_b / S_b)``. Multiplicative updates keep the variances at 0 or above:
    ``v_k <- v_k (sum_b n_b P_b U_kb / S_b^2) / (sum_b n_b U_kb / S_b)``.
    """
    if not (power.any() and len(units)):
        return np.zeros((*known.shape[:-1], len(units)))
    variances: Array = power.mean() / units.mean(axis=1) / len(units)
    counted, floor = counts * power, _RELATIVE_FLOOR * power.max()
    for _ in range(_LIKELIHOOD_STEPS):
        expected = variances @ units + known + floor
        up, down = counted / expected**2, counts / expected
        variances = variances * (up @ units.T) / (down @ units.T)
    return variances


def _log_likelihood(
    variances: Array, power: Array, units: Array, known: Array, counts: Array
) -> Array:
    """Return Whittle's log-likelihood, (...), without its constant.

    ``-sum_b n_b (log S_b + P_b / S_b)`` with ``S_b = sum_k v_k U_kb + K_b``; see
    `likeliest_variances` for the arguments. [Whittle1953]_
    """
    expected = variances @ units + known + _RELATIVE_FLOOR * power.max()
    return np.asarray(-(np.log(expected) + power / expected) @ counts)


def _position_noise(
    data: FilteredRecord, quiet: FilteredRecord, physical: Array, chain: Chain
) -> tuple[float, float]:
    """Return the standard deviations of white position noise, SI, and of the sampling jitter, s.

    Noise of standard deviation sigma and jitter tau at the speed v give second differences the mean
    square ``6 (sigma^2 + tau^2 v^2)``, in addition to that of the encoder steps of replicas. Both
    variances maximise Whittle's likelihood over classes of speed; jitter is 0 where it gains a
    log-likelihood of 6 or less. Noise dithers the encoder steps and is fed back by the law, so that
    both values are scaled by ``sqrt((P - K)/(R - K))``, with the mean squares P of the record, K of
    replicas without, and R of replicas with this noise.
    """
    if data.record.integrated:
        return 0.0, 0.0
    # Samples in classes of equal size by speed.
    speed = np.abs(data.motion[1])
    inner = np.concatenate([np.arange(a + 1, b - 1) for a, b in data.record.spans])
    order = inner[np.argsort(speed[inner], kind="stable")]
    classes = [each for each in np.array_split(order, _SPEED_CLASSES) if len(each)]

    def power_of(other: FilteredRecord) -> Array:
        """Return the mean squared second difference of a record's noise by class of speed."""
        second = np.diff(other.record.position - quiet.record.position, 2) ** 2
        return np.array([second[each - 1].mean() for each in classes])

    # Without encoder steps, noise of other signals does not reach the measured position.
    without_noise: Chain = Chain()
    if chain.position_step:
        without_noise = chain
    steps = _replica_statistics(power_of, data, physical, without_noise)
    power, known = power_of(data), steps.mean(axis=0)
    squares = np.array([np.mean(speed[each] ** 2) for each in classes])
    units = 6 * np.stack([np.ones(len(classes)), squares])
    lengths = np.array([len(each) for each in classes])
    counts = _independent_powers(lengths / _SQUARES_PER_POWER, steps)
    observed = power, units, known, counts
    with_jitter = likeliest_variances(*observed)
    without_jitter = np.append(likeliest_variances(power, units[:1], known, counts), 0.0)
    # Jitter that is not significant is mostly an error of its estimate, and biases estimates.
    variances = without_jitter
    least = _log_likelihood(without_jitter, *observed) + _MIN_LIKELIHOOD_GAIN
    if _log_likelihood(with_jitter, *observed) > least:
        variances = with_jitter
    position, jitter = map(float, np.sqrt(variances))
    # Scale both by the effect that this noise has in simulated replicas.
    rounding = _ROUNDING * float(np.abs(data.record.position).max())
    noisy = replace(chain, position=position, jitter=jitter)
    of_noisy = _replica_statistics(power_of, data, physical, noisy).mean(axis=0)
    added, measured = float(counts @ (of_noisy - known)), float(counts @ (power - known))
    scale = 1.0
    if added > 0:
        scale = float(np.sqrt(max(measured, 0.0) / added))
    position, jitter = scale * position, scale * jitter
    return position * (position > rounding), jitter * (jitter * float(speed.max()) > rounding)


def _independent_powers(counts: Array, steps: Array) -> Array:
    """Return the number of independent powers by band, (b,), limited by the replicas' scatter.

    A mean of n independent powers of two degrees of freedom has the relative variance ``1/n``. The
    error of encoder steps repeats with the motion, so that the number is
    ``min(n_b, mean^2 / variance)`` of the replicas' power.

    Parameters
    ----------
    counts : (b,) array
        Number of independent powers of white noise, n_b.
    steps : (m, b) array
        Power of m replicas with encoder steps. A single replica shows no variance: `counts` is then
        returned.
    """
    if len(steps) == 1:
        return counts
    mean, variance = steps.mean(axis=0), steps.var(axis=0, ddof=1)
    independent = np.divide(mean**2, variance, out=np.full_like(mean, np.inf), where=variance > 0)
    return np.asarray(np.minimum(counts, independent))


def _white_noise_level(record: Record, quiet: Record, role: str) -> float | None:
    """Return the standard deviation of white noise of a signal; None if it is not measured.

    The root of ``mean d^2 / 6`` of the second differences d of the signal minus the noise-free one,
    within segments; 0 for a record too short for a second difference.
    """
    if getattr(record, role) is None:
        return None
    noise = getattr(record, role) - getattr(quiet, role)
    second = np.concatenate([np.diff(noise[a:b], 2) for a, b in record.spans])
    return float(np.sqrt(np.mean(second**2) / 6)) if len(second) else 0.0


def _residuals(record: FilteredRecord, physical: Array, data: FilteredRecord) -> Array:
    """Return the residuals of the inverse model for a record, in the rows of another record, (n,).

    Parameters
    ----------
    record : FilteredRecord
        Record or replica whose signals are used.
    physical : (p,) array
    data : FilteredRecord
        Record of the same samples whose filter and row selection are used.
    """
    form = InverseForm(data.axis).at(physical)
    rows = form.equations(record.signals).reduced(data)
    return rows.residuals(form.regressed(physical))


@dataclass(frozen=True, kw_only=True)
class RowSpectrum:
    """Power spectrum of rows by frequency band, without their projection on a basis.

    The basis spans the model's columns and likely missing terms, see `_basis`.

    Attributes
    ----------
    places : (n,) array of int
        Index of each row on a uniform grid of rows, on which rows in gaps have an index as well.
    basis : (n, r) array
        Orthonormal basis.
    bands : (b + 1,) array of int
        Index of the first frequency of each band, and the index after the last band.
    counts : (b,) array
        Number of frequencies in each band, minus the shares that the basis takes, see `counted`.
    """

    places: IntArray
    basis: Array
    bands: IntArray
    counts: Array

    @classmethod
    def of(cls, data: FilteredRecord, quiet: FilteredRecord) -> "RowSpectrum":
        """Return the spectrum of a record's rows, with the basis from its noise-free record.

        Raises
        ------
        EstimationError
            There are too few rows.
        """
        numbers = np.round(data.sampling.rows).astype(np.int64)
        places = (numbers - numbers[:1]) // data.prefilter.decimate
        count = int(places.max(initial=0)) + 1
        highest = _MAX_FREQUENCY * count / 2
        if highest < _MIN_FREQUENCIES:
            raise EstimationError(
                f"the {len(places)} rows in motion are too few to estimate their noise. Record a "
                "longer motion.",
                code="too-short",
            )
        bands = np.unique(np.geomspace(1.0, highest, _MAX_BANDS + 1).astype(np.int64))
        rows = cls(
            places=places,
            basis=_basis(data, quiet),
            bands=bands,
            counts=np.ones(len(bands) - 1),
        )
        return rows.counted()

    def counted(self) -> "RowSpectrum":
        """Return the spectrum with `counts` set to ``n_B = sum_(f in B) (1 - min(h_f, 0.8))``.

        The leverage ``h_f = sum_j |F(q_j)_f|^2 / n`` of a frequency is the share of its power that
        the basis columns q take.
        """
        taken = np.sum(np.abs(self._transform(self.basis)) ** 2, axis=1) / len(self.places)
        return replace(self, counts=self._by_band(1 - np.minimum(taken, _MAX_LEVERAGE)))

    def power(self, rows: Array, others: Array | None = None) -> Array:
        """Return the mean power of rows by band, (b,), or their cross-power with other rows.

        ``sum_(f in B) Re(conj(F_f) G_f) / (n n_B)``, with F and G the transforms of `rows` and of
        `others` (of `rows` if None) minus their projection on the basis; averaged over the columns
        of (n, m) arrays.
        """
        first = self._transform(rows - self.basis @ (self.basis.T @ rows))
        second = first
        if others is not None:
            second = self._transform(others - self.basis @ (self.basis.T @ others))
        power = np.real(np.conj(first) * second).mean(axis=1) / len(rows)
        return self._by_band(power) / self.counts

    def _by_band(self, values: Array) -> Array:
        """Return the sums over each band of values by frequency, (b,)."""
        return np.asarray(np.add.reduceat(values, self.bands)[:-1], dtype=float)

    def _transform(self, rows: Array) -> ComplexArray:
        """Return the Fourier transform of rows (n,) or columns (n, m) on their grid, (f, m)."""
        placed = np.zeros((self.places[-1] + 1, *rows.shape[1:]))
        placed[self.places] = rows
        return np.asarray(np.fft.rfft(placed.reshape(len(placed), -1), axis=0))

    def power_of_disturbances(self, data: FilteredRecord, times: Sequence[float]) -> Array:
        """Return the power by band of disturbances of standard deviation 1, (m, b).

        White disturbances are passed through the record's filter. The rows of an autoregression are
        made from those of white noise: their spectrum is multiplied by that of the autoregression.

        Parameters
        ----------
        data : FilteredRecord
        times : sequence of float
            Correlation times, s.
        """
        # Rows of white disturbances, of all samples, on a uniform grid of rows.
        whole, rng = data.without(()), np.random.default_rng(0)
        first, every = round(float(data.sampling.rows[0])), data.prefilter.decimate
        places = (np.round(whole.sampling.rows).astype(np.int64) - first) // every
        white = np.zeros((int(places[-1] - places[0]) + 1, _DISTURBANCE_DRAWS))
        for draw in range(_DISTURBANCE_DRAWS):
            noise = rng.standard_normal(len(data))
            white[places - places[0], draw] = whole.reduce(whole.force_by(noise))
        # Rows of each autoregression, at the rows of this spectrum.
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
    """Return an orthonormal basis of model columns and likely missing terms, (n, r).

    The columns are those of the noise-free record (`quiet`), reduced to the rows of `data`. Each
    column is also multiplied by time, the sign of time, position, speed and direction, as far as
    there are 4 rows or more per column, so that parameters may vary along the motion.
    """
    signals = quiet.signals
    time = np.linspace(-1.0, 1.0, len(data))
    ones, speed = np.ones_like(time), np.abs(signals.velocity)
    missing = [ones, signals.position, signals.velocity, signals.direction]
    forces = np.abs(signals.force), np.gradient(signals.force)
    declared = InverseForm(data.axis).equations(signals).regressor
    columns = np.column_stack([declared, *missing, *forces])
    factors = [ones, time, np.sign(time), signals.position, speed, signals.direction]
    # As many factors as the number of rows allows.
    most = max(len(data.sampling.rows) // (_MIN_ROWS_PER_COLUMN * columns.shape[1]), 1)
    # Reduced factor by factor, as all samples of all columns take much more memory than the rows.
    products = np.hstack([data.reduce(columns * each[:, None]) for each in factors[:most]])
    norms = np.linalg.norm(products, axis=0)
    unit = products[:, norms > 0] / norms[norms > 0]
    basis, sizes, _ = np.linalg.svd(unit, full_matrices=False)
    return np.asarray(basis[:, sizes > _MIN_SINGULAR_VALUE_RATIO * sizes[0]])
