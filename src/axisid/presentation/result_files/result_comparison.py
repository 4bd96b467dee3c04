"""Comparison of two results: parameters, errors, settings and checks."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, TypeAlias

from axisid.estimation.identification import Identification
from axisid.presentation.documents import (
    Block,
    Document,
    Heading,
    Notes,
    Paragraph,
    Sentence,
    TableBlock,
    paragraph,
    text_table,
)
from axisid.support.presentable import Presentable
from axisid.support.wording import or_dash

from .checks import WrittenCheck
from .estimate import WrittenValue
from .file import read_identification
from .identification import (
    SavedIdentification,
    WrittenIdentification,
    WrittenMember,
    written_identification,
)
from .json_objects import JsonObject, about, plain


class WrittenDifference(JsonObject, frozen=True, kw_only=True):
    """One parameter of one method in both results."""

    method: str
    name: str
    unit: str
    first: float
    second: float
    sd_first: Annotated[float, about("HAC standard error.")]
    sd_second: Annotated[float, about("HAC standard error.")]
    deviations: Annotated[
        float | None,
        about("`difference` over the root of the summed variances; null if both are zero."),
    ]
    difference: Annotated[float, about("Second minus first.")]


class WrittenAlone(JsonObject, frozen=True, kw_only=True):
    """Methods and parameters of only one result."""

    first: tuple[str, ...]
    second: tuple[str, ...]


class ResultComparison(
    Presentable,
    JsonObject,
    frozen=True,
    kw_only=True,
    tag_field="schema",
    tag="axisid.result_comparison/1",
    rename={"errors": "errors_percent", "checks": "verdict"},
):
    """Comparison of two results, as written by `axisid compare-results --json`.

    Pairs contain the first and the second result.
    """

    first: Annotated[str, about("File, axis and record.")]
    second: Annotated[str, about("File, axis and record.")]
    differences: tuple[WrittenDifference, ...]
    errors: Annotated[
        Mapping[str, tuple[float | None, float | None]],
        about("Equation and simulation errors, percent, by method and kind."),
    ]
    alone: Annotated[WrittenAlone, about("Methods and parameters of only one result.")]
    settings: Annotated[Mapping[str, tuple[Any, Any]], about("Settings that differ.")]
    checks: Annotated[
        Mapping[str, tuple[WrittenCheck | None, WrittenCheck | None]],
        about("Checks with different status; null if a result lacks the check."),
    ]


_LONG_CELL = 36  # characters; longer cells would make a table wider than a page


#: A result, or its file.
ComparableResult: TypeAlias = Identification | SavedIdentification | str | Path


def result_comparison_document(results: ResultComparison) -> Document:
    """Return a document of tables of parameters and errors, then settings and checks that differ.

    The first result is A, the second is B.
    """
    blocks: list[Block] = [Heading(facts={"A": results.first, "B": results.second})]
    if "axis" in results.settings:
        blocks.append(paragraph("These are results of different axes."))
    methods = dict.fromkeys(difference.method for difference in results.differences)
    blocks += [_table(results, method) for method in methods]
    for side, names in (("A", results.alone.first), ("B", results.alone.second)):
        if names:
            blocks.append(paragraph(Sentence(text=f"Only in {side}: {', '.join(names)}.", hang=4)))
    blocks += _settings_blocks(results.settings)
    return (*blocks, _verdict(results), Notes((_NOTE,)))


#: Note that the head of the last column refers to.
_NOTE = (
    "(B - A) / sqrt(sd_A^2 + sd_B^2), HAC standard errors. This is a test only for results of "
    "different records, because two results of one record share its noise."
)


def _table(results: ResultComparison, method: str) -> TableBlock:
    """Return the table of one method: parameters and errors of both results, with differences."""
    rows = [
        (
            d.name,
            d.unit,
            *(f"{x:.6g}" for x in (d.first, d.second)),
            *(f"{x:.3g}" for x in (d.sd_first, d.sd_second)),
            f"{d.difference:+.3g}",
            or_dash(d.deviations, "+.2f"),
        )
        for d in results.differences
        if d.method == method
    ]
    for kind in ("equation error", "simulation error"):
        first, second = results.errors.get(f"{method} {kind}", (None, None))
        cells = or_dash(first, ".4g"), or_dash(second, ".4g")
        difference = "" if first is None or second is None else f"{second - first:+.3g}"
        rows.append((kind, "%", *cells, "", "", difference, ""))
    return text_table(
        (method.upper(), "unit", "A", "B", "sd A", "sd B", "B - A", "in sd [1]"),
        rows,
        labels=2,
    )


def _settings_blocks(settings: Mapping[str, tuple[Any, Any]]) -> list[Block]:
    """Return the settings that differ: a table, and a paragraph for each long one."""
    if not settings:
        return [paragraph("In both results the settings are the same.")]
    rows: list[tuple[str, ...]] = []
    paragraphs: list[Paragraph] = []
    for name, pair in settings.items():
        texts = [_short(value) for value in pair]
        if max(map(len, texts)) > _LONG_CELL:
            sides = zip("AB", texts, strict=True)
            lines = [Sentence(text=f"    {side}: {text}", hang=7) for side, text in sides]
            paragraphs.append(paragraph(*lines, title=f"{name} differs:"))
        else:
            rows.append((name, *texts))
    table = [text_table(["settings that differ", "A", "B"], rows)] if rows else []
    return [*table, *paragraphs]


def _verdict(results: ResultComparison) -> Paragraph:
    """Return the checks whose status differs, with the sentences of those that did not pass."""
    sentences = []
    for name, (first, second) in results.checks.items():
        text = f"{name}: {_status(first)} in A, {_status(second)} in B"
        sentences.append(Sentence(text=text))
        for side, check in (("A", first), ("B", second)):
            if check is not None and check.status != "pass":
                sentences.append(Sentence(text=f"    {side}: {check.meaning}", hang=7))
    if not sentences:
        return paragraph("Checks: all have the same status in both results.")
    return paragraph(*sentences)


def compare_results(first: ComparableResult, second: ComparableResult) -> ResultComparison:
    """Return the comparison of two results: parameters, errors, settings and checks.

    Parameters
    ----------
    first, second : Identification, SavedIdentification, str or Path
        A result of `identify` or `load_result`, or a file of ``axisid identify --json``.

    Raises
    ------
    DataError
        A file cannot be read or is not a result.
    """
    (of_a, a), (of_b, b) = _document(first), _document(second)
    by_method = [{str(e.method): e for e in result.estimates} for result in (a, b)]
    common = [method for method in by_method[0] if method in by_method[1]]
    labels = [
        {
            f"{method} {name} [{value.unit}]": (method, name, value)
            for method, estimate in estimates.items()
            for name, value in estimate.parameters.items()
        }
        for estimates in by_method
    ]
    # What only one result has: whole methods, and parameters of common methods.
    alone = [
        dict.fromkeys(
            label if method in common else method
            for label, (method, _, _) in own.items()
            if label not in others
        )
        for own, others in (labels, labels[::-1])
    ]
    checks = [{check.name: check for check in result.verdict} for result in (a, b)]
    settings = [_settings(result) for result in (a, b)]
    return ResultComparison(
        first=of_a,
        second=of_b,
        differences=tuple(
            _difference(method, name, value, labels[1][label][2])
            for label, (method, name, value) in labels[0].items()
            if label in labels[1]
        ),
        errors={
            f"{method} {kind} error": (
                getattr(by_method[0][method], f"{kind}_error_percent"),
                getattr(by_method[1][method], f"{kind}_error_percent"),
            )
            for method in common
            for kind in ("equation", "simulation")
        },
        alone=WrittenAlone(first=tuple(alone[0]), second=tuple(alone[1])),
        settings={
            name: (settings[0].get(name), settings[1].get(name))
            for name in dict.fromkeys([*settings[0], *settings[1]])
            if settings[0].get(name) != settings[1].get(name)
        },
        checks={
            name: (checks[0].get(name), checks[1].get(name))
            for name in dict.fromkeys([*checks[0], *checks[1]])
            if _status(checks[0].get(name)) != _status(checks[1].get(name))
        },
    )


def _document(result: ComparableResult) -> tuple[str, WrittenIdentification]:
    """Return a text that names file, axis and record of a result, and its document."""
    if isinstance(result, Identification):
        file, document = "", written_identification(result)
    else:
        saved = result if isinstance(result, SavedIdentification) else read_identification(result)
        file, document = f"{saved.file}: ", saved.document
    sources = [each.record.source for each in document.records or ()] or [document.record.source]
    return f"{file}{document.axis}, {', '.join(sources)}", document


def _difference(
    method: str, name: str, first: WrittenValue, second: WrittenValue
) -> WrittenDifference:
    """Return one parameter of one method in both results, with the difference."""
    combined, apart = math.hypot(first.sd_hac, second.sd_hac), second.value - first.value
    return WrittenDifference(
        method=method,
        name=name,
        unit=first.unit,
        first=first.value,
        second=second.value,
        sd_first=first.sd_hac,
        sd_second=second.sd_hac,
        deviations=apart / combined if combined else None,
        difference=apart,
    )


def _settings(result: WrittenIdentification) -> dict[str, Any]:
    """Return the settings of a result, and the identity of its records, by name."""
    record, members = result.record, result.records or ()
    of_records: dict[str, Any] = {
        "record": record.source,
        "sha256": record.sha256,
        "samples": record.samples,
        "sample period": record.period,
        "columns": record.columns,
    }
    if members:
        of_records = {
            "records": ", ".join(member.record.source for member in members),
            "known": _known_values(members) or None,
            "local": ", ".join(result.local or ()) or None,
            "samples": sum(member.record.samples for member in members),
        }
    return {
        "axis": result.axis,
        "generated code": result.signature,
        "left out": result.left_out or None,
        **of_records,
        "covariance": ", ".join(dict.fromkeys(e.chosen_covariance for e in result.estimates)),
        **plain(result.prefilter),
        **(plain(result.levels) if result.levels else {}),
    }


def _known_values(members: Sequence[WrittenMember]) -> str:
    """Return the known values of several records by name as text; empty without any."""
    texts = []
    for name in members[0].known:
        known = [member.known[name] for member in members]
        values = [
            f"{each.value:g} +- {each.sd:g}" if each.sd else f"{each.value:g}" for each in known
        ]
        texts.append(f"{name} = {', '.join(values)}")
    return "; ".join(texts)


def _status(check: WrittenCheck | None) -> str:
    """Return the status of a check; ``absent`` for None, if a result does not have the check."""
    return "absent" if check is None else check.status


def _short(value: Any) -> str:
    """Return a setting as text, a dash for None; a digest is cut after twelve characters."""
    if isinstance(value, dict):
        return ", ".join(f"{role} = {name}" for role, name in value.items()) or "-"
    text = "-" if value is None else str(value)
    return text[:12] if len(text) == 64 and " " not in text else text  # a digest
