"""The feed-forward as a JavaScript module."""

from axisid.codegen.lowering import FeedForward, Program

from .shared import Language, comment, print_operations

JAVASCRIPT = Language(
    calls={
        **{name: f"Math.{name}" for name in ("abs", "sign", "sqrt", "sin", "cos")},
        "lt": lambda a, b: f"({a} < {b})",
        "select": lambda condition, a, b: f"({condition} ? {a} : {b})",
    },
    variable=str,
    name=lambda name, expression: f"  const {name} = {expression};",
)


def print_javascript(export: FeedForward) -> str:
    """Return the text of a module with the two functions."""
    force, control = export.functions
    motion = ", ".join(export.motion)
    lines = [f"// {comment(line)}" for line in export.about]
    lines += [f"const {c.name} = {c.value!r}; // {comment(c.comment)}" for c in export.constants]
    lines += _function(f"{force}({motion})", export.force)
    lines += _function(f"{control}({motion})", export.control, f"  const tau = {force}({motion});")
    return "\n".join([*lines, ""])


def _function(head: str, program: Program, *first: str) -> list[str]:
    texts, named = print_operations(program, JAVASCRIPT)
    value = texts[program.outputs[0].rows[0][0]]
    return [f"export function {head} {{", *first, *named, f"  return {value};", "}"]
