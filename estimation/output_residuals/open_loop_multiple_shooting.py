"""Open-loop multiple shooting: positions under the recorded control, in windows.

Without its loop an axis drifts: a small error of the force grows with the square of time. So the
record is cut into windows [Bock1983]_, each with its own initial position and velocity. These
initial states are not parameters of the search: to first order their effect is projected out of the
residuals of their window, by a QR of the residuals' derivatives, and the initial states are
estimated again for other parameters.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial.polynomial import polyfit

from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.codegen.lowering import LoopStart
from axisid.estimation.records import Record
from axisid.estimation.regression import Form
from axisid.estimation.signals import acting_control, recorded_signals
from axisid.estimation.simulation import LoopInputs, settled_substeps, simulate_lanes
from axisid.estimation.thresholds import ADVISED_WINDOWS, MAX_GROWTH
from axisid.modeling.declaration import no_law
from axisid.support.arrays import Array, mask_of
from axisid.support.errors import DataError, EstimationError, UsageError
from axisid.support.settings import setting

from .output_residuals import OutputResiduals, Piece

_HORIZON = 1.0  # s, default length of the windows

#: Smallest number of samples of a window.
FEWEST_IN_WINDOW = 20
_FITTED = 20  # first samples of a window, for the first estimate of its initial velocity
_ROUNDS = 8  # largest number of iterations of the initial states
_SHARES = np.array([1.0, 0.25, 0.03])  # fractions of a step of the initial states that are tried
_SHORTEST = 0.0625  # s: shortest windows that are tried
_STILL = 1e-6  # relative decrease of a window's squared residuals at which the iteration ends
# Smallest effect of an initial position or velocity relative to that of the other; a smaller effect
# is rounding. An initial velocity that friction suppresses is kept as a state: otherwise a window
# from rest would outweigh all other windows.
_SHOWN = 1e-9
# Step of an initial position relative to the range of the position; likewise of a velocity.
_STEP = 1e-6


@dataclass(slots=True, kw_only=True)
class _Windows:
    """Windows of equal length of one segment, in parallel.

    Attributes
    ----------
    axis : GeneratedAxis
        Axis without a control law.
    record : int
        Number of the record.
    first : int
        Sample of the record at which the first window begins.
    period : float
        Sampling period, s.
    position, control : (N, w) array
        Recorded position and acting control, one column for each window.
    counted : (N, w) array
        1 for samples that are measurements, 0 for others.
    signals : tuple of (N, w) array
        Recorded signals that the axis declares.
    first_states : (2, w) array
        Initial positions and velocities.
    basis : (w, N, 2) array
        Orthonormal basis of the derivatives of the residuals by the initial states.
    substeps : int or None
        Steps per sample; None before they are chosen.
    """

    axis: GeneratedAxis
    record: int
    first: int
    period: float
    position: Array
    control: Array
    counted: Array
    signals: tuple[Array, ...]
    first_states: Array
    basis: Array
    substeps: int | None = None

    @property
    def count(self) -> int:
        """Number of windows."""
        return int(self.position.shape[1])

    @property
    def steps(self) -> Array:
        """Steps of initial position and velocity for differences, (2,)."""
        reach = _STEP * max(float(np.ptp(self.position)), 1e-9)
        return np.array([reach, reach / (len(self.position) * self.period)])

    def cut(self, values: Array) -> Array:
        """Return values of the record's samples as one column for each window, (N, w)."""
        inside = values[self.first : self.first + self.position.size]
        return np.ascontiguousarray(inside.reshape(self.count, -1).T)

    def inputs(self, states: Array) -> LoopInputs:
        """Return the inputs of the loops of all windows, for initial states (2, B w).

        The inputs of the w windows are repeated for each of B parameter sets.
        """
        sets = states.shape[1] // self.count
        wide = [np.tile(v, (1, sets)) for v in (self.position, self.control, *self.signals)]
        return LoopInputs(
            reference=wide[0],
            period=self.period,
            start=LoopStart(position=states[0], velocity=states[1]),
            injected=wide[1],
            signals=tuple(wide[2:]),
        )

    def errors(self, theta: Array, states: Array | None = None) -> tuple[Array, dict[int, str]]:
        """Return the residuals for parameters (B, p), (N, B, w), and failures by parameter set.

        The windows start from their initial states, or from given states (2, B w).
        """
        sets = len(theta)
        first = np.tile(self.first_states, (1, sets)) if states is None else states
        with np.errstate(all="ignore"):
            batch = simulate_lanes(
                self.axis,
                np.repeat(theta, self.count, axis=0),
                self.inputs(first),
                substeps=self.substeps,
                wanted=["position"],
            )
        shape = (len(self.position), sets, self.count)
        errors = batch["position"].reshape(shape) - self.position[:, None, :]
        errors *= self.counted[:, None, :]
        return errors, {lane // self.count: why for lane, why in batch.failures.items()}

    def rows(self, errors: Array) -> Array:
        """Return residuals (N, B, w) as rows, (w N, B), without the effect of initial states."""
        inner = np.einsum("wnk,nbw->wkb", self.basis, errors)
        net = errors - np.einsum("wnk,wkb->nbw", self.basis, inner)
        return np.asarray(net.transpose(2, 0, 1).reshape(-1, errors.shape[1]))


class MultipleShootingResiduals(OutputResiduals):
    """Residuals of positions that are simulated under the recorded control, in windows.

    Parameters
    ----------
    form : Form
        Map of the parameters of the fit to those of each record's axis.
    axes : sequence of GeneratedAxis
        Axis of each record.
    records : sequence of Record
    horizon : float
        Length of a window, s.

    Raises
    ------
    DataError
        A record has no position or no control.
    UsageError
        The friction of an axis has an internal state.
    """

    horizon: float

    def __init__(
        self,
        form: Form,
        axes: Sequence[GeneratedAxis],
        records: Sequence[Record],
        horizon: float,
    ) -> None:
        if with_states := [axis.name for axis in axes if axis.states]:
            raise UsageError(
                f"the internal state of the friction of axis {with_states[0]!r} at the start of a "
                "window is not recorded. Fit the control or the position of the closed loop, which "
                "starts at the beginning of the record.",
                code="equation",
            )
        self._axes, self.horizon = tuple(axes), horizon
        self.units: tuple[str, ...] = (str(axes[0].axis.coordinate.unit),)
        every = enumerate(zip(axes, records, strict=True))
        self._windows = [w for i, (a, r) in every for w in _windows(a, r, i, horizon)]
        pieces = [
            Piece(
                record=w.record,
                spans=w.count * (len(w.position),),
                samples=w.first + np.arange(w.position.size),
                measured=(w.position - w.position[0]).T.ravel(),  # relative to its first position
                counted=w.counted.T.ravel(),
            )
            for w in self._windows
        ]
        super().__init__(form, records, pieces)

    def settle(self, physical: Array) -> None:
        """Choose steps per sample and the initial states of the windows for parameters (P,)."""
        for w in self._windows:
            theta = np.asarray(self._form.own(physical, w.record))
            inputs = w.inputs(w.first_states)
            needed = (settled_substeps(w.axis, theta, inputs.lanes(k)) for k in range(w.count))
            w.substeps = max(w.substeps or 1, *(steps or 1 for steps in needed))
            _fit_initial_states(w, theta)

    def _forget_steps(self) -> None:
        """Forget the chosen steps per sample of the windows."""
        for w in self._windows:
            w.substeps = None

    def _errors(self, physical: Array) -> Iterator[tuple[Array, dict[int, str]]]:
        """Yield the residuals of the windows for parameters (B, P), (n, B), and failures by lane.

        For a single parameter set, the initial states of the windows are estimated again. For
        several sets the initial states are those of `settle`. In both cases, the effect of small
        changes of the initial states is projected out of the residuals.
        """
        for w in map(replace, self._windows):  # copies, so that the chosen initial states stay
            theta = np.array([self._form.own(lane, w.record) for lane in physical])
            if len(theta) == 1:
                try:
                    _fit_initial_states(w, theta[0])
                except EstimationError as error:
                    yield np.full((w.position.size, 1), np.nan), {0: str(error)}
                    continue
            errors, failed = w.errors(theta)
            yield w.rows(errors), failed

    def outputs_of(self, records: Sequence[Record], physical: Array) -> Array:
        """Return recorded minus simulated positions of other records of the same samples, (n,).

        The initial states of the windows are estimated from those records.
        """
        controls, pieces = [*map(_acting_control, self._axes, records)], []
        for each in self._windows:
            position = each.cut(records[each.record].position)
            w = replace(each, position=position, control=each.cut(controls[each.record]))
            theta = np.asarray(self._form.own(physical, w.record))
            _fit_initial_states(w, theta)
            errors, failed = w.errors(theta[None])
            if failed:
                raise EstimationError(failed[0], code="simulation")
            pieces.append(w.rows(errors))
        return -np.concatenate(pieces)[:, 0]

    def steady_horizon(self, physical: Array) -> float:
        """Return the longest length of windows without error growth at parameters (P,), s.

        The length is that of these windows, a half, a quarter, and so on. Short windows are tried
        first, up to the first length at which errors grow: a long window in which the axis stops
        does not depend on its initial state, and would not show the growth.

        Raises
        ------
        EstimationError
            A window cannot be simulated.
        """
        longest = min(self.horizon, max(len(w.position) * w.period for w in self._windows))
        halvings = max(math.ceil(math.log2(longest / _SHORTEST)), 0)
        steady = 0.5 * longest * 0.5**halvings
        for k in reversed(range(halvings + 1)):
            tried = longest * 0.5**k
            windows = MultipleShootingResiduals(self._form, self._axes, self._records, tried)
            windows.settle(physical)
            grown = max(_growth(w, self._form.own(physical, w.record)) for w in windows._windows)
            if grown > MAX_GROWTH.value:
                return steady
            steady = tried
        return self.horizon


def _growth(w: _Windows, theta: Array) -> float:
    """Return the largest displacement by an initial velocity relative to that of a free axis.

    The ratio is ``|dq/dv0| / T`` over samples and windows of length T, with parameters (p,). More
    than 1 shows an unstable open loop: friction that falls with velocity, or a repelling force.
    """
    errors, (_, step) = _errors_at_shifted_states(w, theta), w.steps
    reach = float(np.abs(errors[:, 3] - errors[:, 4]).max()) / 2
    return float(reach / (step * len(w.position) * w.period))


def default_horizon(records: Sequence[Record]) -> float:
    """Return the longest window length with enough windows for standard errors, s.

    It is 1 s, or this length halved one or several times, down to 1/16 s.
    """
    stretches = [(end - first, r.period) for r in records for first, end in r.spans]
    horizon = _HORIZON
    while horizon > _SHORTEST:
        windows = sum(
            max(samples // _window_samples(horizon, period), 1) for samples, period in stretches
        )
        if windows >= ADVISED_WINDOWS.value:
            break
        horizon /= 2
    return horizon


def _window_samples(horizon: float, period: float) -> int:
    """Return the number of samples of a window, from its length and the sampling period, s."""
    return max(round(horizon / period), FEWEST_IN_WINDOW)


def _fit_initial_states(w: _Windows, theta: Array) -> None:
    """Set the initial states of windows to those of least squared residuals, with parameters (p,).

    The initial states are found by Gauss-Newton steps. Of each step, the best of some fractions is
    taken: if friction stops an axis, the initial velocity has no effect, and a full step may be
    arbitrary. A window in which no fraction reduces the residuals keeps its initial state.

    Raises
    ------
    EstimationError
        A window cannot be simulated.
    """
    for _ in range(_ROUNDS):
        errors, back = _gauss_newton_step(w, theta)
        # Squared residuals of each window at its present state, and after fractions of the step.
        tried = w.first_states[:, None, :] - _SHARES[:, None] * (back * w.steps).T[:, None, :]
        here = np.einsum("nw,nw->w", errors, errors)
        errors, failed = w.errors(np.tile(theta, (len(_SHARES), 1)), tried.reshape(2, -1))
        there = np.einsum("nbw,nbw->bw", errors, errors)
        there[[*failed]] = np.inf
        # The best fraction of each window, if it reduces the residuals.
        best, every = there.argmin(axis=0), np.arange(w.count)
        less = there[best, every] < here
        w.first_states = np.where(less, tried[:, best, every], w.first_states)
        if np.all(~less | (there[best, every] > (1 - _STILL) * here)):
            break


def _errors_at_shifted_states(w: _Windows, theta: Array) -> Array:
    """Return the residuals of windows with five initial states each, (N, 5, w).

    The five are the present initial state, then the position a step higher and lower, then the
    velocity a step higher and lower. `theta`, (p,), are the parameters.

    Raises
    ------
    EstimationError
        A window cannot be simulated.
    """
    shifts = np.array([[0, 1, -1, 0, 0], [0, 0, 0, 1, -1]], dtype=float) * w.steps[:, None]
    states = (w.first_states[:, None, :] + shifts[:, :, None]).reshape(2, -1)
    errors, failed = w.errors(np.tile(theta, (5, 1)), states)
    if failed:
        raise EstimationError(next(iter(failed.values())), code="simulation")
    return errors


def _gauss_newton_step(w: _Windows, theta: Array) -> tuple[Array, Array]:
    """Return the residuals, (N, w), and the Gauss-Newton step of the initial states, (w, 2).

    The step is in units of `_Windows.steps`, and has to be subtracted. The basis of the windows is
    set to that of the derivatives by the initial states.
    """
    errors = _errors_at_shifted_states(w, theta)
    slopes = (errors[:, [1, 3]] - errors[:, [2, 4]]) / 2  # (N, 2, w), a step each
    basis, triangle = np.linalg.qr(slopes.transpose(2, 0, 1))
    size = np.abs(np.einsum("wkk->wk", triangle))
    is_seen = size > _SHOWN * size.max(axis=1, keepdims=True)
    w.basis = basis * is_seen[:, None, :]
    wanted = np.einsum("wnk,nw->wk", w.basis, errors[:, 0])
    back = np.linalg.pinv(triangle * is_seen[:, :, None]) @ wanted[:, :, None]
    return errors[:, 0], back[:, :, 0]


def _windows(
    axis: GeneratedAxis, record: Record, number: int, horizon: float
) -> Iterator[_Windows]:
    """Yield the windows of each segment of a record.

    Raises
    ------
    DataError
        The record has no position, or no control.
    """
    if record.integrated:
        raise DataError(
            f"{record.provenance.source} has no position column, which is the output of the fit. "
            f"Name the column with {setting('columns', {'position': 'NAME'})}, or choose another "
            "output.",
            code="missing-column",
        )
    control = _acting_control(axis, record)
    # The axis without a law: its drive is driven by the acting control.
    declared = axis.declared
    free = build(
        replace(
            declared,
            drive=declared.drive.behind_path(),
            control=no_law(record.period),
        ),
        native=axis.native.enabled,
    )
    columns = recorded_signals(axis, record.provenance.source, record.signals)
    counted = (~mask_of(record.masked, len(record))).astype(float)
    for first, last in record.spans:
        count = max((last - first) // _window_samples(horizon, record.period), 1)
        size = (last - first) // count
        every = (record.position, control, counted, *columns)
        cut = [v[first : first + count * size].reshape(count, size).T.copy() for v in every]
        some = min(_FITTED, size)
        yield _Windows(
            axis=free,
            record=number,
            first=first,
            period=record.period,
            position=cut[0],
            control=cut[1],
            counted=cut[2],
            signals=tuple(cut[3:]),
            first_states=polyfit(record.period * np.arange(some), cut[0][:some], 2)[:2],
            basis=np.zeros((count, size, 2)),
        )


def _acting_control(axis: GeneratedAxis, record: Record) -> Array:
    """Return the acting control of a record, or the control that gives the recorded force, (N,).

    Raises
    ------
    DataError
        The record has neither a control nor a force of a drive that is a gain.
    """
    drive = axis.drive
    if record.control is not None:
        starts = [start for start, _ in record.spans]
        return acting_control(axis, np.asarray(record.control), starts, record.period)
    if record.force is not None and drive.is_gain:
        return np.asarray(record.force / float(drive.gain))
    raise DataError(
        f"{record.provenance.source} has no control column, with which the axis is "
        f"simulated. Name the column with {setting('columns', {'control': 'NAME'})}.",
        code="missing-column",
    )
