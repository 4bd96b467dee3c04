"""The DFKI pendulum's records, and estimators written without axisid to check its figures by.

`dfki_pendulum_study.py` uses them.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from dfki_pendulum import GRAVITY, axis
from scipy import signal

from axisid import Prefilter, Record, read_record, simulate
from axisid.estimation.signals import SampledFilter

#: J, mc, Fv, Fc, tau0 of the authors' system_identification.txt; their Fc multiplies atan(100 dq).
PUBLISHED = np.array([0.06259, 0.1022, 0.04707, 0.1839 * math.pi / 2, -0.07586])
#: 0.546 kg at 0.5 m on a rod with its mounting, 0.13 kg, taken as slender; the rotor, geared 6:1.
DOCUMENTED = {
    "J": 0.546 * 0.5**2 + 0.13 * 0.5**2 / 3 + 6.0719e-5 * 6**2,
    "mc": 0.546 * 0.5 + 0.13 * 0.5 / 2,
}
MOTIONS = {
    "identification run": "pd_system_identification_measured.csv",
    "direct collocation": "direct_collocation_measured.csv",
    "DDP": "ddp_measured.csv",
}
_G = GRAVITY.value
SHOWN = 15.0  # Hz, the lowest cut-off of the authors' recipe

Array = np.ndarray
Rows = list[list[str]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Data:
    """The records by motion; the identification run has its reference beside it."""

    records: dict[str, Record]
    velocity: dict[str, Array]

    @property
    def run(self) -> Record:
        """The identification run."""
        return self.records["identification run"]


def read_data(folder: Path, output: Path) -> Data:
    """Join the run's two files, and read the other motions as they are."""
    tables = {name: _table(folder / file) for name, file in MOTIONS.items()}
    desired = _table(folder / "pd_system_identification_desired.csv")
    first = tables["identification run"]
    joined = output / "dfki_joined.csv"
    columns = [first["time"], first["position"], desired["position"], first["torque"]]
    header = "time,position,reference,torque"
    np.savetxt(joined, np.column_stack(columns), delimiter=",", header=header, comments="")
    files = {name: folder / file for name, file in MOTIONS.items()}
    files["identification run"] = joined
    # The other motions were logged at rates of their own, which the axis does not declare.
    periods: dict[str, float | None] = {
        name: float(np.diff(table["time"]).mean()) for name, table in tables.items()
    }
    periods["identification run"] = None
    return Data(
        records={
            name: read_record(file, axis, sample_period=periods[name])
            for name, file in files.items()
        },
        velocity={name: table["velocity"] for name, table in tables.items()},
    )


def _table(file: Path) -> dict[str, Array]:
    rows = np.genfromtxt(file, delimiter=",", names=True)
    return {name: rows[name] for name in rows.dtype.names}


def prefilter(record: Record, cutoff: float) -> Prefilter:
    """Motion and torque low-passed alike; the torque as recorded, since it is no held command."""
    decimate = max(2, math.ceil(0.4 / (record.period * cutoff) - 1e-9))
    return Prefilter(cutoff=cutoff, decimate=decimate, hold="raw", reversals="keep")


def facts(data: Data) -> dict[str, float]:
    """Figures of the run that need no model."""
    run, torque = data.run, np.asarray(data.run.control)
    steps, period = np.diff(run.time), data.run.period
    shaken = signal.sosfiltfilt(high_pass(20.0, period), run.position)
    frequencies, power = signal.welch(shaken, 1 / period, nperseg=256)
    acceleration = derivative(derivative(run.position, period), period)
    q, _, ddq = SampledFilter(prefilter(run, 5.0), period).motion(run.position)
    speed = derivative(np.asarray(run.reference), period)
    law = 50.0 * (np.asarray(run.reference) - run.position) + 4.0 * speed
    stretch = (run.time > 0.13) & (run.time < 0.22)
    return {
        "period, ms": 1e3 * period,
        "longest step, ms": 1e3 * steps.max(),
        "position step, mrad": 1e3 * _smallest_step(run.position),
        "torque step, mN m": 1e3 * _smallest_step(torque),
        "torque peak, N m": float(np.abs(torque).max()),
        "vibration, Hz": float(frequencies[power.argmax()]),
        "vibration, mrad rms": 1e3 * float(np.std(shaken)),
        "acceleration peak, rad/s^2": float(np.abs(acceleration).max()),
        "of the reference, rad/s^2": float(np.abs(derivative(speed, period)).max()),
        "correlation of ddq and sin q": float(np.corrcoef(ddq, np.sin(q))[0, 1]),
        "barely moving, 0.13-0.22 s, the law: mean N m": float(law[stretch].mean()),
        "barely moving, 0.13-0.22 s, recorded: mean N m": float(torque[stretch].mean()),
    }


def _smallest_step(values: Array) -> float:
    return float(np.diff(np.unique(values)).min())


def derivative(values: Array, period: float) -> Array:
    """By central differences."""
    return np.asarray(np.gradient(values, period))


def high_pass(cutoff: float, period: float) -> Array:
    """Second-order sections of a Butterworth filter of order 4."""
    return np.asarray(signal.butter(4, 2 * cutoff * period, btype="high", output="sos"))


