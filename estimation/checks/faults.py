"""Where checks are run: one that faults says so in its place, and costs no estimate."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from axisid.support.errors import AxisidError, asks_for_tracebacks
from axisid.support.missing import Missing


@dataclass(frozen=True, slots=True)
class Fault(Missing):
    """What stands in place of something by whose search the program faulted."""


Found = TypeVar("Found")
Else = TypeVar("Else")


def unless_faulty(find: Callable[[], Found]) -> Found | Missing:
    """What a check finds, or why it could not be made, whatever it raises.

    A fault is raised where tracebacks are asked for; want of memory is no fault of a check.

    Parameters
    ----------
    find : callable
    """
    try:
        return find()
    except AxisidError as error:
        return Missing.of(error.note)
    except MemoryError:
        raise
    except Exception as fault:
        if asks_for_tracebacks():
            raise
        said = f"{type(fault).__name__}: {fault}".rstrip(": ")
        return Fault(f"it could not be made, by a fault ({said}): please report it")


def told_or(otherwise: Else, find: Callable[[], Found | Missing]) -> Found | Else:
    """What a check measures, or what stands for nothing where it could not be measured."""
    found = unless_faulty(find)
    return otherwise if isinstance(found, Missing) else found
