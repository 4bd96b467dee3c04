"""Results of one axis and one machine, in their order."""

from collections.abc import Iterable
from dataclasses import dataclass

from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import Checked
from axisid.support.user_values import first_of

from .chart import Chart
from .point import Point


@dataclass(frozen=True, slots=True, kw_only=True)
class Series(Checked):
    """Results of one axis and one machine.

    Attributes
    ----------
    axis, serial : str
        The serial number is empty where nothing says it.
    points : tuple of Point
        In their order.
    places : tuple of float
        Where each stands: by the condition that orders them (a date as days since 1970), or from 1.
    charts : tuple of Chart
        One for each parameter.
    set_aside : tuple of int
        Results, from 0, that set no limits and tell no change.
    """

    axis: str
    serial: str
    points: tuple[Point, ...]
    places: tuple[float, ...]
    charts: tuple[Chart, ...]
    set_aside: tuple[int, ...] = ()

    def origin(self, by: str) -> str:
        """The first of the dates that order the results; empty where it is no date."""
        first = self.points[0].conditions.get(by)
        return first if isinstance(first, str) else ""

    @property
    def title(self) -> str:
        """Axis and serial number."""
        return f"{self.axis} {self.serial}".strip()

    @property
    def checks(self) -> tuple[Check, ...]:
        """Whether a parameter changes or is beyond its limits, and whether results are believed."""
        changed = ", ".join(chart.parameter for chart in self.charts if chart.has_changed)
        beyond = ", ".join(chart.parameter for chart in self.charts if chart.beyond)
        failing = dict.fromkeys(name for point in self.points for name in point.failing)
        rows = (
            ("changes", changed and f"step or drift of {changed}", "no step and no drift"),
            ("limits", beyond and f"beyond the limits: {beyond}", "nothing beyond the limits"),
        )
        of = f"{self.title}: "
        return (
            *(Check.unless(name, bad and of + bad, of + good) for name, bad, good in rows),
            *(Check.unless(name, f"{of}fails in {self._failing(name)}") for name in failing),
        )

    def _failing(self, check: str) -> str:
        """The results that a check fails in."""
        return first_of([point.name for point in self.points if check in point.failing])

    @property
    def has_changed(self) -> bool:
        """Whether a step or a drift is told."""
        return any(chart.has_changed for chart in self.charts)

    @property
    def has_beyond(self) -> bool:
        """Whether a result is beyond its limits."""
        return any(chart.beyond for chart in self.charts)


def notable_first(series: Iterable[Series]) -> list[Series]:
    """Series that changed, then those with a result beyond its limits, then the others."""
    return sorted(series, key=lambda each: (not each.has_changed, not each.has_beyond))
