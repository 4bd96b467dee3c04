"""Positions under the recorded control, in windows that each start where the record is.

Nothing holds an axis without its loop: a small error of the force drifts away with the square of
time. So the record is cut into windows [Bock1983]_, each with a first position and velocity of its
own. These are no parameters of the search: to first order what they can do is taken out of the
errors of their window, by a QR of the errors' slopes by them, and they follow the parameters.
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

from .output_residuals import OutputResiduals, Piece

_HORIZON = 1.0  # s, of the windows of an open loop where none is given

#: Samples in a window.
FEWEST_IN_WINDOW = 20
_FITTED = 20  # samples from the first on, from which a first velocity is begun
_ROUNDS = 8  # of the first positions and velocities, at each point, at most
_SHARES = np.array([1.0, 0.25, 0.03])  # of a step of them, that are tried
_SHORTEST = 0.0625  # s, of the windows that are asked first
_STILL = 1e-6  # of a window's squared errors, by which a step lessens them that is the last
# Of what a first position changes, what a first velocity does: else it is rounding. A velocity that
# friction hides is a start's all the same: without it a window from rest outweighs all others.
_SHOWN = 1e-9
_STEP = 1e-6  # of the range of positions, and of that over the window's time


@dataclass(slots=True, kw_only=True)
class _Windows:
    """Windows of one length of one segment, side by side.

    Attributes
    ----------
    axis : GeneratedAxis
        Without a loop.
    record : int
    first : int
        Sample of the record that the first begins at.
    period : float
        s
    position, control : (N, w) array
    counted : (N, w) array
        1 for samples that are measurements, 0 for others.
    signals : tuple of (N, w) array
    first_states : (2, w) array
        Positions and velocities that they start from.
    basis : (w, N, 2) array
        Directions of the errors that other first states can make.
    substeps : int or None
        Of a sample, once they are settled.
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
        """How many."""
        return int(self.position.shape[1])

    @property
    def steps(self) -> Array:
        """Steps of first position and velocity for slopes, (2,)."""
        reach = _STEP * max(float(np.ptp(self.position)), 1e-9)
        return np.array([reach, reach / (len(self.position) * self.period)])

    def cut(self, values: Array) -> Array:
        """Values of the record's samples, (N,), as windows have them, (N, w)."""
        inside = values[self.first : self.first + self.position.size]
        return np.ascontiguousarray(inside.reshape(self.count, -1).T)

    def inputs(self, states: Array) -> LoopInputs:
        """Of the windows, once or several times, from states (2, B w)."""
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
        """Of parameters (B, p): (N, B, w), and what failed by set.

        From where the windows start, or from states (2, B w).
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
        """Errors (N, B, w) as rows, window after window, (w N, B), less what first states make."""
        inner = np.einsum("wnk,nbw->wkb", self.basis, errors)
        net = errors - np.einsum("wnk,wkb->nbw", self.basis, inner)
        return np.asarray(net.transpose(2, 0, 1).reshape(-1, errors.shape[1]))


class MultipleShootingResiduals(OutputResiduals):
    """Positions under the recorded control.

    Parameters
    ----------
    form : Form
    axes : sequence of GeneratedAxis
        By record.
    records : sequence of Record
    horizon : float
        Length of a window, s.

    Raises
    ------
    DataError
        A record has no position or no control.
    UsageError
        The friction of an axis remembers.
    """

    horizon: float

    def __init__(
        self,
        form: Form,
        axes: Sequence[GeneratedAxis],
        records: Sequence[Record],
        horizon: float,
    ) -> None:
        if remembers := [axis.name for axis in axes if axis.states]:
            raise UsageError(
                f"what the friction of axis {remembers[0]!r} remembers where a window begins is in "
                "no record; follow the control or the position, whose loops begin as the record "
                "does.",
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
                measured=(w.position - w.position[0]).T.ravel(),  # from its first position on
                counted=w.counted.T.ravel(),
            )
            for w in self._windows
        ]
        super().__init__(form, records, pieces)

    def settle(self, physical: Array) -> None:
        """See `OutputResiduals.settle`: steps of a sample, and where the windows start."""
        for w in self._windows:
            theta = np.asarray(self._form.own(physical, w.record))
            inputs = w.inputs(w.first_states)
            asked = (settled_substeps(w.axis, theta, inputs.lanes(k)) for k in range(w.count))
            w.substeps = max(w.substeps or 1, *(steps or 1 for steps in asked))
            _follow(w, theta)

    def _forget_steps(self) -> None:
        for w in self._windows:
            w.substeps = None

    def _errors(self, physical: Array) -> Iterator[tuple[Array, dict[int, str]]]:
        """Errors of windows; those of a trial alone start where its own errors are least."""
        for w in map(replace, self._windows):
            theta = np.array([self._form.own(lane, w.record) for lane in physical])
            if len(theta) == 1:
                try:
                    _follow(w, theta[0])
                except EstimationError as error:
                    yield np.full((w.position.size, 1), np.nan), {0: str(error)}
                    continue
            errors, failed = w.errors(theta)
            yield w.rows(errors), failed

    def outputs_of(self, records: Sequence[Record], physical: Array) -> Array:
        """See `OutputResiduals.outputs_of`; windows start where these records ask for."""
        controls, pieces = [*map(_control, self._axes, records)], []
        for each in self._windows:
            position = each.cut(records[each.record].position)
            w = replace(each, position=position, control=each.cut(controls[each.record]))
            theta = np.asarray(self._form.own(physical, w.record))
            _follow(w, theta)
            errors, failed = w.errors(theta[None])
            if failed:
                raise EstimationError(failed[0], code="simulation")
            pieces.append(w.rows(errors))
        return -np.concatenate(pieces)[:, 0]

    def steady_horizon(self, physical: Array) -> float:
        """How long windows may be at parameters (P,), s: as long as these, or a half, and so on.

        A window in which the axis stops forgets how it began, so that short ones are asked first,
        and no longer ones once errors grow.

        Raises
        ------
        EstimationError
            A window cannot be simulated.
        """
        longest = min(self.horizon, max(len(w.position) * w.period for w in self._windows))
        halvings = max(math.ceil(math.log2(longest / _SHORTEST)), 0)
        steady = 0.5 * longest * 0.5**halvings
        for k in reversed(range(halvings + 1)):
            asked = longest * 0.5**k
            windows = MultipleShootingResiduals(self._form, self._axes, self._records, asked)
            windows.settle(physical)
            grown = max(_growth(w, self._form.own(physical, w.record)) for w in windows._windows)
            if grown > MAX_GROWTH.value:
                return steady
            steady = asked
        return self.horizon


def _growth(w: _Windows, theta: Array) -> float:
    """How far a first velocity carries an axis by parameters (p,), over a free one's way.

    Of all windows the furthest. More than 1 is a motion that no loop holds: friction that falls
    with the velocity, or a force away from a place.
    """
    errors, (_, step) = _moved(w, theta), w.steps
    reach = float(np.abs(errors[:, 3] - errors[:, 4]).max()) / 2
    return float(reach / (step * len(w.position) * w.period))


def default_horizon(records: Sequence[Record]) -> float:
    """Length of windows of which records have enough that their scatter tells deviations, s."""
    stretches = [(end - first, r.period) for r in records for first, end in r.spans]
    horizon = _HORIZON
    while horizon > _SHORTEST:
        windows = sum(max(samples // _size(horizon, period), 1) for samples, period in stretches)
        if windows >= ADVISED_WINDOWS.value:
            break
        horizon /= 2
    return horizon


def _size(horizon: float, period: float) -> int:
    return max(round(horizon / period), FEWEST_IN_WINDOW)


def _follow(w: _Windows, theta: Array) -> None:
    """Let windows start where their errors are least, with parameters (p,).

    Each step is by slopes, and as much of it is taken as lessens the window's errors: friction that
    holds an axis forgets its first velocity, and what a slope then asks for may be anything.
    """
    for _ in range(_ROUNDS):
        errors, back = _step_back(w, theta)
        tried = w.first_states[:, None, :] - _SHARES[:, None] * (back * w.steps).T[:, None, :]
        here = np.einsum("nw,nw->w", errors, errors)
        errors, failed = w.errors(np.tile(theta, (len(_SHARES), 1)), tried.reshape(2, -1))
        there = np.einsum("nbw,nbw->bw", errors, errors)
        there[[*failed]] = np.inf
        best, every = there.argmin(axis=0), np.arange(w.count)
        less = there[best, every] < here
        w.first_states = np.where(less, tried[:, best, every], w.first_states)
        if np.all(~less | (there[best, every] > (1 - _STILL) * here)):
            break


def _moved(w: _Windows, theta: Array) -> Array:
    """Errors (N, 5, w) from where windows start, and from a step to either side of each."""
    shifts = np.array([[0, 1, -1, 0, 0], [0, 0, 0, 1, -1]], dtype=float) * w.steps[:, None]
    states = (w.first_states[:, None, :] + shifts[:, :, None]).reshape(2, -1)
    errors, failed = w.errors(np.tile(theta, (5, 1)), states)
    if failed:
        raise EstimationError(next(iter(failed.values())), code="simulation")
    return errors


def _step_back(w: _Windows, theta: Array) -> tuple[Array, Array]:
    """Errors (N, w) from where windows start, and which steps of the start lead to the least."""
    errors = _moved(w, theta)
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
    if record.integrated:
        raise DataError(
            f"{record.provenance.source} has no position, which is to be followed.",
            code="missing-column",
        )
    control = _control(axis, record)
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
        count = max((last - first) // _size(horizon, record.period), 1)
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


def _control(axis: GeneratedAxis, record: Record) -> Array:
    drive = axis.drive
    if record.control is not None:
        starts = [start for start, _ in record.spans]
        return acting_control(axis, np.asarray(record.control), starts, record.period)
    if record.force is not None and drive.is_gain:
        return np.asarray(record.force / float(drive.gain))
    raise DataError(
        f"{record.provenance.source} has no control column, under which the axis is to "
        "move; name it with columns control=NAME.",
        code="missing-column",
    )
