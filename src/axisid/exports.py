"""Results for other programs: feed-forward functions, and tables as JSON, TOML, CSV, LaTeX.

In: an identification or its file. Out: text. Knows nothing of records, and of how its text is run
or shown.

In tables, ``sd_hac`` is the standard error that is consistent for autocorrelated residuals,
``sd_iid`` the standard error for independent residuals. Intervals use the chosen covariance,
``interval_covariance``.
"""

import math
from collections.abc import Sequence
from pathlib import Path

from axisid.codegen.lowering import FeedForward, feed_forward
from axisid.estimation.estimates import CORRECTED, COVARIANCES, Value
from axisid.estimation.identification import Identification
from axisid.export_targets import TARGETS
from axisid.modeling.declaration import Axis
from axisid.modeling.quantities import Parameter
from axisid.presentation.documents import decimals, symbol_latex, unit_latex
from axisid.presentation.result_files import FittedAxis, SavedIdentification, fitted_axis
from axisid.support.checks import is_among, is_real, refuse
from axisid.support.errors import UsageError
from axisid.support.files import csv_text, json_text, toml_text
from axisid.support.wording import quoted, range_text

_HEADER = (
    "axis method parameter unit value sd_hac lower_95 upper_95 sd_iid sd_gain filter_bias "
    "interval_covariance"
).split()
_PLAIN = (1e-4, 1e6)  # values outside of this range are written with a power of ten
_LEAST_POWER = -300


def parameters_json(fitted: FittedAxis, methods: Sequence[str]) -> str:
    """Return the parameters by method and name, and their origin, as JSON text."""
    return json_text(
        {
            "schema": "axisid.parameters/1",
            "axis": fitted.model.axis.name,
            "signature": fitted.signature,
            "record": {"source": fitted.source, "sha256": fitted.sha256 or None},
            "parameters": {
                method: {
                    name: {
                        "value": v.value,
                        "unit": v.unit,
                        "sd_hac": v.sd_hac,
                        "interval_95": list(v.interval),
                        "sd_iid": v.sd,
                        "sd_gain": v.sd_gain,
                        "filter_bias": v.filter_bias,
                        "interval_covariance": v.chosen,
                    }
                    for name, v in fitted.values(method).items()
                }
                for method in methods
            },
        }
    )


def parameters_csv(fitted: FittedAxis, methods: Sequence[str]) -> str:
    """Return CSV text with one row for each method and parameter."""
    rows: list[Sequence[object]] = [_HEADER]
    for method in methods:
        for name, v in fitted.values(method).items():
            numbers = (v.value, v.sd_hac, *v.interval, v.sd, v.sd_gain, v.filter_bias)
            rows.append([fitted.model.axis.name, method, name, v.unit, *numbers, v.chosen])
    return csv_text(rows)


def parameters_toml(fitted: FittedAxis, methods: Sequence[str]) -> str:
    """Return the table ``[parameters]`` of a declaration, and the estimates as ``[identified]``.

    If the parameters are base parameters, which the declaration does not have, only the second.
    """
    (method,) = methods
    estimate = fitted.values(method)
    if fitted.model.base.changed:
        lines = ["# Base parameters. The axis is declared in others, so its table stays unchanged."]
    else:
        lines = [
            "# This table replaces that of the same name in the axis's declaration. The nominal "
            "values are the identified ones.",
            "[parameters]",
        ]
        lines += [_declared(p, estimate[p.name]) for p in fitted.model.axis.parameters]
    lines += [
        "",
        "# Not part of the declaration.",
        "[identified]",
        f"axis = {toml_text(fitted.model.axis.name)}",
        f"method = {toml_text(method)}",
        f"record = {toml_text(fitted.source)}",
        f"sha256 = {toml_text(fitted.sha256)}",
        f"signature = {toml_text(fitted.signature)}",
        "",
        "[identified.parameters]",
    ]
    for name, v in estimate.items():
        low, high = v.interval
        lines.append(
            f"{name} = {{ value = {v.value!r}, unit = {toml_text(v.unit)}, sd_hac = {v.sd_hac!r}, "
            f"interval_95 = [{low!r}, {high!r}], interval_covariance = {toml_text(v.chosen)} }}"
            + f"  # {v.corrected!r} {CORRECTED}"
            * v.is_shifted
        )
    return "\n".join(lines) + "\n"


def _declared(parameter: Parameter, v: Value) -> str:
    """Return the line of a declared parameter, with the estimate as its nominal value.

    A declared bound that the estimate violates is omitted and named in a comment.
    """
    nominal = v.corrected
    fields = {"unit": toml_text(parameter.unit), "nominal": repr(nominal)}
    comment = ""
    for bound, limit, is_kept in (
        ("lower", parameter.lower, parameter.lower <= nominal),
        ("upper", parameter.upper, nominal <= parameter.upper),
    ):
        if not is_kept:
            comment = f"  # outside its bound {bound} = {limit!r}"
        elif math.isfinite(limit):
            fields[bound] = repr(limit)
    if parameter.description:
        fields["description"] = toml_text(parameter.description)
    members = ", ".join(f"{key} = {value}" for key, value in fields.items())
    return f"{parameter.name} = {{ {members} }}{comment}"


