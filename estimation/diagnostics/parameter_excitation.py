"""What a record's motion shows of each parameter, and why it does not show the rest.

A parameter is vague for one of two reasons: its column nearly repeats others, or its part of the
force drowns in what the model leaves unexplained. What the motion lacks (a reversal, a second
speed, acceleration, travel) explains either.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.estimation_problem import Problem, SignalRanges, typical_magnitudes
from axisid.estimation.regression import Equations, Form, InverseForm
from axisid.estimation.signals import (
    FilteredRecord,
    Signals,
    columns_by_signal,
    one_direction,
    one_speed,
)
from axisid.estimation.thresholds import MAX_VARIANCE_INFLATION, MIN_ROWS_PER_PARAMETER
from axisid.support.arrays import Array, MaybeInfinite
from axisid.support.errors import first_case

_MIN_REPETITION_WEIGHT = 0.3  # of the largest, from which another column in a repetition is named
_MIN_ACCELERATION_SHARE = 0.05  # of the force; an axis with less hardly accelerates
# of a column by the position; with less the axis hardly leaves its place
_MIN_POSITION_VARIATION = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
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
        What the motion lacks of what this parameter acts by, in words: why, where it is vague.
        One that is not acts enough by the rest, as a mass does by its weight.
    rows : float
        How many rows as heavy as one another would tell of it what the rows do: few where the term
        acts in few.
    largest_share : float
        Its largest part of the force, anywhere along the record, over the largest force.
    natural : float
        What the force and the motion make of its unit, see `typical_magnitudes`.
    """

    name: str
    share: float
    inflation: MaybeInfinite
    alike: tuple[str, ...]
    lacking: tuple[str, ...]
    rows: float
    largest_share: float
    natural: float

    @property
    def reason(self) -> str:
        """Why the record does not show the parameter, for after "because"."""
        why = first_case(
            (self.alike, f"its column nearly repeats that of {', '.join(self.alike)}"),
            (
                self.rows < MIN_ROWS_PER_PARAMETER.value,
                f"it acts in few rows (as if in {self.rows:.2g})",
            ),
            (self.share >= 1, "others cancel its part of the force"),
            (True, "its part of the force drowns in what the model leaves unexplained"),
        )
        return f"{why}: {', and '.join(self.lacking)}" if self.lacking else why


def excitation(problem: Problem, physical: Array) -> tuple[Excitation, ...]:
    """Judge every parameter's column of the inverse model.

    What the motion of several records lacks, it lacks in all of them.

    Parameters
    ----------
    problem : Problem
    physical : (p,) array
        An estimate.
    """
    form = problem.form(InverseForm).at(physical)
    each = [form.of_record(i).equations(data.signals) for i, data in enumerate(problem.data)]
    equations = replace(problem, weights=()).reduced(form, [data.signals for data in problem.data])
    reach = SignalRanges.of(
        [
            (
                data.signals,
                replace(own, regressor=form.placed(i, own.intercept, own.regressor)[1]),
                data.sampling.kept,
            )
            for i, (data, own) in enumerate(zip(problem.data, each, strict=True))
        ]
    )
    # How much of a record's own columns is in those of all.
    mixed = [form.record_jacobian(i) != 0 for i in range(len(problem.data))]
    theta, names = form.regressed(physical), [q.name for q in form.quantities]
    anywhere, natural = np.zeros(len(names)), np.full(len(names), np.inf)
    if reach is not None:
        anywhere = np.abs(theta) * reach.columns / reach.force
        natural = typical_magnitudes(problem.axis, reach, form.declared)
    of_records = [columns_by_signal(data.axis) for data in problem.data]
    needs = {
        signal: np.any([own[signal] @ m for own, m in zip(of_records, mixed, strict=True)], axis=0)
        for signal in of_records[0]
    }
    X, weights = equations.regressor, problem.stacked(lambda data: data.sampling.weights)
    hardly = [
        _inertial_share(form, i, data, own, theta) < _MIN_ACCELERATION_SHARE
        for i, (data, own) in enumerate(zip(problem.data, each, strict=True))
    ]
    size = np.linalg.norm(X, axis=0)
    unit = X / np.where(size > 0, size, 1.0)
    shares = np.abs(theta) * size / np.linalg.norm(equations.left)
    found = []
    for j, name in enumerate(names):
        inflation, partners, rows = _repetition(unit, j)
        lacking = [
            _lacking(data.signals, X / weights[:, None], slow, needs, [j, *partners])
            for data, slow in zip(problem.data, hardly, strict=True)
        ]
        found.append(
            Excitation(
                name=name,
                share=float(shares[j]),
                inflation=inflation,
                alike=tuple(names[i] for i in partners),
                lacking=tuple(fact for fact in lacking[0] if all(fact in own for own in lacking)),
                rows=rows,
                largest_share=float(anywhere[j]),
                natural=float(natural[j]),
            )
        )
    return tuple(found)


def _repetition(unit: Array, j: int) -> tuple[float, list[int], float]:
    """Variance inflation of a column, those it is made of where that is large, and its rows.

    The rows are those of the part that is its own: the inverse of the sum of their squared weights.
    """
    others = [i for i in range(unit.shape[1]) if i != j]
    weights = np.linalg.lstsq(unit[:, others], unit[:, j], rcond=None)[0]
    left = unit[:, j] - unit[:, others] @ weights
    unexplained = float(left @ left)
    inflation = 1 / unexplained if unexplained > 0 else np.inf
    rows = unexplained**2 / float(np.sum(left**4)) if unexplained > 0 else 0.0
    if inflation < MAX_VARIANCE_INFLATION.value:
        return inflation, [], rows
    most = _MIN_REPETITION_WEIGHT * np.abs(weights).max(initial=0.0)
    return inflation, [i for i, w in zip(others, weights, strict=True) if abs(w) > most], rows


def _inertial_share(
    form: Form, record: int, data: FilteredRecord, moving_rows: Equations, theta: Array
) -> float:
    """Norm of the force that accelerates, known terms too, over that of the modelled force."""

    def force(rows: Equations) -> Array:
        intercept, columns = form.placed(record, rows.intercept, rows.regressor)
        return (intercept + columns @ theta)[data.sampling.kept]

    coasting = replace(data.signals, acceleration=np.zeros_like(data.signals.acceleration))
    moving, steady = force(moving_rows), force(form.of_record(record).equations(coasting))
    return float(np.linalg.norm(moving - steady) / np.linalg.norm(moving))


def _lacking(
    signals: Signals,
    X: Array,
    slow: bool,
    needs: dict[str, NDArray[np.bool_]],
    columns: Sequence[int],
) -> tuple[str, ...]:
    needed = {signal for signal, of in needs.items() if of[[*columns]].any()}
    placed = [X[:, j] for j in columns if needs["position"][j] and not needs["acceleration"][j]]
    still = any(np.ptp(x) < _MIN_POSITION_VARIATION * np.abs(x).max() for x in placed)
    facts = (
        ({"velocity", "direction"} & needed, one_direction(signals)),
        ("velocity" in needed, one_speed(signals)),
        (slow and "acceleration" in needed, "the axis hardly accelerates"),
        (still, "the axis hardly leaves its place"),
    )
    return tuple(fact for holds, fact in facts if holds and fact)
