"""What was given, in words."""

import pytest

from axisid.support.user_values import quoted


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (None, "None"),
        ("a file", "'a file'"),
        (["q", 2], "['q', 2]"),
        ("x" * 100, "a str"),
        (ValueError("x" * 100), "a ValueError"),
        (OSError("x" * 100), "an OSError"),
        ({i: i for i in range(99)}, "a dict"),
    ],
)
def test_what_is_short_is_shown_and_what_is_long_is_named(value: object, said: str) -> None:
    assert quoted(value) == said
