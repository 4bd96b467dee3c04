"""Lists of names and sequences of sentences."""

from collections.abc import Sequence

from axisid.support.wording import listed as listed


def one_after_another(texts: Sequence[str]) -> str:
    """Return sentences as one text, separated by full stops; the last has none.

    All sentences but the first get a capital letter, because another text may precede the first.
    """
    return ". ".join([*texts[:1], *map(capitalised, texts[1:])])


def capitalised(text: str) -> str:
    """Return a text with a capital first letter."""
    return text[:1].upper() + text[1:]
