"""Faults of recorded signals, drawn at random and put into a right log.

Each is one that loggers, converters, sensors and people have: a wrong scale, lost rows, another
clock. What no record can show is not drawn: without a reference and its law, a wrong scale of the
position or of the force is just another axis, and so is a wrong drive gain without a force column.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from axisid import Axis, simulate
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation.simulation.twin import trajectory

Array = NDArray[Any]

_DEGREE = np.pi / 180


@dataclass(frozen=True, slots=True, kw_only=True)
class Log:
    """A log and the axis that it is said to be of.

    Attributes
    ----------
    axis : Axis
    columns : mapping of str to (N,) array
        By role, SI.
    """

    axis: Axis
    columns: Mapping[str, Array]

    def __len__(self) -> int:
        return len(self.columns["time"])

    @property
    def period(self) -> float:
        """Of the samples, s."""
        return float(np.median(np.diff(self.columns["time"])))

    @property
    def signals(self) -> list[str]:
        """The columns but the time."""
        return [role for role in self.columns if role != "time"]

    @property
    def compared(self) -> list[str]:
        """Columns of which another one tells what they have to be."""
        if "reference" in self.columns and "control" in self.columns:
            return self.signals
        both = ["control", "force"]
        return both if all(role in self.columns for role in both) else []

    def having(self, **columns: Array) -> "Log":
        """The log with other columns."""
        return replace(self, columns={**self.columns, **columns})

    def rows(self, chosen: Array | slice) -> "Log":
        """The log with some of its rows, or rows more than once."""
        return replace(self, columns={role: v[chosen] for role, v in self.columns.items()})

    def counted(self) -> "Log":
        """The log with its time counted anew, as if its rows were all."""
        return self.having(time=self.period * np.arange(len(self)))


#: Puts a fault into a log, and says what it did; None where the log cannot show it.
Fault = Callable[[Log, np.random.Generator], tuple[Log, str] | None]
#: Puts one into a copy of a column's values, and says what it did to the column.
ColumnFault = Callable[[Array, np.random.Generator], tuple[Array, str]]


def right_log(axis: GeneratedAxis, record: Mapping[str, Array], variant: str) -> Log:
    """The log of a twin: ``full``, ``with force``, ``without reference`` or ``force alone``."""
    columns = dict(record)
    if variant in ("with force", "force alone"):
        # A sensor sees the mean of what is held before and after it.
        held = axis.axis.drive.gain * columns["control"]
        columns["force"] = (held + np.concatenate([held[:1], held[:-1]])) / 2
    if variant in ("without reference", "force alone"):
        del columns["reference"]
    if variant == "force alone":
        del columns["control"]
    return Log(axis=axis.axis, columns=columns)


def _of_any(spoil: ColumnFault) -> Fault:
    """A fault of one column, any but the time."""

    def fault(log: Log, rng: np.random.Generator) -> tuple[Log, str]:
        return _in_one(log.signals, spoil, log, rng)

    return fault


def _of_compared(spoil: ColumnFault) -> Fault:
    """A fault of one column of which another one tells what it has to be."""

    def fault(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
        return _in_one(log.compared, spoil, log, rng) if log.compared else None

    return fault


def _in_one(
    roles: list[str], spoil: ColumnFault, log: Log, rng: np.random.Generator
) -> tuple[Log, str]:
    role = str(rng.choice(roles))
    values, done = spoil(log.columns[role].copy(), rng)
    return log.having(**{role: values}), f"{role} {done}"


def _stretches(n: int, rng: np.random.Generator, longest: float, most: int = 5) -> list[slice]:
    """A few stretches of n rows, each at most a share of them."""
    found = []
    for _ in range(rng.integers(1, most + 1)):
        length = int(rng.integers(1, max(int(longest * n), 2)))
        start = int(rng.integers(1, n - length))
        found.append(slice(start, start + length))
    return found


@_of_compared
def scaled(values: Array, rng: np.random.Generator) -> tuple[Array, str]:
    """A column of which every value is off by a factor."""
    factor = float(rng.choice([0.5, 0.9, 0.95, 0.97, 1.03, 1.05, 1.1, 1.25, 2.0]))
    return factor * values, f"x {factor:g}"


@_of_compared
def unit(values: Array, rng: np.random.Generator) -> tuple[Array, str]:
    """A column in another unit."""
    factor = float(rng.choice([1e-3, 1e3, _DEGREE, 1 / _DEGREE, 0.0254, 100.0]))
    return factor * values, f"x {factor:.4g}"


@_of_any
def sign(values: Array, _rng: np.random.Generator) -> tuple[Array, str]:
    """A column of the wrong sign."""
    return -values, "x -1"


def time_base(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """A clock that runs too fast or too slow, or counts another unit."""
    factor = float(rng.choice([1e-3, 0.5, 0.95, 0.99, 1.01, 1.05, 2.0, 1000.0]))
    return log.having(time=factor * log.columns["time"]), f"time x {factor:g}"


def swapped(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """Two columns exchanged."""
    if len(log.signals) < 2:
        return None
    a, b = (str(name) for name in rng.choice(log.signals, 2, replace=False))
    return log.having(**{a: log.columns[b], b: log.columns[a]}), f"{a} <-> {b}"


@_of_compared
def offset(values: Array, rng: np.random.Generator) -> tuple[Array, str]:
    """A constant added to a column."""
    share = float(rng.choice([-1, 1]) * 10 ** rng.uniform(-2.5, 0))
    return values + share * np.ptp(values), f"+ {share:.2g} ranges"


@_of_compared
def drift(values: Array, rng: np.random.Generator) -> tuple[Array, str]:
    """A constant that grows over the log."""
    share = float(rng.choice([-1, 1]) * 10 ** rng.uniform(-2.5, 0))
    ramp = np.linspace(0.0, share * np.ptp(values), len(values))
    return values + ramp, f"drifts by {share:.2g} ranges"


@_of_any
def clipped(values: Array, rng: np.random.Generator) -> tuple[Array, str]:
    """A column cut off at the recorder's range."""
    share = float(rng.uniform(0.4, 0.95))
    middle, half = (values.max() + values.min()) / 2, share * np.ptp(values) / 2
    return np.clip(values, middle - half, middle + half), f"cut off at {share:.2f} of its range"


