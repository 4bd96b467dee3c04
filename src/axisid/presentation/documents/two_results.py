"""Two results that were written as JSON, side by side."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from axisid.presentation.text import text_table, wrapped
from axisid.support.errors import DataError
from axisid.support.result_file import read_json

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
class TwoResults:
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

    def summary(self) -> str:
        """Tables of parameters and errors, then settings and checks that differ."""
        blocks = ["\n".join(f"{side:<8}{s}" for side, s in zip("AB", self.sources, strict=True))]
        if "axis" in self.settings:
            blocks.append("These are results of different axes.")
        methods = dict.fromkeys(d.method for d in self.differences)
        blocks += [self._table(method) for method in methods]
        for side, names in zip("AB", self.alone, strict=True):
            blocks += [wrapped("", f"only in {side}: {', '.join(names)}", 4)] if names else []
        blocks.append(self._settings())
        blocks.append("\n".join(self._verdict()) or "the verdicts are the same")
        blocks.append(
            "[1] (B - A) / sqrt(sd_A^2 + sd_B^2), HAC deviations: for records of their own. Two "
            "results of\n    one record share its noise; there the figure is a scale, not a test."
        )
        return "\n\n".join(blocks) + "\n"

    def _table(self, method: str) -> str:
        rows = [
            [
                d.name,
                d.unit,
                *(f"{x:.6g}" for x in (d.first, d.second)),
                *(f"{x:.3g}" for x in (d.sd_first, d.sd_second)),
                f"{d.difference:+.3g}",
                "-" if d.deviations is None else f"{d.deviations:+.2f}",
            ]
            for d in self.differences
            if d.method == method
        ]
        for kind in ("equation error", "simulation error"):
            pair = self.errors.get(f"{method} {kind}", (None, None))
            cells = ["-" if x is None else f"{x:.4g}" for x in pair]
            apart = "" if None in pair else f"{pair[1] - pair[0]:+.3g}"  # type: ignore[operator]
            rows.append([kind, "%", *cells, "", "", apart, ""])
        header = [method.upper(), "unit", "A", "B", "sd A", "sd B", "B - A", "in deviations [1]"]
        return text_table(header, rows)

    def _settings(self) -> str:
        if not self.settings:
            return "the settings are the same"
        shown = {name: tuple(map(_short, pair)) for name, pair in self.settings.items()}
        long = {name for name, pair in shown.items() if max(map(len, pair)) > _LONG_CELL}
        rows = [[name, *pair] for name, pair in shown.items() if name not in long]
        blocks = [text_table(["settings that differ", "A", "B"], rows)] if rows else []
        blocks += [
            "\n".join(
                [
                    f"{name} differs:",
                    *(
                        wrapped("", f"    {s}: {v}", 7)
                        for s, v in zip("AB", shown[name], strict=True)
                    ),
                ]
            )
            for name in shown
            if name in long
        ]
        return "\n\n".join(blocks)

    def _verdict(self) -> Iterator[str]:
        for name, (first, second) in self.checks.items():
            states = [_status(first), _status(second)]
            yield f"{name}: {states[0]} in A, {states[1]} in B"
            for side, check in zip("AB", (first, second), strict=True):
                if check is not None and check["status"] != "pass":
                    yield wrapped("", f"    {side}: {check['meaning']}", 7)


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
