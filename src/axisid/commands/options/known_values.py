"""What is known of each of several records, as a command line says it."""

import re
from collections.abc import Iterable

from axisid.support.errors import UsageError

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_LIST = re.compile(r"\s*(\w+)\s*=(.*)", re.DOTALL)
_ENTRY = re.compile(rf"\s*({_NUMBER})\s*(?:(?:\+-|\+/-|±)\s*({_NUMBER})\s*)?")


def read_known(texts: Iterable[str]) -> dict[str, tuple[tuple[float, float], ...]]:
    """Values by record from texts such as ``m_add=0,20+-0.01``.

    Raises
    ------
    UsageError
        A text is something else, or a name is given twice.
    """
    found: dict[str, tuple[tuple[float, float], ...]] = {}
    for text in texts:
        match = _LIST.fullmatch(text)
        entries = [_ENTRY.fullmatch(part) for part in match[2].split(",")] if match else [None]
        if match is None or not all(entries):
            wrong = next(
                (f", of which number {i} is no value" for i, e in enumerate(entries, 1) if not e),
                "",
            )
            raise UsageError(
                f"{text!r} says nothing of each record{wrong * (match is not None)}; write "
                "NAME=V1,V2,..., SI, one value for each record in their order, each with its "
                "deviation if it has one: m_add=0,20+-0.01.",
                code="parameters",
            )
        if match[1] in found:
            raise UsageError(
                f"{match[1]!r} is known twice; give all its values once.", code="parameters"
            )
        found[match[1]] = tuple((float(e[1]), float(e[2] or 0.0)) for e in entries if e)
    return found
