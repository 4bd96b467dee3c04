"""Run generated text: what was reviewed is what runs."""

import linecache
from collections.abc import Mapping
from functools import lru_cache
from typing import Any


@lru_cache(maxsize=64)  # of loops by gains and laws it is asked again and again
def execute(text: str, name: str) -> Mapping[str, Any]:
    """Build the CasADi functions of a generated ``functions.py``.

    Parameters
    ----------
    text : str
        As `axis_artefacts` wrote it in this process: every name in it was checked at declaration,
        every number is a literal. Text from elsewhere must not come here; it would run.
    name : str
        The axis, for tracebacks.

    Returns
    -------
    mapping of str to casadi.Function
    """
    filename = f"<generated {name}>"
    linecache.cache[filename] = (len(text), None, text.splitlines(keepends=True), filename)
    namespace: dict[str, Any] = {}
    exec(compile(text, filename, "exec"), namespace)  # noqa: S102
    return {function: make() for function, make in namespace["FUNCTIONS"].items()}
