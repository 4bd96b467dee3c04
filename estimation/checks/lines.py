"""The eight lines of a verdict: what every check is one of."""

from collections.abc import Iterable
from types import MappingProxyType

#: What a verdict answers, with the checks that answer it: is the control the declared law's; is
#: everything logged at its time; does the simulated loop do what the record does; is something
#: missing in the model; are there outliers; does the record show every parameter; are the records
#: of one machine; and do the methods agree.
LINES = MappingProxyType(
    {
        "law": ("control law", "law's factors", "exact law", "force against control", "drive gain"),
        "timing": (
            "time base",
            "sample period",
            "alignment",
            "recorded signals",
            "start of the loop",
        ),
        "loop": (
            "simulation",
            "windows",
            "measured velocity",
            "measured acceleration",
            "control against limit",
            "noise in the loop",
            "samples near rests",
        ),
        "model": (
            "equation error",
            "missing terms",
            "fixed values",
            "what was known",
            "lack of fit",
        ),
        "outliers": ("outliers",),
        "precision": (
            "any parameter shown",
            "parameters shown",
            "one end",
            "bounds",
            "rows",
            "convergence",
            "starts",
            "precision",
            "nominal values",
            "physical parameters",
        ),
        "records": ("records alike", "repeated records"),
        "method": ("instrument strength", "method", "inverse against direct"),
    }
)
_OF_CHECK = MappingProxyType({check: line for line, checks in LINES.items() for check in checks})


def line_of(check: str) -> str:
    """The line that a check is told under: by itself where a user added it."""
    return _OF_CHECK.get(check, check)


def lines_of(checks: Iterable[str]) -> tuple[str, ...]:
    """The lines of checks, each once, in the order of the checks."""
    return tuple(dict.fromkeys(map(line_of, checks)))
