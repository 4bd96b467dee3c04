"""The feed-forward as C99 that needs <math.h> only.

Names end in an underscore, as in all C text here, so that none is a macro of a header.
"""

import re

from axisid.codegen.lowering import FeedForward, Program

from .c import C, print_c_helpers
from .shared import comment, print_operations


def print_c99(export: FeedForward) -> str:
    """Return the text of a C file with the two functions."""
    force, control = export.functions
    arguments = ", ".join(f"double {name}_" for name in export.motion)
    passed = ", ".join(f"{name}_" for name in export.motion)
    constants = [
        f"    static const double {c.name}_ = {c.value!r}; /* {comment(c.comment)} */"
        for c in export.constants
    ]
    ports = [*export.motion, *(c.name for c in export.constants)]
    functions = "\n".join(
        (
            f"/* {comment(export.force_about)} */\ndouble {force}({arguments})\n{{",
            *constants,
            *_body(export.force, ports),
            f"}}\n\n/* {comment(export.control_about)} */\ndouble {control}({arguments})\n{{",
            f"    const double tau_ = {force}({passed});",
            *_body(export.control, ["tau"]),
            "}\n",
        )
    )
    helpers = print_c_helpers(functions)
    # Helpers bear the function's name: a header that the file is joined with may have a `select`.
    for name in re.findall(r"static inline double (\w+)\(", helpers):
        helpers, functions = (
            re.sub(rf"\b{name}\(", f"{force}_{name}(", text) for text in (helpers, functions)
        )
    about = "\n   ".join(map(comment, export.about))
    units = ", ".join(f"{name} in {unit}" for name, unit in export.motion.items())
    return (
        f"/* {about}\n*/\n\n#include <math.h>\n\n"
        + (f"{helpers}\n" if helpers else "")
        + f"/* {comment(units)}. */\n"
        f"double {force}({arguments});\ndouble {control}({arguments});\n\n{functions}"
    )


def _body(program: Program, elements: list[str]) -> list[str]:
    texts, lines = print_operations(program, C)
    used = {op.symbol for op in program.operations if op.name == "input"}
    unused = [f"    (void){name}_;" for name in elements if name not in used]
    return [*unused, *lines, f"    return {texts[program.outputs[0].rows[0][0]]};"]
