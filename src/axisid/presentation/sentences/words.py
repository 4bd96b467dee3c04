"""Lists and numbers within sentences."""

from collections.abc import Sequence


def listed(names: Sequence[str]) -> str:
    """Return names as a list in a sentence: ``a, b and c``."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]}"


def one_after_another(texts: Sequence[str]) -> str:
    """Return sentences one after another; the first letter of the first stays as it is."""
    return ". ".join([*texts[:1], *map(capitalised, texts[1:])])


def capitalised(text: str) -> str:
    """Return a text as the beginning of a sentence within others."""
    return text[:1].upper() + text[1:]