def authors_recipe(record: Record, velocity: Array, share: float = 0.1) -> tuple[Array, float]:
    """Estimate as the authors' script does; their bounds are not reached.

    Parameters
    ----------
    record : Record
    velocity : (N,) array
        The drive's own.
    share : float
        Edge of the low-pass on acceleration and torque over the Nyquist frequency; theirs is 0.1.

    Returns
    -------
    (J, mc, Fv, Fc, tau0), equation error in percent
    """
    rate = np.gradient(_twice(velocity, 0.2), record.time)
    dq = np.gradient(record.position, record.time)
    ones = np.ones_like(dq)
    columns = [
        _twice(rate, share),
        _G * np.sin(record.position),
        dq,
        np.arctan(100 * dq),
        ones,
    ]
    regressor, torque = np.column_stack(columns), _twice(np.asarray(record.control), share)
    theta = np.linalg.lstsq(regressor, torque, rcond=None)[0]
    return theta, percent(torque - regressor @ theta, torque)


def _twice(values: Array, share: float) -> Array:
    return np.asarray(signal.filtfilt(*signal.butter(3, share), values))


def percent(error: Array, values: Array) -> float:
    """Norm of an error in percent of the values' norm."""
    return float(100 * np.linalg.norm(error) / np.linalg.norm(values))


def columns_by_hand(
    record: Record, settings: Prefilter, ends: tuple[int, int] | None = None
) -> tuple[Array, Array]:
    """Regressor and torque of least squares, without axisid's generated functions."""
    low = signal.butter(settings.order, 2 * settings.cutoff * record.period, output="sos")
    q = signal.sosfiltfilt(low, record.position, padlen=3 * settings.order)
    dq = derivative(q, record.period)
    columns = (*_terms(q, dq, derivative(dq, record.period)), np.asarray(record.control))
    kept = thinned(np.column_stack(columns), settings, record.period, ends)
    return kept[:, :5], kept[:, 5]


def instruments_by_hand(
    record: Record, physical: Array, settings: Prefilter, ends: tuple[int, int] | None = None
) -> Array:
    """The regressor of the loop simulated with given values, without axisid's regressor."""
    reference, start = np.asarray(record.reference), float(record.position[0])
    # An estimate of a friction that is about nothing may lie a little below its bound.
    unbounded = tuple(replace(p, lower=-math.inf) for p in axis.parameters)
    free = replace(axis, parameters=unbounded)
    loop = simulate(free, physical, reference, record.period, start=start)
    terms = _terms(loop.position, loop.velocity, loop.acceleration)
    return thinned(np.column_stack(terms), settings, record.period, ends)


def _terms(q: Array, dq: Array, ddq: Array) -> tuple[Array, ...]:
    return ddq, _G * np.sin(q), dq, np.sign(dq), np.ones_like(q)


def thinned(
    columns: Array, settings: Prefilter, period: float, ends: tuple[int, int] | None = None
) -> Array:
    """Decimate the record, rows counted from its end, its ends without weight or rows.

    Parameters
    ----------
    columns : (N, k) array
    settings : Prefilter
    period : float
        s.
    ends : (int, int), optional
        Samples at start and end without weight; by default the low-pass transient's.
    """
    slowest = 2 * np.pi * settings.cutoff * np.sin(np.pi / (2 * settings.order))
    transient = math.ceil(np.log(1e3) / slowest / period)
    start, end = ends or (transient, transient)
    thin = signal.cheby1(8, 0.05, 0.8 / settings.decimate, output="sos")
    weighted = np.array(columns)
    weighted[:start] = weighted[len(columns) - end :] = 0.0
    smooth = signal.sosfiltfilt(thin, weighted, axis=0, padlen=24)
    rows = np.arange(len(columns))[:: -settings.decimate][::-1]
    return np.asarray(smooth[rows[(rows >= start) & (rows < len(columns) - end)]])


def weak_form(record: Record, window: float = 0.5) -> tuple[Array, float]:
    """Estimate without any derivative of the position: the equation against test functions.

    Each row integrates the equation of motion over a window with the weight ``sin(pi t/window)^4``;
    by parts, the derivatives fall on the weight.

    Returns
    -------
    (J, mc, Fv, Fc, tau0), error of the rows in percent
    """
    count = round(window / record.period)
    weight = np.sin(np.pi * np.arange(count) / count) ** 4
    once = derivative(weight, record.period)
    twice = derivative(once, record.period)
    q, torque = record.position, np.asarray(record.control)
    direction = np.sign(np.gradient(q))
    rows, left = [], []
    for start in range(0, len(record) - count, count // 6):
        part = slice(start, start + count)
        gravity = _G * weight @ np.sin(q[part])
        friction = weight @ direction[part]
        rows.append([twice @ q[part], gravity, -once @ q[part], friction, weight.sum()])
        left.append(weight @ torque[part])
    regressor, values = np.array(rows), np.array(left)
    theta = np.linalg.lstsq(regressor, values, rcond=None)[0]
    return theta, percent(values - regressor @ theta, values)
