"""What is kept of a result, in which file, and how far another result is from it."""

import json
import math
import re
from collections.abc import Iterator, Mapping
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any, TypeAlias

from axisid.commands.main import cli
from tests.golden.cases import DFKI, EMPS, Case

FOLDER = Path(__file__).parent / "outputs"
#: Members that are kept beside values and ends of intervals, their deviations, and statuses.
_PLAIN = frozenset(
    "rows judged believed holds recommended recommended_cutoff count error "
    "error_percent equation_error_percent simulation_error_percent".split()
)
#: How far a figure may be from the kept one: in its deviations, or as a part of itself where it has
#: none. A deviation moves with where an optimiser ends, by less than that does in deviations: by
#: 2e-7 between kernels of BLAS. n in place of n - 1 moves one of the longest record by 2e-4.
IN_DEVIATIONS, OF_DEVIATIONS, OF_OTHERS = 1e-3, 1e-4, 1e-6

#: A value with its deviation, or what has none; by the names on the way to it.
Kept: TypeAlias = dict[str, list[float] | float | str | bool | None]


def result_of(case: Case, places: Mapping[str, Path]) -> Kept:
    """Run a case, and keep of its result what is compared."""
    if case.before == DFKI:
        import_module("dfki_pendulum_data").read_data(Path(DFKI.format(**places)), places["folder"])
    elif case.before and case.before != EMPS:
        _output(case.before, places)
    for name, said in case.runs.items():
        log = EMPS.format(**places)
        (places["folder"] / f"{name}.toml").write_text(f"log = {log!r}\n{said}\n")
    if case.made is None:
        text = _output(f"{case.command} --json -", places)
    else:
        text = json.dumps(case.made(places).to_dict())
    return dict(_kept(json.loads(text), ()))


def moves(old: Kept, new: Kept, rounding: float = 1.0) -> Iterator[tuple[str, str, str, str]]:
    """What is another than rounding may make it: its name, old, new, and by how much."""
    for what in dict.fromkeys((*old, *new)):
        a, b = old.get(what, "nothing"), new.get(what, "nothing")
        distance, most, unit = math.inf if a != b else 0.0, 1.0, " status"
        if isinstance(a, list) and isinstance(b, list):
            distance, most, unit = abs(b[0] - a[0]) / a[1], IN_DEVIATIONS, ""
        elif isinstance(a, (int, float)) and isinstance(b, (int, float)):
            is_deviation = re.search(r" deviations |sd\w*$|\berror$", what)
            most = OF_DEVIATIONS if is_deviation else OF_OTHERS
            distance, unit = abs(b - a) / abs(a or 1), " of it"
        if not distance < most * rounding:
            shown = (f"{each[0] if isinstance(each, list) else each}" for each in (a, b))
            yield what, *shown, f"{distance:.2g}{unit}"


def _output(command: str, places: Mapping[str, Path]) -> str:
    words = [word.format(**places) for word in command.split()]
    with redirect_stdout(StringIO()) as out, redirect_stderr(StringIO()):
        cli.main(words, standalone_mode=False)
    return out.getvalue()


def _kept(
    node: Any, path: tuple[str, ...], deviation: float | None = None
) -> Iterator[tuple[str, Any]]:
    """What is kept of a part of a document, which stands within what has a deviation."""
    if isinstance(node, dict):
        deviation = node.get("sd_hac", node.get("sd", node.get("error")))
        for key, each in node.items():
            if key != "finding":  # of a check, whose status is kept
                yield from _kept(each, (*path, key), deviation)
    elif isinstance(node, list):
        for i, each in enumerate(node):
            named = each if isinstance(each, dict) else {}
            own = [named[key] for key in ("method", "name") if key in named]
            yield from _kept(each, (*path, *(own or [str(i)])), deviation)
    elif path[-1] == "status":
        yield " ".join(path[:-1]), node
    elif deviation and (path[-1] == "value" or "interval_95" in path[-2:-1]):
        yield " ".join(path), None if node is None else [_rounded(node), _rounded(deviation)]
    elif path[-1] in _PLAIN or path[-1].startswith("sd") or "deviations" in path[-2:-1]:
        yield " ".join(path), _rounded(node)


def _rounded(value: Any) -> Any:
    """With the digits that are compared."""
    return float(f"{value:.11g}") if isinstance(value, float) else value
