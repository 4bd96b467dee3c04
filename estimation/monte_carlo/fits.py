"""Fits of the output error as methods of a study: ``fit:control``, ``fit:position``."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Levels
from axisid.estimation.choices import fit_names, fitted_output
from axisid.estimation.estimates import Value, student_interval
from axisid.estimation.fitting import fit
from axisid.estimation.records import Record
from axisid.support.errors import AxisidError, UsageError
from axisid.support.user_values import is_among, quoted

#: What the intervals of a fit are of: errors that follow an autoregression.
COLOURED, IID = "coloured", "iid"


def stated_by(method: str, chosen: str) -> str:
    """What the printed intervals of a method are of: those of identifications are chosen."""
    return COLOURED if fitted_output(method) else chosen


def split_methods(methods: tuple[object, ...]) -> tuple[list[object], list[str]]:
    """Methods of `identify`, unchecked, and fits.

    Raises
    ------
    UsageError
        There is no fit of such an output.
    """
    others: list[object] = []
    fits: list[str] = []
    for method in methods:
        if not (isinstance(method, str) and fitted_output(method)):
            others.append(method)
        elif is_among(method, fit_names()):
            fits.append(method)
        else:
            raise UsageError(
                f"there is no method {quoted(method)}; the fits are {', '.join(fit_names())}.",
                code="unknown-fit",
            )
    return others, fits


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedRun:
    """What a fit gives of a twin.

    Attributes
    ----------
    values : mapping of str to Value
        Of the parameters that were searched and that the output shows.
    at_bound : frozenset of str
        Of them, those whose interval is to one side.
    checks : mapping of str to str or None
        Statuses; None where it was not judged.
    failed, unjudged : str
        Why there are no values, or no checks.
    """

    values: Mapping[str, Value] = field(default_factory=dict)
    at_bound: frozenset[str] = frozenset()
    checks: Mapping[str, str] | None = None
    failed: str = ""
    unjudged: str = ""

    def intervals(self, name: str) -> Iterator[tuple[str, float, tuple[float, float]]]:
        """Deviations and 95 % intervals by what they are of, the printed one first."""
        value = self.values[name]
        yield COLOURED, value.deviation, value.interval
        if name not in self.at_bound:
            sd = value.deviations[IID]
            yield IID, sd, student_interval(value.value, sd, math.inf)


def fitted(
    axis: GeneratedAxis, record: Record, method: str, levels: Levels, *, is_judged: bool
) -> FittedRun:
    """Fit a twin's record, and judge it if that is asked for."""
    try:
        found = fit(axis, record, fitted_output(method), **asdict(levels))
        values = {
            name: value
            for name, value in found.parameters.items()
            if name not in found.fixed and math.isfinite(value.deviation)
        }
    except AxisidError as error:
        return FittedRun(failed=str(error))
    checks, unjudged = None, ""
    if is_judged:
        try:
            checks = {f"{check.name} ({method})": check.status for check in found.checks}
        except AxisidError as error:
            unjudged = f"{method}: {error}"
    return FittedRun(
        values=values, at_bound=frozenset(found.at_bound), checks=checks, unjudged=unjudged
    )
