"""What commands use of the rooms below, each name imported when it is asked for.

The command line starts without them, and so does help. The names stand in the stub beside this
file, which also says their types.
"""

import ast
from pathlib import Path

import lazy_loader

_STUB = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
_NAMES = {
    str(node.module).removeprefix("axisid."): [alias.name for alias in node.names]
    for node in _STUB.body
    if isinstance(node, ast.ImportFrom)
}
__getattr__, __dir__, __all__ = lazy_loader.attach("axisid", submod_attrs=_NAMES)
