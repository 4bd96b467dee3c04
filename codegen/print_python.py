"""The feed-forward as plain Python: nothing but ``math``."""

from .feed_forward import FeedForward
from .printing import Language, Truth, comment, condition, distinct_names, print_operations
from .program import OPERATIONS, Program

_BUILT_IN = ("abs", "min", "max")
_NUMBER = "float({})"
_TAKEN = frozenset({"math", "float"})


def print_python(export: FeedForward) -> str:
    """Return the text of a Python module with the two functions."""
    force, control = export.functions
    taken = {*_TAKEN, force.lower(), control.lower(), "tau"}
    names = distinct_names([*export.motion, *(c.name for c in export.constants)], str, taken)
    language = _language({**names, "tau": "tau"})
    arguments = ", ".join(f"{names[name]}: float" for name in export.motion)
    passed = ", ".join(names[name] for name in export.motion)
    about = "\n".join(map(comment, export.about)).replace('"', "'")
    units = ", ".join(f"{names[name]} in {unit}" for name, unit in export.motion.items())
    lines = [f"{names[c.name]} = {c.value!r}  # {comment(c.comment)}" for c in export.constants]
    for name, text, program, first in (
        (force, export.force_about, export.force, []),
        (control, export.control_about, export.control, [f"    tau = {force}({passed})"]),
    ):
        said = f"{comment(text)}\n\n    {comment(units)}.\n    "
        lines += [f'\n\ndef {name}({arguments}) -> float:\n    """{said}"""', *first]
        lines += _body(program, language)
    used = "import math\n\n" if any("math." in line for line in lines) else ""
    return f'"""{about}\n"""\n\n{used}' + "\n".join(lines) + "\n"


def _body(program: Program, language: Language) -> list[str]:
    texts, lines = print_operations(program, language)
    return [*lines, f"    return {texts[program.outputs[0].rows[0][0]]}"]


def _language(names: dict[str, str]) -> Language:
    return Language(
        calls={
            **{name: name if name in _BUILT_IN else f"math.{name}" for name in OPERATIONS},
            "sign": lambda a: f"float(({a} > 0.0) - ({a} < 0.0))",
            "lt": lambda a, b: Truth(f"{a} < {b}", _NUMBER),
            "le": lambda a, b: Truth(f"{a} <= {b}", _NUMBER),
            "eq": lambda a, b: Truth(f"{a} == {b}", _NUMBER),
            "not": lambda a: Truth(f"not ({_if(a)})", _NUMBER),
            "and": lambda a, b: Truth(f"({_if(a)}) and ({_if(b)})", _NUMBER),
            "or": lambda a, b: Truth(f"({_if(a)}) or ({_if(b)})", _NUMBER),
            "select": lambda c, a, b: f"({a} if {_if(c)} else {b})",
        },
        variable=lambda element: names[element],
        name=lambda name, expression: f"    {name} = {expression}",
    )


def _if(text: str) -> str:
    return condition(text, "{} != 0.0")
