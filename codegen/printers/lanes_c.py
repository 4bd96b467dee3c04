"""The C text that makes rows of many lanes of one axis, and that of the filters by themselves."""

import re
from collections.abc import Iterable
from importlib import resources

#: In the order of the text, each of which calls those before it.
_PARTS = ("sections.c", "motion.c", "rows.c", "products.c", "turns.c")
_FILTER = ("sections.c", "filter.c")
_HEADERS = "#include <math.h>\n#include <stddef.h>\n#include <stdint.h>\n#include <string.h>\n"


def print_c_lanes(native: str, parameters: int) -> str:
    """Return the C text of the lanes of an axis, from that of its native code.

    Parameters
    ----------
    native : str
        With its functions of one sample first.
    parameters : int
        How many it has.
    """
    functions = native[: native.index("\nvoid ")]
    functions = re.sub(r"^#include .*\n", "", functions, flags=re.MULTILINE)
    known = int(has_known_part(native))
    sizes = f"#define WIDE 8\n#define PARAMETERS {parameters}\n#define KNOWN {known}\n"
    return f"{_HEADERS}{sizes}\n{functions}\n{_joined(_PARTS)}"


def print_c_filter() -> str:
    """Return the C text that filters columns, which is of no axis."""
    return f"{_HEADERS}#define WIDE 4\n\n{_joined(_FILTER)}"


def _joined(parts: Iterable[str]) -> str:
    folder = resources.files(__package__) / "lanes"
    return "".join((folder / part).read_text() for part in parts)


def has_known_part(native: str) -> bool:
    """Whether the inverse model of native code has a part that no parameter scales."""
    begin = native.index("static inline void idm_regressor(")
    return "known_out[0] = 0.0;" not in native[begin : native.index("\n}\n", begin)]
