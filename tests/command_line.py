"""The types of the fixtures that run the command line."""

from collections.abc import Callable

#: Exit code, stdout and stderr of a command line.
Run = Callable[..., tuple[int, str, str]]
#: What stderr says of a command line that is refused.
Refused = Callable[..., str]
