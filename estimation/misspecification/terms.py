"""Table of terms that a model may lack: forces along a motion, with their names.

The same terms are searched for an inverse model and for a fit of outputs. Each term makes its
columns from a motion. A term that depends on a further number nonlinearly has a grid of places:
Stribeck velocities, periods, or antiresonances. `axisid.presentation.sentences` describes each
term, and names the element that declares it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.signals import Span
from axisid.support.arrays import Array
from axisid.support.errors import UsageError
from axisid.support.wording import quoted

_WAVES_APART = 0.75  # difference of the wave numbers of two periods, in waves over the travel
_SLOWEST, _FASTEST = 3.0, 120.0  # Hz, of an antiresonance
_APART = 1.25  # ratio of one antiresonance to the next
_BETWEEN = 97  # number of frequencies, or speeds, of the refined search


@dataclass(frozen=True, kw_only=True, eq=False)
class Along:
    """A motion of N samples along which forces act, and the reduction of forces to n rows.

    Attributes
    ----------
    time, position, velocity, acceleration, direction, force : (N,) array
        Signals at the samples, SI. Time and position are relative to their means over the rows;
        direction is the sign of the velocity as the friction of the model reads it.
    spans : sequence of (int, int)
        Stretches between gaps: first sample and the one after the last.
    rows : (n,) array of int, optional
        Sample number of each row; all samples are rows by default.
    reduce : callable
        Filters and decimates values (N,) or (N, m) to the rows.
    period : float
        Sample period, s.
    row_period : float
        Time between rows, s.
    middle : float
        Mean that was subtracted from the positions. The force of a spring needs this mean, because
        the spring rests at another position.
    """

    time: Array
    position: Array
    velocity: Array
    acceleration: Array
    direction: Array
    force: Array
    spans: Sequence[Span]
    period: float
    row_period: float
    rows: NDArray[np.int64] | None = None
    reduce: Callable[[Array], Array] = field(default_factory=lambda: np.asarray)
    middle: float = 0.0

    @cached_property
    def place(self) -> Array:
        """Position of the rows, (n,)."""
        return self.position if self.rows is None else self.position[self.rows]

    def waves(self, factor: Array, periods: Array) -> Array:
        """Return cosine and sine over the position for m periods, times a factor: (n, m, 2).

        The factor, (N,), is reduced to the rows; cosine and sine are those of the rows' positions.
        """
        angle = 2 * np.pi * self.place[:, None] / periods
        waves = np.stack([np.cos(angle), np.sin(angle)], axis=2)
        return np.asarray(self.reduce(factor)[:, None, None] * waves, dtype=float)

    def by_stretch(self, change: Callable[[Array], Array], values: Array) -> Array:
        """Return values, (N,), transformed in each stretch between gaps separately; zero in gaps.

        `change` is the transformation of the values of one stretch.
        """
        found = np.zeros_like(values)
        for first, last in self.spans:
            found[first:last] = change(values[first:last])
        return found


@dataclass(frozen=True, kw_only=True, eq=False)
class Term:
    """A force that a model may lack.

    Attributes
    ----------
    kind : str
        Name of the term in `TERMS`.
    unit : str
        Unit of the term's size, in ``{force}`` and the coordinate's ``{unit}``; empty if no size is
        reported.
    columns : callable
        Returns columns for a motion and places (m,): (n, m, g), g columns for each place, as
        resisting forces.
    what : str, optional
        Name of the term in a sentence, with the place of the grid, ``{at}``, for a term of your
        own. The built-in terms have their sentences in `axisid.presentation.sentences`.
    declare : str, optional
        Instruction to declare the term, with the coordinate's name, ``{q}``, and the place,
        ``{at}``, for a term of your own.
    places : callable, optional
        Returns the grid of places for a motion; a single place by default.
    between : callable, optional
        Returns places near a place of the grid, from the grid and this place.
    opposite : (str, str), optional
        `what` and `declare` for a negative size, for a term of your own.
    is_positive : bool
        True if the size must be positive, as for friction, a dead band or a mass.
    is_by_direction : bool
        True if the size is the forward value of a parameter minus its backward value.
    is_of_force : bool
        True if the columns are made from the force or the acceleration. The noise of a measured
        force is also in the residuals, so the term is searched only along simulated loops.
    is_of_command : bool
        True if the drive makes the term from the command, so that a measured force does not contain
        it.
    is_lost : bool
        True if the columns are the part of the command that the drive does not give. The force is
        smaller by this part, and the place alone determines the size of the term.
    """

    kind: str
    unit: str
    columns: Callable[[Along, Array], Array]
    what: str = ""
    declare: str = ""
    places: Callable[[Along], Array] = lambda _: np.array([np.nan])
    between: Callable[[Array, float], Array] | None = None
    opposite: tuple[str, str] | None = None
    is_positive: bool = False
    is_by_direction: bool = False
    is_of_force: bool = False
    is_of_command: bool = False
    is_lost: bool = False

    def __post_init__(self) -> None:
        """Refuse texts with placeholders that no sentence can fill in."""
        words = dict.fromkeys(("q", "unit", "drive", "force"), "") | dict.fromkeys(
            ("at", "rigid", "band", "limit"), 0.0
        )
        try:
            self.unit.format(unit="", force="")
            for text in (self.what, self.declare, *(self.opposite or ())):
                text.format(**words)
        except (LookupError, ValueError, AttributeError) as error:
            raise UsageError(
                f"the placeholders in the texts of the candidate {quoted(self.kind)} cannot be "
                f"filled in ({type(error).__name__}: {error}). Use only {{q}}, {{unit}}, "
                "{drive}, {force} and {at} in its texts, and {force} and {unit} in its unit.",
                code="candidate",
            ) from error


def wave_periods(s: Along) -> Array:
    """Return the periods of waves over the position that are tested, in the coordinate's unit.

    The longest period is the travel: longer waves are slopes and bends. No period is shorter than
    1/60 of the travel. At its median speed, the axis passes each period in at least four rows and
    in at least 1/25 s. Empty for an axis that does not move.
    """
    travel = float(np.ptp(s.place))
    usual = float(np.median(np.abs(s.velocity[s.velocity != 0]))) if s.velocity.any() else 0.0
    shortest = usual * max(1 / 25.0, 4.0 * s.row_period)  # at most 25 Hz, at least four rows
    most = min(60, travel / shortest) if shortest > 0 else 0.0
    return np.asarray(travel / np.arange(1.0, most, _WAVES_APART), dtype=float)


def _periods_near(periods: Array, at: float) -> Array:
    """Return periods about the period `at`, equally spaced in wave number, up to the travel."""
    near = 1 / at + _WAVES_APART / periods[0] * np.linspace(-0.5, 0.5, 15)
    return np.asarray(1 / near[near >= 1 / periods[0]], dtype=float)  # longer waves are slopes


def antiresonances(s: Along) -> Array:
    """Return the antiresonance frequencies that are tested for a load behind a spring, (m,), Hz.

    The frequencies are 3 to 120 Hz, as far as the sample period can resolve them.
    """
    last = min(_FASTEST, 1 / (7.0 * s.period))  # seven samples in an oscillation
    many = int(np.log(last / _SLOWEST) / np.log(_APART)) + 1 if last > _SLOWEST else 0
    return np.asarray(_SLOWEST * _APART ** np.arange(many), dtype=float)


def behind_spring(s: Along, frequencies: Array) -> Array:
    """Return the acceleration of a load behind a spring minus that of the axis, (N, m).

    There is one load for each of m antiresonance frequencies, Hz. It follows the axis as a damped
    second-order low-pass.
    """
    from scipy.signal import bilinear, lfilter

    found = []
    for rate in 2 * np.pi * frequencies:
        # Exact at the frequency, with enough damping to be found between places of the grid.
        c, damped = rate / np.tan(rate * s.period / 2), 2 * 0.1 * rate
        b, a = bilinear([damped, rate**2], [1.0, damped, rate**2], fs=c / 2)
        found.append(s.by_stretch(partial(lfilter, b, a), s.acceleration))
    return np.stack(found, axis=1) - s.by_stretch(np.asarray, s.acceleration)[:, None]


def _one(shape: Callable[[Along], Array]) -> Callable[[Along, Array], Array]:
    """Return the function `columns` of a term with one column and no place.

    `shape` returns the force of the term along a motion, (N,).
    """
    return lambda s, _: s.reduce(shape(s))[:, None, None]


def _waves(factor: Callable[[Along], Array]) -> Callable[[Along, Array], Array]:
    """Return the function `columns` of a term with waves over the position, times a factor.

    `factor` returns the factor along a motion, (N,).
    """
    return lambda s, periods: s.waves(factor(s), periods)


def _ones(s: Along) -> Array:
    """Return a constant force of 1 along a motion, (N,)."""
    return np.ones_like(s.velocity)


def _pushes(s: Along) -> Array:
    """Return the sign of the acceleration, (N,); a small acceleration has the last sign."""
    size = np.abs(s.acceleration)
    sign = np.where(size > 0.05 * size.max(), np.sign(s.acceleration), 0.0)
    return np.asarray(sign[np.maximum.accumulate(np.where(sign != 0, np.arange(len(sign)), 0))])


def _after(
    sign: Callable[[Along], Array], times: Sequence[float], signed: bool, s: Along, _: Array
) -> Array:
    """Return exponential decays after each change of a sign, in the rows, (n, 1, g).

    Parameters
    ----------
    sign : callable
        Returns the sign along a motion, (N,).
    times : sequence of float
        Time constants of the decays, s.
    signed : bool
        True if further columns have the decays without the sign.
    s : Along
        The motion.
    """
    signs, number = sign(s), np.arange(len(s.time))
    turns = np.diff(signs, prepend=signs[0]) != 0
    since = s.period * (number - np.maximum.accumulate(np.where(turns, number, 0)))
    decays = np.exp(-since[:, None] / times)
    columns = [signs[:, None] * decays]
    if signed:
        columns.append(decays)
    return s.reduce(np.hstack(columns))[:, None]


# Quantile of the commanded force that is the usual largest command. A level above it would be
# exceeded in a few samples only.
_USUALLY_LARGEST = 0.98
_LEVELS = np.geomspace(0.05, 0.95, 40)  # tested limits relative to the usual largest command


def saturation_levels(s: Along) -> Array:
    """Return the limits of the drive's force that are tested, (m,).

    They are 5 to 95 % of the usual largest command, which all commands but 2 % do not exceed.
    """
    size = np.abs(s.force)
    return np.asarray(
        _LEVELS * float(np.quantile(size[size > 0], _USUALLY_LARGEST, method="lower"))
    )


def beyond_levels(s: Along, levels: Array) -> Array:
    """Return the part of the commanded force beyond each of m levels, (N, m).

    A drive with that level as its limit does not give this part.
    """
    force = s.force[:, None]
    return np.asarray(np.sign(force) * np.maximum(np.abs(force) - levels, 0.0))


_TERMS = (
    Term(
        kind="constant",
        unit="{force}",
        columns=_one(_ones),
    ),
    Term(
        kind="coulomb",
        unit="{force}",
        columns=_one(lambda s: s.direction),
        is_positive=True,
    ),
    Term(
        kind="viscous",
        unit="{force}/({unit}/s)",
        columns=_one(lambda s: s.velocity),
        is_positive=True,
    ),
    Term(
        kind="inertia",
        unit="{force}/({unit}/s^2)",
        columns=_one(lambda s: s.acceleration),
        is_of_force=True,
    ),
    Term(
        kind="direction",
        unit="{force}/({unit}/s)",
        columns=_one(lambda s: np.abs(s.velocity) / 2),
        is_by_direction=True,
    ),
    Term(
        kind="quadratic",
        unit="{force}/({unit}/s)^2",
        columns=_one(lambda s: s.velocity * np.abs(s.velocity)),
    ),
    Term(
        kind="stribeck",
        unit="{force}",
        columns=lambda s, widths: s.reduce(
            s.direction[:, None] * np.exp(-np.abs(s.velocity)[:, None] / widths)
        )[:, :, None],
        places=lambda s: np.geomspace(0.015, 0.5, 8) * np.abs(s.velocity).max(),
        between=lambda grid, _: np.geomspace(grid[0], grid[-1], _BETWEEN),
    ),
    Term(
        kind="slope",
        unit="{force}/{unit}",
        columns=_one(lambda s: s.position + s.middle),
    ),
    Term(
        kind="bend",
        unit="{force}/{unit}^2",
        columns=_one(lambda s: s.position**2),
    ),
    Term(
        kind="turn",
        unit="{force}",
        columns=_waves(_ones),
        places=lambda _: np.array([2 * np.pi]),
    ),
    Term(
        kind="place",
        unit="{force}",
        columns=_waves(_ones),
        places=wave_periods,
        between=_periods_near,
    ),
    Term(
        kind="friction slope",
        unit="{force}/{unit}",
        columns=_one(lambda s: s.direction * s.position),
    ),
    Term(
        kind="friction bend",
        unit="{force}/{unit}^2",
        columns=_one(lambda s: s.direction * s.position**2),
    ),
    Term(
        kind="friction place",
        unit="{force}",
        columns=_waves(lambda s: s.direction),
        places=wave_periods,
        between=_periods_near,
    ),
    Term(
        kind="resonance",
        unit="",
        columns=lambda s, at: s.reduce(behind_spring(s, at))[:, :, None],
        places=antiresonances,
        between=lambda grid, _: np.geomspace(grid[0], grid[-1], _BETWEEN),
        is_positive=True,
        is_of_force=True,
    ),
    Term(
        kind="delay",
        unit="s",
        columns=_one(lambda s: s.by_stretch(np.gradient, s.force) / s.period),
        is_of_force=True,
    ),
    Term(
        kind="loss",
        unit="",
        # The force times the sign of its power, and its size.
        columns=lambda s, _: s.reduce(
            np.stack([np.sign(s.force * s.velocity) * s.force, np.abs(s.force)], axis=1)
        )[:, None],
        is_of_force=True,
    ),
    Term(
        kind="presliding",
        unit="",
        columns=partial(_after, lambda s: s.direction, (0.02,), True),
    ),
    Term(
        kind="backlash",
        unit="",
        columns=partial(_after, _pushes, (0.01, 0.03), False),
        is_of_force=True,
    ),
    Term(
        kind="dead band",
        unit="{force}",
        columns=_one(lambda s: np.sign(s.force)),
        is_positive=True,
        is_of_force=True,
        is_of_command=True,
    ),
    Term(
        kind="saturation",
        unit="",
        columns=lambda s, levels: s.reduce(beyond_levels(s, levels))[:, :, None],
        places=saturation_levels,
        between=lambda grid, _: np.geomspace(grid[0], grid[-1], _BETWEEN),
        is_positive=True,
        is_of_command=True,
        is_lost=True,
    ),
)


#: Terms of the search, by kind; terms that are added are searched as well.
TERMS: dict[str, Term] = {term.kind: term for term in _TERMS}
