"""Results for use elsewhere: feed-forward functions and parameter tables."""

from pathlib import Path

from axisid.codegen.lowering import FeedForward, feed_forward
from axisid.estimation.estimates import COVARIANCES, Value
from axisid.estimation.identification import Identification
from axisid.modeling.declaration import Axis
from axisid.modeling.quantities import Parameter
from axisid.presentation.saved import FittedAxis, SavedIdentification, fitted_axis
from axisid.support.errors import UsageError
from axisid.support.number_text import range_text
from axisid.support.real_numbers import is_real
from axisid.support.user_values import is_among, quoted

from .targets import TARGETS, Target


def export(
    result: Identification | SavedIdentification | str | Path,
    to: str = "c",
    *,
    axis: Axis | str | Path | None = None,
    method: str | None = None,
    dead_zone: float = 0.0,
    record: int | None = None,
) -> str:
    """Write an identified axis as a feed-forward function, or its parameters as a table.

    Parameters
    ----------
    result : Identification, SavedIdentification, str or Path
        Or the file that ``axisid identify --json`` wrote.
    to : {"c", "st", "python", "json", "toml", "csv", "latex"}
        A row of `TARGETS`. The first three are functions from the motion to force and to control:
        C99 with <math.h> only, IEC 61131-3 Structured Text, plain Python for numbers and arrays.
    axis : Axis, str or Path, optional
        The axis that was identified, or what `load_axis` takes; needed for a file of an axis that
        is none of the library.
    method : str, optional
        By default the one that the verdict judges (``idm-iv`` if there is one); JSON, CSV and LaTeX
        then hold all.
    dead_zone : float
        Speed up to which the functions take the friction direction for 0, in the coordinate's
        unit per second. At 0 it is 0 at rest only.
    record : int, optional
        Number of one of several records, from 1: the parameters that it has for itself (`local`, or
        known of it) with those of all. Needed where there are such.

    Raises
    ------
    UsageError
        There is no such target or method, or the axis is not known or not the one that was
        identified.
    DataError
        The file is not the result of an identification.
    """
    target = _target(to)
    if not is_real(dead_zone):
        raise UsageError(
            f"the dead zone is {quoted(dead_zone)}; give a speed of 0 or more.",
            code="dead-zone-type",
        )
    if dead_zone and not target.language:
        languages = ", ".join(each.name for each in TARGETS if each.language)
        raise UsageError(f"a dead zone is part of {languages}, not of {to}.")
    fitted = fitted_axis(result, axis, record)
    chosen = fitted.chosen(method)
    if target.language:
        return target.write(_feed_forward(fitted, chosen, dead_zone))
    several = method is None and not target.one_method
    return target.write(fitted, list(fitted.estimates) if several else [chosen])


def _target(name: object) -> Target:
    for target in TARGETS:
        if is_among(name, (target.name,)):
            return target
    names = ", ".join(target.name for target in TARGETS)
    raise UsageError(
        f"there is no target {quoted(name)}; choose from {names}.", code="unknown-target"
    )


def _feed_forward(fitted: FittedAxis, method: str, dead_zone: float) -> FeedForward:
    axis, estimate = fitted.model.axis, fitted.values(method)
    label = COVARIANCES[next(iter(estimate.values())).chosen].label
    origin = f" (sha256 {fitted.sha256})" if fitted.sha256 else ""
    about = (
        f"Feed-forward of the axis {axis.name}" + (f": {axis.title}." if axis.title else "."),
        f"Parameters by {method.upper()} from {fitted.source}{origin}.",
        f"Generated code {fitted.signature}.",
        f"Standard deviations and 95 % intervals: {label}. Values contain the bias of filter "
        "and noise; it is subtracted in the intervals.",
        "Give it the motion of the reference, whose velocity at rest is 0.",
    )
    comments = {
        p.name: (estimate[p.name].value, _comment(p, estimate[p.name])) for p in axis.parameters
    }
    return feed_forward(fitted.model, comments, about, dead_zone)


def _comment(parameter: Parameter, value: Value) -> str:
    interval = range_text(*value.interval, " to ", digits=6)
    said = f"{parameter.unit}, +- {value.deviation:.3g}, {interval} (95 %)"
    return f"{said}, {parameter.description}" if parameter.description else said
