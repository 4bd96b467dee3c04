"""What a user gave in place of something else, in words."""

_SHORT = 60  # letters of a value that is shown as it is


def given(value: object) -> str:
    """A value as it would be written, or what kind of thing it is where that would be long."""
    written = repr(value)
    if len(written) <= _SHORT and "\n" not in written:
        return written
    kind = type(value).__name__
    return f"{'an' if kind[0] in 'AEIOUaeiou' else 'a'} {kind}"