def parameters_latex(fitted: FittedAxis, methods: Sequence[str]) -> str:
    """Return a LaTeX ``tabular`` of values and standard errors, which needs no LaTeX package.

    A parameter whose value is corrected for a bias has a second line with the corrected values.
    """
    estimates = [fitted.values(method) for method in methods]
    header = ["", "unit", *(method.upper() for method in methods)]
    chosen = dict.fromkeys(COVARIANCES[v.chosen].label for e in estimates for v in e.values())
    lines = [
        f"% {fitted.model.axis.name}: value and standard error ({', '.join(chosen)})",
        rf"\begin{{tabular}}{{ll{'r' * len(methods)}}}",
        r"\hline",
        " & ".join(header).strip() + r" \\",
        r"\hline",
    ]
    for name, value in estimates[0].items():
        cells = [f"${symbol_latex(name)}$", f"${unit_latex(value.unit)}$"]
        cells += [
            f"${scaled(estimate[name], estimate[name].value, estimate[name].deviation)}$"
            if name in estimate
            else "--"
            for estimate in estimates
        ]
        lines.append(" & ".join(cells) + r" \\")
        found = [estimate.get(name) for estimate in estimates]
        if any(v is not None and v.is_shifted for v in found):
            centres = (f"${scaled(v, v.corrected)}$" if v is not None else "--" for v in found)
            lines.append(" & ".join([rf"\quad {CORRECTED}", "", *centres]) + r" \\")
    return "\n".join([*lines, r"\hline", r"\end{tabular}"]) + "\n"


def scaled(value: Value, *figures: float) -> str:
    r"""Return numbers as LaTeX, such as ``95.17 \pm 0.24``, with two digits of the standard error.

    Very large or small numbers have a power of ten.

    Parameters
    ----------
    value : Value
        Value whose size and standard error determine the digits and the power of ten.
    *figures : float
        Numbers to be written, joined by ``\pm``.
    """
    size, power = max(abs(value.value), value.deviation), 0
    if size and not _PLAIN[0] <= size < _PLAIN[1]:
        power = max(math.floor(math.log10(size)), _LEAST_POWER)
    sd = value.deviation / 10.0**power
    places = decimals(sd) if sd > 0 else 6
    text = r" \pm ".join(f"{figure / 10.0**power:.{places}f}" for figure in figures)
    if not power:
        return text
    factor = f"({text})" if len(figures) > 1 else text
    return rf"{factor} \cdot 10^{{{power}}}"


def export(
    result: Identification | SavedIdentification | str | Path,
    to: str = "c",
    *,
    axis: Axis | str | Path | None = None,
    method: str | None = None,
    dead_zone: float = 0.0,
    record: int | None = None,
) -> str:
    """Return an identified axis as text: feed-forward functions, or a table of its parameters.

    Parameters
    ----------
    result : Identification, SavedIdentification, str or Path
        Result, or the file that ``axisid identify --json`` wrote.
    to : {"c", "st", "python", "json", "toml", "csv", "latex"}
        Format, one of `TARGETS`. The first three are two functions, which compute the force for a
        motion and the control for a force: C99 with <math.h> only, IEC 61131-3 Structured Text,
        plain Python for numbers and arrays.
    axis : Axis, str or Path, optional
        The axis that was identified, or an argument of `load_axis`; needed for the file of a result
        whose axis is not in the library.
    method : str, optional
        Method whose estimate is exported. By default the method that the verdict judges (``idm-iv``
        if the result has it); JSON, CSV and LaTeX then contain all methods.
    dead_zone : float
        Speed up to which the functions use the friction direction 0, in the coordinate's unit per
        second. If it is 0, the direction is 0 at standstill only.
    record : int, optional
        Number of a record, from 1. The parameters with a separate or known value for each record
        have their values for this record. Needed if there are such parameters.

    Raises
    ------
    UsageError
        The target or the method does not exist, or the axis is missing or differs from the axis
        that was identified.
    DataError
        The file is not the result of an identification.
    """
    target = next((target for target in TARGETS if is_among(to, (target.name,))), None)
    if target is None:
        raise UsageError(
            f"there is no target {quoted(to)}. Choose from {', '.join(t.name for t in TARGETS)}.",
            code="export",
        )
    languages = ", ".join(each.name for each in TARGETS if each.language)
    refuse(
        UsageError,
        (
            not is_real(dead_zone),
            f"the dead zone is {quoted(dead_zone)}. Give a speed of 0 or more",
            "export",
        ),
        (
            is_real(dead_zone) and dead_zone and not target.language,
            f"a dead zone applies to {languages} only, not to {to}. Omit the dead zone",
        ),
    )
    fitted = fitted_axis(result, axis, record)
    chosen = (fitted.result.preferred if method is None else fitted.result[method]).method
    if target.language:
        return target.write(_feed_forward(fitted, chosen, dead_zone))
    methods = [chosen]
    if method is None and not target.one_method:
        methods = [*fitted.result.estimates]
    return target.write(fitted, methods)


def _feed_forward(fitted: FittedAxis, method: str, dead_zone: float) -> FeedForward:
    """Return the feed-forward of an axis with the estimates of a method as its parameters."""
    axis, estimate = fitted.model.axis, fitted.values(method)
    label = COVARIANCES[next(iter(estimate.values())).chosen].label
    origin = f" (sha256 {fitted.sha256})" if fitted.sha256 else ""
    about = (
        f"Feed-forward of the axis {axis.name}" + (f": {axis.title}." if axis.title else "."),
        f"Parameters by {method.upper()} from {fitted.source}{origin}.",
        f"Generated code {fitted.signature}.",
        f"Standard errors and 95 % intervals: {label}. Values are minus the bias of filter and "
        "noise, if it was found with simulated replicas of the record.",
        "Call it with the motion of the reference, whose velocity at rest is 0.",
    )
    comments = {}
    for p in axis.parameters:
        value = estimate[p.name]
        interval = range_text(*value.interval, " to ", digits=6)
        comment = f"{p.unit}, +- {value.deviation:.3g}, {interval} (95 %)"
        if p.description:
            comment = f"{comment}, {p.description}"
        comments[p.name] = (value.corrected, comment)
    return feed_forward(fitted.model, comments, about, dead_zone)