@_of_any
def spikes(values: Array, rng: np.random.Generator) -> tuple[Array, str]:
    """Single samples far off."""
    count, size = int(rng.integers(1, 30)), float(10 ** rng.uniform(-1.5, 1))
    rows = rng.choice(len(values), count, replace=False)
    values[rows] += size * np.ptp(values) * rng.choice([-1, 1], count)
    return values, f"with {count} spikes of {size:.2g} ranges"


@_of_any
def dropouts(values: Array, rng: np.random.Generator) -> tuple[Array, str]:
    """Samples without a number."""
    for rows in _stretches(len(values), rng, 0.05):
        values[rows] = np.nan
    return values, f"with {int(np.isnan(values).sum())} dropouts"


@_of_any
def zeros(values: Array, rng: np.random.Generator) -> tuple[Array, str]:
    """Samples lost, and written as 0."""
    stretches = _stretches(len(values), rng, 0.02)
    for rows in stretches:
        values[rows] = 0.0
    return values, f"with {len(stretches)} bursts of zeros"


def stale(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """Samples that repeat the last good one, of one column or of all."""
    roles = log.signals if rng.random() < 0.5 else [str(rng.choice(log.signals))]
    changed, count = {role: log.columns[role].copy() for role in roles}, 0
    for rows in _stretches(len(log), rng, 0.03, 10):
        count += rows.stop - rows.start
        for values in changed.values():
            values[rows] = values[rows.start - 1]
    return log.having(**changed), f"{count} rows repeat the last value of {', '.join(roles)}"


@_of_any
def lower_rate(values: Array, rng: np.random.Generator) -> tuple[Array, str]:
    """A column that is sampled less often than it is written."""
    every = int(rng.integers(2, 11))
    return values[np.arange(len(values)) // every * every], f"anew every {every} rows"


@_of_any
def shifted(values: Array, rng: np.random.Generator) -> tuple[Array, str]:
    """A column early or late by some samples."""
    by = int(rng.choice([-1, 1]) * rng.integers(1, 21))
    rows = np.clip(np.arange(len(values)) - by, 0, len(values) - 1)
    return values[rows], f"late by {by} samples"


def rows_lost(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """Rows lost; the time says so, or was counted by the logger that lost them."""
    kept = np.ones(len(log), dtype=bool)
    if rng.random() < 0.5:
        kept[rng.choice(len(log), int(rng.integers(1, 50)), replace=False)] = False
    else:
        for rows in _stretches(len(log), rng, 0.05):
            kept[rows] = False
    lost, found = int(np.sum(~kept)), log.rows(np.flatnonzero(kept))
    if rng.random() < 0.5:
        return found, f"{lost} rows lost"
    return found.counted(), f"{lost} rows lost, time counted"


def rows_doubled(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """Rows written twice; the time says so, or was counted."""
    twice = rng.choice(len(log), int(rng.integers(1, 50)), replace=False)
    found = log.rows(np.sort(np.concatenate([np.arange(len(log)), twice])))
    if rng.random() < 0.3:
        return found, f"{len(twice)} rows doubled"
    return found.counted(), f"{len(twice)} rows doubled, time counted"


def clock_step(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """A clock that is set while the log is written."""
    time, at = log.columns["time"].copy(), int(rng.integers(1, len(log)))
    by = float(rng.choice([-1, 1]) * log.period * 10 ** rng.uniform(-0.5, 4))
    time[at:] += by
    return log.having(time=time), f"the clock steps by {by:.3g} s"


def joined(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """Two logs in one: pieces one after the other that do not belong together."""
    n = len(log)
    a, b = int(rng.integers(n // 4, n)), int(rng.integers(0, 3 * n // 4))
    found = log.rows(np.concatenate([np.arange(a), np.arange(b, n)]))
    how = rng.choice(["time goes on", "time as it was", "time starts again"])
    if how == "time goes on":
        return found.counted(), "two logs joined, time goes on"
    time = found.columns["time"].copy()
    if how == "time starts again":
        time[a:] -= time[a]
    return found.having(time=time), f"two logs joined, {how}"


@_of_any
def quantised(values: Array, rng: np.random.Generator) -> tuple[Array, str]:
    """A converter or an encoder of few steps."""
    bits = int(rng.integers(5, 17))
    step = np.ptp(values) / 2**bits
    return step * np.round(values / step), f"of {bits} bit"


@_of_any
def smoothed(values: Array, rng: np.random.Generator) -> tuple[Array, str]:
    """A column that the logger has low-passed."""
    samples = float(rng.uniform(1.0, 20.0))
    kept = samples / (1 + samples)
    found, _ = lfilter([1 - kept], [1, -kept], values, zi=[kept * values[0]])
    return found, f"low-passed over {samples:.2g} samples"


@_of_any
def noisy(values: Array, rng: np.random.Generator) -> tuple[Array, str]:
    """Noise of a sensor or a converter."""
    share = float(10 ** rng.uniform(-4, -1))
    noise = share * np.ptp(values) * rng.normal(size=len(values))
    return values + noise, f"with noise of {share:.2g} ranges"


def hum(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """Mains, or another machine, in a column."""
    role = str(rng.choice(log.signals))
    values, share = log.columns[role], float(10 ** rng.uniform(-4, -1))
    at = float(rng.choice([16.7, 50.0, 60.0, 100.0]))
    wave = share * np.ptp(values) * np.sin(2 * np.pi * at * log.columns["time"])
    return log.having(**{role: values + wave}), f"{role} with {at:g} Hz of {share:.2g} ranges"


def jitter(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """Time stamps that are not quite those of the samples, or are rounded."""
    time = log.columns["time"]
    if rng.random() < 0.3:
        step = float(rng.choice([1.0, 2.0, 5.0, 10.0]) * log.period)
        return log.having(time=step * np.round(time / step)), f"time in steps of {step:g} s"
    share = float(10 ** rng.uniform(-3, -0.3))
    found = time + share * log.period * rng.uniform(-0.5, 0.5, len(log))
    return log.having(time=found), f"time jitters by {share:.2g} samples"


def decimated(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """A log of every few samples only."""
    every = int(rng.integers(2, 6))
    return log.rows(np.arange(0, len(log), every)), f"one row in {every} recorded"


def wrapped(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """A position that starts again after a length."""
    position = log.columns["position"]
    length = float(np.ptp(position) * rng.uniform(0.2, 0.9))
    return log.having(position=position % length), f"position modulo {length:.4g}"


@_of_any
def dead(values: Array, rng: np.random.Generator) -> tuple[Array, str]:
    """A column that stands still from some row on."""
    at = int(len(values) * rng.uniform(0.1, 0.98))
    values[at:] = values[at]
    return values, f"dead after {at} of {len(values)} rows"


def cut_short(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """A log that ends early, or begins late."""
    kept = int(len(log) * rng.uniform(0.02, 0.6))
    if rng.random() < 0.5:
        return log.rows(slice(0, kept)), f"the first {kept} rows only"
    return log.rows(slice(len(log) - kept, None)).counted(), f"the last {kept} rows only"


def wrong_gains(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """A control law declared with other gains than the drive's."""
    law = log.axis.control
    if law is None or not law.gains or log.signals[:3] != ["position", "reference", "control"]:
        return None
    name = str(rng.choice(sorted(law.gains)))
    factor = float(rng.choice([0.5, 0.9, 0.95, 1.05, 1.1, 2.0]))
    other = replace(law, gains={**law.gains, name: factor * law.gains[name]})
    return replace(log, axis=replace(log.axis, control=other)), f"{name} declared x {factor:g}"


def wrong_period(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """A control law declared with another period than the drive's."""
    law = log.axis.control
    if law is None:
        return None
    factor = float(rng.choice([0.5, 0.99, 0.998, 1.002, 1.01, 2.0]))
    other = replace(law, period=factor * law.period)
    return replace(log, axis=replace(log.axis, control=other)), f"period declared x {factor:g}"


def wrong_drive_gain(log: Log, rng: np.random.Generator) -> tuple[Log, str] | None:
    """A drive gain that is not the drive's; a force column shows it."""
    if not {"force", "control"} <= set(log.columns):
        return None
    factor = float(rng.choice([0.5, 0.8, 0.9, 0.97, 1.03, 1.1, 1.25, 2.0]))
    other = replace(log.axis.drive, gain=factor * log.axis.drive.gain)
    return replace(log, axis=replace(log.axis, drive=other)), f"drive gain declared x {factor:g}"


#: By name; each is drawn as often as the others. `rests` needs the loop simulated anew.
FAULTS: dict[str, Fault] = {
    "scale": scaled,
    "unit": unit,
    "sign": sign,
    "time base": time_base,
    "swapped": swapped,
    "offset": offset,
    "drift": drift,
    "clipped": clipped,
    "spikes": spikes,
    "dropouts": dropouts,
    "zeros": zeros,
    "stale": stale,
    "lower rate": lower_rate,
    "shifted": shifted,
    "rows lost": rows_lost,
    "rows doubled": rows_doubled,
    "clock step": clock_step,
    "joined": joined,
    "quantised": quantised,
    "smoothed": smoothed,
    "noise": noisy,
    "hum": hum,
    "jitter": jitter,
    "decimated": decimated,
    "wrapped": wrapped,
    "dead": dead,
    "cut short": cut_short,
    "law gains": wrong_gains,
    "law period": wrong_period,
    "drive gain": wrong_drive_gain,
}


def with_rests(axis: GeneratedAxis, rng: np.random.Generator) -> tuple[Log, str]:
    """The log of a twin that rests at its reversals, which is some share of the log."""
    law, experiment = axis.axis.control, axis.axis.experiment
    assert law is not None, "a twin has a law"
    assert experiment is not None, "a twin has an experiment"
    reference = trajectory(experiment.moves, law.period)
    steps = np.sign(np.diff(reference))
    turns = np.flatnonzero(steps[1:] * steps[:-1] < 0) + 1
    share = float(rng.uniform(0.2, 0.9))
    repeats = np.ones(len(reference), dtype=int)
    repeats[turns] += int(len(reference) * share / (1 - share)) // max(len(turns), 1)
    moved = np.repeat(reference, repeats)
    noise = rng.normal(0.0, experiment.position_noise, len(moved))
    truth = [experiment.truth.get(p.name, p.nominal) for p in axis.axis.parameters]
    loop = simulate(axis, truth, moved, law.period, position_noise=noise)
    columns = {
        "time": law.period * np.arange(len(moved)),
        "position": loop.measured_position,
        "reference": moved,
        "control": loop.control,
    }
    return right_log(axis, columns, "full"), f"at rest for {100 * share:.0f} % of the log"
