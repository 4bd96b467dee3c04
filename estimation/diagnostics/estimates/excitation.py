"""What a record's motion shows of each parameter, and why it does not show the rest.

A parameter is vague for one of two reasons: its column nearly repeats others, or its part of the
force drowns in what the model leaves unexplained. What the motion lacks (a reversal, a second
speed, acceleration, travel) explains either.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate, Value
from axisid.estimation.problems import Problem, Reach, natural_sizes
from axisid.estimation.regression import InverseForm
from axisid.estimation.signals import Signals, dependence, one_direction, one_speed
from axisid.estimation.thresholds import (
    MAX_RELATIVE_DEVIATION,
    MAX_VARIANCE_INFLATION,
    MIN_ROWS_PER_PARAMETER,
    NEGLIGIBLE_FORCE,
    NEGLIGIBLE_PEAK_FORCE,
)
from axisid.support.arrays import Array

_MIN_REPETITION_WEIGHT = 0.3  # of the largest, from which another column in a repetition is named
_MIN_ACCELERATION_SHARE = 0.05  # of the force; a term that takes acceleration and has less says so
# of a column by the position; with less the axis hardly leaves its place
_MIN_POSITION_VARIATION = 0.1
_NEGLIGIBLE_SIZE = 0.1  # of a vague parameter, in what force and motion make of its unit


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
        elif self.rows < MIN_ROWS_PER_PARAMETER.value:
            why = f"it acts in few rows (as if in {self.rows:.2g})"
        else:
            why = (
                f"its part of the force ({100 * self.share:.2g} %) drowns in what the model leaves "
                "unexplained"
                if self.share < 1
                else "others cancel its part of the force"
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
    unweighted = replace(problem, weights=())
    equations = unweighted.reduced(form, [data.signals for data in problem.data])
    reach = Reach.of(
        [
            (
                data.signals,
                replace(own, regressor=form.placed(i, own.intercept, own.regressor)[1]),
                data.kept,
            )
            for i, (data, own) in enumerate(zip(problem.data, each, strict=True))
        ]
    )
    # How much of a record's own columns is in those of all.
    mixed = [np.abs(form.slopes(i)) for i in range(len(problem.data))]
    theta, names = form.regressed(physical), [q.name for q in form.quantities]
    anywhere, natural = np.zeros(len(names)), np.full(len(names), np.inf)
    if reach is not None:
        anywhere = np.abs(theta) * reach.columns / reach.force
        natural = natural_sizes(problem.axis, reach, form.declared)
    of_records = [dependence(data.axis) for data in problem.data]
    needs = {
        signal: np.any(
            [own[signal] @ (m > 0) for own, m in zip(of_records, mixed, strict=True)], axis=0
        )
        for signal in of_records[0]
    }
    X, weights = equations.regressor, problem.stacked(lambda data: data.weights)
    size = np.linalg.norm(X, axis=0)
    unit = X / np.where(size > 0, size, 1.0)
    shares = np.abs(theta) * size / np.linalg.norm(equations.left)
    found = []
    for j, name in enumerate(names):
        inflation, partners, rows = _repetition(unit, j)
        lacking = [
            _lacking(data.signals, X / weights[:, None], shares, needs, [j, *partners])
            for data in problem.data
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
        facts.append(one_direction(signals))
    if need("velocity"):
        facts.append(one_speed(signals))
    if any(needs["acceleration"][j] and shares[j] < _MIN_ACCELERATION_SHARE for j in columns):
        facts.append("the axis hardly accelerates")
    placed = [j for j in columns if needs["position"][j] and not needs["acceleration"][j]]
    if any(np.ptp(X[:, j]) < _MIN_POSITION_VARIATION * np.abs(X[:, j]).max() for j in placed):
        facts.append("the axis hardly leaves its place")
    return tuple(fact for fact in facts if fact)


def precision(estimate: Estimate, excitation: Sequence[Excitation]) -> Check:
    """Every parameter against its own deviation; a vague one with the reason."""
    values, relative = estimate.parameters, dict[str, float]()
    for s in excitation:
        value = values[s.name]
        # In few rows residuals are small since the estimate follows them.
        few = s.rows < MIN_ROWS_PER_PARAMETER.value
        deviation = max(value.deviation, value.sd) if few else value.deviation
        relative[s.name] = 100 * deviation / abs(value.corrected) if value.corrected else np.inf
    vague = [s for s in excitation if relative[s.name] > MAX_RELATIVE_DEVIATION.value]
    small = [s for s in vague if _is_nothing(s, values[s.name])]
    unclear = [s for s in vague if s not in small]
    return precision_check(
        max(relative.values()),
        [f"{s.name} is not identified by this record, because {s.reason}" for s in unclear],
        [s.name for s in small],
        "force",
        "relative HAC deviation in percent, or the i.i.d. one where it is larger and few "
        "rows tell of the parameter; one whose part of the force is below 1 %, deviation "
        "included, may be as vague as it is, unless it could be as large as the unit allows",
    )


def precision_check(
    worst: float, unclear: Sequence[str], small: Sequence[str], of: str, source: str
) -> Check:
    """The check of parameters against their deviations.

    Parameters
    ----------
    worst : float
        Largest relative deviation, %.
    unclear : sequence of str
        What is said of each parameter that is not known.
    small : sequence of str
        Names of those that are as vague, and matter little.
    of : str
        What these are less than 1 % of.
    source : str
        What the figure is.
    """
    clear = "every parameter stands well above its deviation"
    if small:
        clear = (
            f"{', '.join(small)} cannot be told from zero and is less than 1 % of the {of}; every "
            "other parameter stands well above its deviation"
        )
    return Check(
        name="precision",
        status=passed(not unclear),
        figure=worst if np.isfinite(worst) else None,
        threshold=MAX_RELATIVE_DEVIATION.value,
        source=source,
        meaning="; ".join(unclear) or clear,
    )


def _is_nothing(excitation: Excitation, value: Value) -> bool:
    """Known to be small, not unknown: no other column and no missing motion hides it.

    A term that acts beyond the rows, or beyond the motion, is small in them whatever it is.
    """
    if excitation.alike or excitation.lacking or not value.value:
        return False
    largest = abs(value.value) + 2 * max(value.deviation, value.sd)
    times = largest / abs(value.value)
    return (
        excitation.share * times < NEGLIGIBLE_FORCE.value
        and excitation.largest_share * times < NEGLIGIBLE_PEAK_FORCE.value
        and largest < _NEGLIGIBLE_SIZE * excitation.natural
    )
