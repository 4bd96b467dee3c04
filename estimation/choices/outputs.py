"""What a fit may follow, and how it counts what it leaves, by the names that users give."""

from collections.abc import Mapping
from types import MappingProxyType

from axisid.support.remedy import Setting

CONTROL, POSITION, FORCE, OPEN_LOOP = "control", "position", "force", "open-loop"
#: In the order of help, first the one by default.
OUTPUTS: Mapping[str, str] = MappingProxyType(
    {
        CONTROL: "what the simulated loop's law gives",
        POSITION: "the simulated loop's position, where the law is exact",
        FORCE: "the simulated drive's force",
        OPEN_LOOP: "the position under the recorded control, in windows",
    }
)

#: How it is asked for.
OPEN_LOOP_FIT = Setting("fit output", OPEN_LOOP)

#: What the name of a fit begins with among other methods.
FIT = "fit:"


def fit_names() -> tuple[str, ...]:
    """Fits by one output each that twins record, as they are named among other methods."""
    return tuple(f"{FIT}{output}" for output in OUTPUTS if output != FORCE)


def fitted_output(method: str) -> str:
    """What a method fits; empty for one that is no fit."""
    return method.removeprefix(FIT) if method.startswith(FIT) else ""


SQUARES, SOFT_L1, HUBER = "squares", "soft-l1", "huber"
#: In the order of help, first the one by default.
LOSSES: Mapping[str, str] = MappingProxyType(
    {
        SQUARES: "all samples alike",
        SOFT_L1: "large errors for less, smoothly",
        HUBER: "errors beyond 1.345 deviations for less",
    }
)

INSTRUMENTS_START, LEAST_SQUARES_START, NOMINAL_START = "instruments", "least-squares", "nominal"
#: Where a fit may start, first the one by default.
FIT_STARTS = (INSTRUMENTS_START, LEAST_SQUARES_START, NOMINAL_START)

#: What becomes of samples near rests and reversals, first the choice by default.
RESTS = ("leave-out", "keep")
