"""Every check of the program: the line of a verdict that it is told under, and what it weighs."""

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """What a check is in every verdict that has it.

    Attributes
    ----------
    name : str
        Of the check.
    line : str
        What a verdict answers by it: is the control the declared law's; is everything logged at
        its time; does the simulated loop do what the record does; is something missing in the
        model; are there outliers; does the record show every parameter; are the records of one
        machine; and do the methods agree.
    rank : int
        Its place among those that fail, the cause before what follows from it.
    grave : bool
        Whether the numbers may mean something else than what they are called where it fails.
    """

    name: str
    line: str
    rank: int = 100
    grave: bool = False


#: By name, line by line.
KINDS: dict[str, Kind] = {
    kind.name: kind
    for kind in (
        Kind(name="control law", line="law", rank=0, grave=True),
        Kind(name="law's factors", line="law"),
        Kind(name="exact law", line="law"),
        Kind(name="force against control", line="law", rank=5, grave=True),
        Kind(name="drive gain", line="law"),
        Kind(name="time base", line="timing", rank=0, grave=True),
        Kind(name="sample period", line="timing"),
        Kind(name="alignment", line="timing", rank=8),
        Kind(name="recorded signals", line="timing", rank=2, grave=True),
        Kind(name="start of the loop", line="timing"),
        Kind(name="simulation", line="loop", rank=2, grave=True),
        Kind(name="windows", line="loop", rank=2, grave=True),
        Kind(name="measured velocity", line="loop", rank=1, grave=True),
        Kind(name="measured acceleration", line="loop", rank=1, grave=True),
        Kind(name="control against limit", line="loop", rank=6, grave=True),
        Kind(name="noise in the loop", line="loop"),
        Kind(name="samples near rests", line="loop"),
        Kind(name="equation error", line="model", rank=3, grave=True),
        Kind(name="missing terms", line="model", rank=8),
        Kind(name="fixed values", line="model", rank=4, grave=True),
        Kind(name="what was known", line="model", rank=4, grave=True),
        Kind(name="lack of fit", line="model"),
        Kind(name="outliers", line="outliers", rank=1),
        Kind(name="any parameter shown", line="precision", rank=3, grave=True),
        Kind(name="parameters shown", line="precision"),
        Kind(name="one end", line="precision", rank=3, grave=True),
        Kind(name="bounds", line="precision", rank=3, grave=True),
        Kind(name="rows", line="precision"),
        Kind(name="convergence", line="precision"),
        Kind(name="starts", line="precision"),
        Kind(name="precision", line="precision", rank=13),
        Kind(name="nominal values", line="precision"),
        Kind(name="physical parameters", line="precision", rank=10),
        Kind(name="records alike", line="records", rank=8, grave=True),
        Kind(name="repeated records", line="records", rank=10),
        Kind(name="instrument strength", line="method", rank=12),
        Kind(name="method", line="method", rank=14),
        Kind(name="inverse against direct", line="method", rank=5, grave=True),
        Kind(name="validation", line="validation", rank=7),
        Kind(name="result", line="result", rank=0, grave=True),
    )
}


def kind_of(check: str) -> Kind:
    """What a check is; one that no row names is told by itself, and last."""
    return KINDS.get(check) or Kind(name=check, line=check)


def lines_of(checks: Iterable[str]) -> tuple[str, ...]:
    """The lines of checks, each once, in the order of the checks."""
    return tuple(dict.fromkeys(kind_of(check).line for check in checks))
