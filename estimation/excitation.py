"""What a record's motion shows of each parameter, and why it does not show the rest.

A parameter is vague for one of two reasons: its column nearly repeats others, or its part of the
force drowns in what the model leaves unexplained. What the motion lacks (a reversal, a second
speed, acceleration, travel) explains either.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.codegen import GeneratedAxis

from .arrays import Array, runs
from .forms import Equations
from .prefilter import Prefilter
from .record import Record
from .reversals import REST
from .shown import Reach, natural_sizes
from .signals import Signals
from .without_turns import dependence

#: Rows for each parameter below which deviations cannot be believed.
FEW_ROWS = 10
_FEWEST = 16  # samples at steady speed
_MOVING = 0.05  # of the largest speed
_STILL = 0.01  # of the largest speed, which noise may make of a rest
_REVERSED = 0.01  # of the samples in motion
_ONE_SPEED = 0.1  # spread of the cruising speed, relative
_STEADY = 0.1  # of the largest acceleration
_ALIKE = 10.0  # variance inflation from which a column nearly repeats others
_PARTNER = 0.3  # of the largest weight in the repetition
_SMALL = 0.05  # share of the force
_SAME_PLACE = 0.1  # variation of a column that depends on the position, relative


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Excitation:
    """What the motion shows of one parameter.

    Attributes
    ----------
    name : str
    share : float
        Norm of its part of the force over that of the force.
    inflation : float
        Variance inflation: 1 for a column unlike all others, large for one that nearly repeats
        them.
    alike : tuple of str
        The parameters whose columns it nearly repeats.
    lacking : tuple of str
        What of the motion this parameter would need, in words; empty if nothing is known to lack.
    rows : float
        How many rows as heavy as one another would tell of it what the rows do: few where the term
        acts in few.
    largest_share : float
        Its largest part of the force, anywhere along the record, over the largest force.
    natural : float
        What the force and the motion make of its unit, see `natural_sizes`.
    """

    name: str
    share: float
    inflation: float
    alike: tuple[str, ...]
    lacking: tuple[str, ...]
    rows: float
    largest_share: float
    natural: float

    def __repr__(self) -> str:
        alike = f", like {' and '.join(self.alike)}" if self.alike else ""
        lacking = f", {' and '.join(self.lacking)}" if self.lacking else ""
        return f"{self.name}: {100 * self.share:.3g} % of the force{alike}{lacking}"

    @property
    def reason(self) -> str:
        """Why the record does not show the parameter, for after "because"."""
        if self.alike:
            why = f"its column nearly repeats that of {', '.join(self.alike)}"
        elif self.rows < FEW_ROWS:
            why = f"it acts in few rows (as if in {self.rows:.2g})"
        else:
            why = (
                f"its part of the force ({100 * self.share:.2g} %) drowns in what the model leaves "
                "unexplained"
                if self.share < 1
                else "others cancel its part of the force"
            )
        return f"{why}: {', and '.join(self.lacking)}" if self.lacking else why


def excitation(
    axis: GeneratedAxis,
    signals: Signals,
    equations: Equations,
    weights: Array,
    physical: Array,
    reach: Reach | None,
) -> tuple[Excitation, ...]:
    """Judge every parameter's column of the inverse model.

    Parameters
    ----------
    axis : GeneratedAxis
    signals : Signals
        Measured, (N,).
    equations : Equations
        Of the inverse form, reduced, (n,).
    weights : (n,) array
        Of the rows, as `Prefilter.weights` has them.
    physical : (p,) array
        An estimate.
    reach : Reach or None
        Of the force and of each column along the record, with that estimate.
    """
    X = equations.regressor
    size = np.linalg.norm(X, axis=0)
    unit = X / np.where(size > 0, size, 1.0)
    shares = np.abs(physical) * size / np.linalg.norm(equations.left)
    needs, nowhere = dependence(axis), np.zeros(len(physical))
    anywhere = nowhere if reach is None else np.abs(physical) * reach.columns / reach.force
    natural = nowhere + np.inf if reach is None else natural_sizes(axis, reach)
    found = []
    for j, name in enumerate(axis.names):
        inflation, partners, rows = _repetition(unit, j)
        together = [j, *partners]
        found.append(
            Excitation(
                name=name,
                share=float(shares[j]),
                inflation=inflation,
                alike=tuple(axis.names[i] for i in partners),
                lacking=_lacking(signals, X / weights[:, None], shares, needs, together),
                rows=rows,
                largest_share=float(anywhere[j]),
                natural=float(natural[j]),
            )
        )
    return tuple(found)


def motion_lacks(signals: Signals) -> tuple[str, ...]:
    """What a motion lacks, in words, whatever the axis."""
    facts = (_one_direction(signals), _one_speed(signals))
    return tuple(fact for fact in facts if fact)


def resting(signals: Signals, record: Record, prefilter: Prefilter) -> float:
    """Part of the samples of a fit, signals (N,), at which the axis stands still."""
    used = prefilter.kept(len(record), record.period)
    for start, stop in prefilter.silent:
        used[start:stop] = False
    still, fastest = np.zeros(len(record), dtype=bool), float(np.abs(signals.velocity).max())
    for first, last in record.spans:
        speed = signals.velocity[first:last]
        for start, stop in runs(np.abs(speed) < _MOVING * fastest):
            # It stops and starts slowly. Creeping gets somewhere, reversing does not stay.
            within = slice(start + (stop - start) // 4, stop - (stop - start) // 4)
            drift = abs(float(np.mean(speed[within])))
            stays = float(np.mean(np.abs(speed[within]))) < _STILL * fastest
            still[first + start : first + stop] = stays and drift < REST * fastest
    return float(np.mean(still[used])) if used.any() else 0.0


def _repetition(unit: Array, j: int) -> tuple[float, list[int], float]:
    """Variance inflation of a column, those it is made of where that is large, and its rows.

    The rows are those of the part that is its own: the inverse of the sum of their squared weights.
    """
    others = [i for i in range(unit.shape[1]) if i != j]
    if not others:
        return 1.0, [], _rows_of(unit[:, j])
    weights = np.linalg.lstsq(unit[:, others], unit[:, j], rcond=None)[0]
    left = unit[:, j] - unit[:, others] @ weights
    unexplained = float(left @ left)
    inflation = 1 / unexplained if unexplained > 0 else np.inf
    if inflation < _ALIKE:
        return inflation, [], _rows_of(left)
    most = np.abs(weights).max()
    alike = [i for i, w in zip(others, weights, strict=True) if abs(w) > _PARTNER * most]
    return inflation, alike, _rows_of(left)


def _rows_of(column: Array) -> float:
    """How many rows of equal size a column is as good as."""
    size = float(np.linalg.norm(column))
    return 1.0 / float(np.sum((column / size) ** 4)) if size > 0 else 0.0


def _lacking(
    signals: Signals,
    X: Array,
    shares: Array,
    needs: dict[str, NDArray[np.bool_]],
    columns: Sequence[int],
) -> tuple[str, ...]:
    def need(*names: str) -> bool:
        return any(bool(needs[name][j]) for name in names for j in columns)

    facts: list[str] = []
    if need("velocity", "direction"):
        facts.append(_one_direction(signals))
    if need("velocity"):
        facts.append(_one_speed(signals))
    if any(needs["acceleration"][j] and shares[j] < _SMALL for j in columns):
        facts.append("the axis hardly accelerates")
    placed = [j for j in columns if needs["position"][j] and not needs["acceleration"][j]]
    if any(np.ptp(X[:, j]) < _SAME_PLACE * np.abs(X[:, j]).max() for j in placed):
        facts.append("the axis hardly leaves its place")
    return tuple(fact for fact in facts if fact)


def _one_direction(signals: Signals) -> str:
    moving = signals.velocity[_in_motion(signals)]
    forward = float(np.mean(moving > 0)) if len(moving) else 0.0
    if _REVERSED <= forward <= 1 - _REVERSED:
        return ""
    return f"the velocity {'never' if forward in (0, 1) else 'hardly ever'} changes its sign"


def _one_speed(signals: Signals) -> str:
    """One cruising speed; accelerating through others in between does not tell them apart well."""
    steady = np.abs(signals.acceleration) < _STEADY * np.abs(signals.acceleration).max()
    speeds = np.abs(signals.velocity[_in_motion(signals) & steady])
    if len(speeds) < _FEWEST:
        return ""
    low, middle, high = np.quantile(speeds, [0.1, 0.5, 0.9])
    return "there is one speed only" if high - low < _ONE_SPEED * middle else ""


def _in_motion(signals: Signals) -> NDArray[np.bool_]:
    speed = np.abs(signals.velocity)
    return np.asarray(speed > _MOVING * speed.max())
