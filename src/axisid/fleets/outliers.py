"""Axes whose parameters are not those of the others, beyond what their deviations explain."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from axisid.estimation.thresholds import FLEET_LEVEL
from axisid.support.arrays import Array
from axisid.support.errors import Missing
from axisid.support.mappings import grouped

from .ledger import FleetRow
from .robust_centre import RandomEffects, detect_outliers, spread_of

_MIN_LOGS_PER_PARAMETER = 5  # with fewer, half of the logs hardly tell a scatter
_FAR = 1e3  # median deviations


@dataclass(frozen=True, slots=True, kw_only=True)
class Outlier:
    """A log whose parameters are not those of the others.

    Attributes
    ----------
    name : str
        Of the row.
    distance : float
        Robust distance in deviations, all parameters together.
    p_value : float
        Of a distance as large or larger of a log like the others.
    parameter : str
        The one that is furthest from the centre by itself.
    apart : float
        How far, in deviations.
    """

    name: str
    distance: float
    p_value: float
    parameter: str
    apart: float


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisGroup:
    """Logs of one axis, with the same parameters.

    Attributes
    ----------
    axis : str
    names, units : tuple of str
        Of the parameters.
    rows : tuple of FleetRow
    machines : int
        That are held against one another: each log its own, unless serial numbers say otherwise.
    untold : int
        Logs that are not, since no serial number says of which machine they are.
    usual : RandomEffects or Missing
    outliers : tuple of Outlier
        The furthest first.
    """

    axis: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    rows: tuple[FleetRow, ...]
    machines: int
    untold: int
    usual: RandomEffects | Missing
    outliers: tuple[Outlier, ...]


def groups_of(rows: Iterable[FleetRow]) -> tuple[AxisGroup, ...]:
    """The rows with a result by axis and parameters, without those that cannot be compared."""
    found = grouped(
        ((row.axis, tuple(row.parameters)), row)
        for row in rows
        if row.has_result and row.is_comparable
    )
    groups = []
    for (axis, names), each in found.items():
        machines = _machines(each)
        usual, outliers = _judged(names, machines)
        groups.append(
            AxisGroup(
                axis=axis,
                names=names,
                units=tuple(value.unit for value in each[0].parameters.values()),
                rows=tuple(each),
                machines=len(machines),
                untold=len(each) - sum(map(len, machines)),
                usual=usual,
                outliers=outliers,
            )
        )
    return tuple(groups)


def _machines(rows: Sequence[FleetRow]) -> list[list[FleetRow]]:
    """The logs of each machine, where serial numbers tell several; else each log by itself.

    Logs of one machine have its scatter from the others in common: taken as machines of their own
    they would make the others stand out, so that a log whose machine is not told is left out where
    others have several. Those of one machine alone are held against one another.
    """
    found = grouped((row.serial, row) for row in rows)
    told = [each for serial, each in found.items() if serial]
    if len(told) > 1 and max(map(len, told)) > 1:
        return told
    return [[row] for row in rows]


def _judged(
    names: Sequence[str], machines: Sequence[Sequence[FleetRow]]
) -> tuple[RandomEffects | Missing, tuple[Outlier, ...]]:
    values = np.array(
        [np.mean([[v.value for v in r.parameters.values()] for r in each], 0) for each in machines]
    )
    least, logs = _MIN_LOGS_PER_PARAMETER * max(len(names), 1), sum(map(len, machines))
    if len(machines) < least:
        count, enough = "1 log is" if logs == 1 else f"{logs} logs are", f"{least}"
        if logs > len(machines):
            count, enough = f"{logs} logs of {len(machines)} machines are", f"{least} machines"
        each = f"{_MIN_LOGS_PER_PARAMETER} for each parameter"
        return Missing(f"{count} too few to tell which stand out; {enough} do, {each}"), ()
    if not _is_spread(values):
        return Missing("the values of the logs lie in fewer dimensions than parameters"), ()
    covariances = np.array(
        [np.mean([row.covariance for row in each], axis=0) / len(each) for each in machines]
    )
    alike = detect_outliers(values, covariances, FLEET_LEVEL.value)
    outliers = []
    for i in alike.far:
        scatter = np.sqrt(np.diag(alike.usual.between + covariances[i]))
        scores = (values[i] - alike.usual.centre) / scatter
        furthest = int(np.argmax(np.abs(scores)))
        outliers += [
            Outlier(
                name=row.name,
                distance=float(np.sqrt(alike.distances[i])),
                p_value=float(alike.p_values[i]),
                parameter=names[furthest],
                apart=float(scores[furthest]),
            )
            for row in machines[i]
        ]
    return alike.usual, tuple(outliers)


def _is_spread(values: Array) -> bool:
    """Whether the values scatter in as many dimensions as there are parameters."""
    spread = spread_of(values)
    if not spread.size or not spread.all():
        return False
    scores = (values - np.median(values, axis=0)) / spread
    near = scores[np.all(np.abs(scores) < _FAR, axis=1)]  # beside the others these are one point
    return bool(len(near) and np.linalg.matrix_rank(near - near.mean(axis=0)) == values.shape[1])
