"""What all classes of documents have in common."""

from typing import TypeAlias

from msgspec import Meta, Struct

Matrix: TypeAlias = tuple[tuple[float, ...], ...]


class JsonObject(Struct, frozen=True, kw_only=True):
    """One object of a document; its members are written in the order of the fields."""


def about(text: str) -> Meta:
    """A field's description in the schema."""
    return Meta(description=text)
