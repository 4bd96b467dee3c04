"""What all classes of documents have in common."""

from typing import Annotated, Literal, TypeAlias

from msgspec import UNSET, Meta, Struct, UnsetType

Matrix: TypeAlias = tuple[tuple[float, ...], ...]


class JsonObject(Struct, frozen=True, kw_only=True):
    """One object of a document; its members are written in the order of the fields."""


def about(text: str) -> Meta:
    """A field's description in the schema."""
    return Meta(description=text)


class WrittenResult(JsonObject, frozen=True, kw_only=True):
    """A result of any kind, and what it is worth."""

    belief: Annotated[
        Literal["believed", "with care", "not believed"] | UnsetType,
        about("How far the numbers can be believed; left out in files of earlier versions."),
    ] = UNSET
