"""How long each stage takes from the declaration of a library axis to loaded native code.

Everything is cold: SymPy's memory of earlier results is cleared, and the C is compiled in an empty
cache.

    python benchmarks/generation.py               a table, seconds
    python benchmarks/generation.py --json -      one JSON object
    python benchmarks/generation.py --axes emps   some axes only
"""

import os
import tempfile
import time
from collections.abc import Callable
from typing import Any
from unittest.mock import patch

from figures import give, parser_of
from sympy.core.cache import clear_cache

from axisid import Axis, derive, load_axis
from axisid.codegen.artefacts import axis_artefacts
from axisid.codegen.artefacts.texts import FUNCTIONS, NATIVE
from axisid.codegen.native import Native, NativeUnavailableError
from axisid.codegen.runtime import execute
from axisid.modeling import LIBRARY

Times = dict[str, float]


def stage_times(axis: Axis) -> Times:
    """Seconds of each stage from declaration to loaded native code, as far as they go."""
    times: Times = {}

    def timed(stage: str, run: Callable[[], Any]) -> Any:
        begin = time.perf_counter()
        result = run()
        times[stage] = time.perf_counter() - begin
        return result

    model = timed("derive", lambda: derive(axis))
    texts = timed("lower and print", lambda: axis_artefacts(model))
    functions = timed("build for the virtual machine", lambda: execute(texts[FUNCTIONS], axis.name))
    native = Native(texts[NATIVE], functions)
    try:
        timed("compile", native.compile_afresh)
    except (NativeUnavailableError, OSError) as error:
        native.refusal = str(error)
        native.warn_once()
        return times
    native.library()
    timed("load", Native(texts[NATIVE], functions).library)
    return times


def generation_times(name: str) -> Times:
    """Seconds of each stage of an axis, and their total."""
    axis = load_axis(name)
    clear_cache()
    with (
        tempfile.TemporaryDirectory(prefix="axisid-") as folder,
        patch.dict(os.environ, {"AXISID_CACHE": folder}),
    ):
        times = stage_times(axis)
    return {**times, "total": sum(times.values())}


def table(figures: dict[str, Times]) -> str:
    """One line for each axis, one column for each stage."""
    stages = max(figures.values(), key=len)
    head = f"{'axis':<16}" + "".join(f"{stage:>{len(stage) + 2}}" for stage in stages)
    rows = [
        f"{name:<16}" + "".join(f"{times[stage]:{len(stage) + 2}.2f}" for stage in times)
        for name, times in figures.items()
    ]
    return "\n".join([head, *rows])


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--axes", nargs="+", choices=LIBRARY, default=LIBRARY, metavar="AXIS")
    options = parser.parse_args()
    figures = {name: generation_times(name) for name in options.axes}
    largest = max(figures, key=lambda name: figures[name]["total"])
    lines = [table(figures), f"largest: {largest}, {figures[largest]['total']:.2f} s"]
    give({"axes": figures, "largest": largest}, options.json, lines)


if __name__ == "__main__":
    main()
