"""Values that a user gave: said in a message, looked up among names."""

from collections.abc import Container, Sequence
from dataclasses import is_dataclass
from typing import TypeGuard

_SHORT = 60  # letters of a value that is shown as it is
_DIGITS_OF_A_BIT = 0.30103


def quoted(value: object) -> str:
    """A value as it would be written, or what kind of thing it is where that would be long."""
    if isinstance(value, int) and value.bit_length() * _DIGITS_OF_A_BIT > _SHORT:
        # Python refuses to write numbers of some thousand digits.
        return f"a whole number of {value.bit_length() * _DIGITS_OF_A_BIT:.0f} digits"
    # What a dataclass says of itself reads as a sentence within another.
    written = "" if is_dataclass(value) else repr(value)
    if written and len(written) <= _SHORT and "\n" not in written:
        return written
    kind = type(value).__name__
    return f"{'an' if kind[0] in 'AEIOUaeiou' else 'a'} {kind}"


def is_among(value: object, names: Container[str]) -> TypeGuard[str]:
    """Whether a value is one of some names; what is no text may have no hash, or no one ``==``."""
    return isinstance(value, str) and value in names


def first_of(names: Sequence[str], most: int = 3) -> str:
    """The first of some names, and how many more there are."""
    left = len(names) - most
    return ", ".join(names[:most]) + (f" and {left} more" if left > 0 else "")
