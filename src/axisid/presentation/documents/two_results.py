"""Two results that were written as JSON, side by side."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from axisid.presentation.blocks import (
    Block,
    Document,
    Notes,
    Paragraph,
    Sentence,
    Table,
    paragraph,
    text_columns,
)
from axisid.support.errors import DataError
from axisid.support.result_file import read_json
from axisid.support.shown import Shown

from .fitted import real_number
from .identification import SCHEMA as _RESULT
from .stream import STREAM_SCHEMA

_SCHEMA = "axisid.result_comparison/1"
_NEEDED = ("axis", "signature", "record", "prefilter", "estimates", "verdict")
_LONG_CELL = 36  # characters of a cell from which a table would be wider than a page
_SIDES = ("first", "second")


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """One parameter in two results.

    Attributes
    ----------
    method, name, unit : str
    first, second : float
    sd_first, sd_second : float
        HAC.
    deviations : float or None
        Of the second from the first, in combined deviations; None where both are zero.
    """

    method: str
    name: str
    unit: str
    first: float
    second: float
    sd_first: float
    sd_second: float
    deviations: float | None

    @property
    def difference(self) -> float:
        """The second less the first."""
        return self.second - self.first


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoResults(Shown):
    """What two results have in common, and where they part.

    Attributes
    ----------
    sources : (str, str)
        File, axis and record of each, in words.
    differences : tuple of Difference
        By method and parameter, where both have them in one unit.
    errors : mapping of str to ((float or None), (float or None))
        Simulation and equation errors in percent, by method and kind.
    alone : (tuple of str, tuple of str)
        Methods and parameters that only one has.
    settings : mapping of str to (value, value)
        Those that differ.
    checks : mapping of str to (check, check)
        Those whose status differs; None where a result does not have it.
    """

    sources: tuple[str, str]
    differences: tuple[Difference, ...]
    errors: Mapping[str, tuple[float | None, float | None]]
    alone: tuple[tuple[str, ...], tuple[str, ...]]
    settings: Mapping[str, tuple[Any, Any]]
    checks: Mapping[str, tuple[dict[str, Any] | None, dict[str, Any] | None]]

    def to_dict(self) -> dict[str, Any]:
        """What ``--json`` writes."""
        return {
            "schema": _SCHEMA,
            **dict(zip(_SIDES, self.sources, strict=True)),
            "differences": [{**asdict(d), "difference": d.difference} for d in self.differences],
            "errors_percent": {name: list(pair) for name, pair in self.errors.items()},
            "alone": {side: list(names) for side, names in zip(_SIDES, self.alone, strict=True)},
            "settings": {name: list(pair) for name, pair in self.settings.items()},
            "verdict": {name: list(pair) for name, pair in self.checks.items()},
        }


def two_results_document(results: TwoResults) -> Document:
    """Tables of parameters and errors, then settings and checks that differ."""
    pairs = zip("AB", results.sources, strict=True)
    methods = dict.fromkeys(d.method for d in results.differences)
    alone = (
        paragraph(Sentence(text=f"only in {side}: {', '.join(names)}", hang=4))
        for side, names in zip("AB", results.alone, strict=True)
        if names
    )
    other = "These are results of different axes."
    return (
        paragraph(*(f"{side:<8}{source}" for side, source in pairs), filled=False),
        *((paragraph(other),) if "axis" in results.settings else ()),
        *(_table(results, method) for method in methods),
        *alone,
        *_settings_blocks(results.settings),
        _verdict(results),
        Notes((_NOTE,)),
    )


_NOTE = (
    "(B - A) / sqrt(sd_A^2 + sd_B^2), HAC deviations: for records of their own. Two results of one "
    "record share its noise; there the figure is a scale, not a test."
)


def _table(results: TwoResults, method: str) -> Table:
    rows = [
        (
            d.name,
            d.unit,
            *(f"{x:.6g}" for x in (d.first, d.second)),
            *(f"{x:.3g}" for x in (d.sd_first, d.sd_second)),
            f"{d.difference:+.3g}",
            "-" if d.deviations is None else f"{d.deviations:+.2f}",
        )
        for d in results.differences
        if d.method == method
    ]
    for kind in ("equation error", "simulation error"):
        pair = results.errors.get(f"{method} {kind}", (None, None))
        cells = ["-" if x is None else f"{x:.4g}" for x in pair]
        apart = "" if None in pair else f"{pair[1] - pair[0]:+.3g}"  # type: ignore[operator]
        rows.append((kind, "%", *cells, "", "", apart, ""))
    heads = (method.upper(), "unit", "A", "B", "sd A", "sd B", "B - A", "in deviations [1]")
    return Table(columns=text_columns(heads), rows=tuple(rows), labels=2)


def _settings_blocks(settings: Mapping[str, tuple[Any, Any]]) -> list[Block]:
    if not settings:
        return [paragraph("the settings are the same")]
    shown = {name: tuple(map(_short, pair)) for name, pair in settings.items()}
    long = {name for name, pair in shown.items() if max(map(len, pair)) > _LONG_CELL}
    rows = tuple((name, *pair) for name, pair in shown.items() if name not in long)
    columns = text_columns(["settings that differ", "A", "B"])
    tables: list[Block] = [Table(columns=columns, rows=rows)] if rows else []
    return tables + [
        paragraph(
            *(Sentence(text=f"    {s}: {v}", hang=7) for s, v in zip("AB", pair, strict=True)),
            title=f"{name} differs:",
        )
        for name, pair in shown.items()
        if name in long
    ]


def _verdict(results: TwoResults) -> Paragraph:
    told = []
    for name, (first, second) in results.checks.items():
        states = [_status(first), _status(second)]
        line = f"{name}: {states[0]} in A, {states[1]} in B"
        told.append(Sentence(text=line, filled=False))
        told += [
            Sentence(text=f"    {side}: {check['meaning']}", hang=7)
            for side, check in zip("AB", (first, second), strict=True)
            if check is not None and check["status"] != "pass"
        ]
    return paragraph(*told) if told else paragraph("the verdicts are the same")


def compare_results(first: str | Path, second: str | Path) -> TwoResults:
    """Set two results side by side.

    Parameters
    ----------
    first, second : str or Path
        As ``axisid identify --json`` wrote them.

    Raises
    ------
    DataError
        A file cannot be read or is no result.
    """
    files = (Path(first), Path(second))
    a, b = map(_read, files)
    try:
        return _compared(files, a, b)
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise DataError(
            f"{files[0]} or {files[1]} lacks what its schema promises "
            f"({type(error).__name__}: {error}); write it anew with identify --json."
        ) from error


def _compared(files: tuple[Path, Path], a: dict[str, Any], b: dict[str, Any]) -> TwoResults:
    by_method = [{e["method"]: e for e in result["estimates"]} for result in (a, b)]
    common = [method for method in by_method[0] if method in by_method[1]]
    labels = [
        {
            f"{method} {name} [{value['unit']}]": (method, name, value)
            for method, estimate in side.items()
            for name, value in estimate["parameters"].items()
        }
        for side in by_method
    ]
    alone = tuple(
        tuple(
            dict.fromkeys(
                label if method in common else method
                for label, (method, _, _) in labels[i].items()
                if label not in labels[1 - i]
            )
        )
        for i in (0, 1)
    )
    checks = [_checks(result["verdict"]) for result in (a, b)]
    settings = [_settings(result) for result in (a, b)]
    return TwoResults(
        sources=(_source(files[0], a), _source(files[1], b)),
        differences=tuple(
            _difference(method, name, value, labels[1][label][2])
            for label, (method, name, value) in labels[0].items()
            if label in labels[1]
        ),
        errors={
            f"{method} {kind} error": (
                _percent(by_method[0][method][f"{kind}_error_percent"]),
                _percent(by_method[1][method][f"{kind}_error_percent"]),
            )
            for method in common
            for kind in ("equation", "simulation")
        },
        alone=(alone[0], alone[1]),
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


def _difference(
    method: str, name: str, first: dict[str, Any], second: dict[str, Any]
) -> Difference:
    numbers = [real_number(side[key]) for key in ("value", "sd_hac") for side in (first, second)]
    apart, combined = real_number(numbers[1] - numbers[0]), math.hypot(numbers[2], numbers[3])
    return Difference(
        method=method,
        name=name,
        unit=str(first["unit"]),
        first=numbers[0],
        second=numbers[1],
        sd_first=numbers[2],
        sd_second=numbers[3],
        deviations=real_number(apart / combined) if combined else None,
    )


def _percent(value: Any) -> float | None:
    return None if value is None else real_number(value)


def _checks(verdict: list[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """Checks by name, with what is shown of them."""
    for check in verdict:
        for key in ("name", "status", "meaning"):
            if not isinstance(check[key], str):
                raise ValueError(f"{key} of a check is {check[key]!r}")
    return {check["name"]: check for check in verdict}


def _settings(result: dict[str, Any]) -> dict[str, Any]:
    """What a result was made from and how."""
    record = result["record"]
    return {
        "axis": result["axis"],
        "generated code": result["signature"],
        "left out": result.get("left_out") or None,
        "record": record["source"],
        "sha256": record["sha256"],
        "samples": record["samples"],
        "sample period": record["sample_period"],
        "columns": record["columns"],
        **result["prefilter"],
    }


def _source(file: Path, result: dict[str, Any]) -> str:
    return f"{file}: {result['axis']}, {result['record']['source']}"


def _status(check: dict[str, Any] | None) -> str:
    return "absent" if check is None else str(check["status"])


def _short(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{role} = {name}" for role, name in value.items()) or "-"
    text = "-" if value is None else str(value)
    is_digest = len(text) == 64 and " " not in text
    return text[:12] if is_digest else text


def _read(file: Path) -> dict[str, Any]:
    content = read_json(file, DataError, "Give a file that axisid identify --json wrote.")
    result: dict[str, Any] = content if isinstance(content, dict) else {}
    if (schema := result.get("schema")) == STREAM_SCHEMA:
        raise DataError(
            f"{file} is of a log that was read in blocks, which has no verdict to compare; give "
            "results of identify without --stream."
        )
    if schema != _RESULT:
        raise DataError(
            f"{file}: the schema is {schema!r}, not {_RESULT!r}; give a file that axisid identify "
            "--json wrote."
        )
    if missing := [name for name in _NEEDED if name not in result]:
        raise DataError(
            f"{file} lacks {', '.join(missing)}, which its schema promises; write it anew with "
            "axisid identify --json."
        )
    return result
