"""What a recipe of CONTRIBUTING has one write, so that a test can follow it."""

import os
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from axisid.estimation import choices

#: Finds a module that is no file of the tree, adds its row to a table, and runs command lines.
_FOLLOWED = """
import sys
from importlib import import_module
from importlib.util import spec_from_file_location

class Beside:
    @staticmethod
    def find_spec(name, path=None, target=None):
        return spec_from_file_location(name, {file!r}) if name == {module!r} else None

sys.meta_path.insert(0, Beside)
table = import_module({table!r})
table.{rows} += (eval({row!r}, vars(table)),)
from axisid.commands.main import main
for line in {lines!r}:
    sys.argv = ["axisid", *line.split()]
    try:
        main()
    except SystemExit as end:
        assert not end.code, line
"""


def recipe_blocks(title: str) -> list[str]:
    """The files of this folder that a recipe names, then its Python blocks."""
    root = Path(__file__).resolve().parents[2]
    text = (root / "CONTRIBUTING.md").read_text()
    below = text.partition(f"\n## {title}\n")[2].partition("\n## ")[0]
    files = re.findall(r"\((tests/recipes/\w+\.py)\)", below)
    blocks = re.findall(r"```python\n(.*?)```", below, re.DOTALL)
    return [*((root / file).read_text() for file in files), *blocks]


def row_of_recipe(title: str, module: str, patch: pytest.MonkeyPatch) -> Any:
    """The row of a recipe of `choices`, whose module is there as long as the patch is."""
    text, written = recipe_blocks(title)
    made = ModuleType(module)
    made.__package__ = module.rpartition(".")[0]
    patch.setitem(sys.modules, module, made)
    exec(text, vars(made))
    return eval(written, dict(vars(choices)))  # noqa: S307


def commands_with(
    folder: Path, title: str, *lines: str, module: str, table: str, rows: str
) -> subprocess.CompletedProcess[str]:
    """What command lines print in a process of their own, in which a recipe is followed.

    Parameters
    ----------
    folder : Path
        Where they run.
    title : str
        Of the recipe, which names a module and has its row in a block.
    lines : str
    module, table : str
        What the two are called.
    rows : str
        The rows' name in the table.
    """
    text, row = recipe_blocks(title)
    file = folder / f"{module.rpartition('.')[2]}.py"
    file.write_text(text)
    program = _FOLLOWED.format(
        file=str(file), module=module, table=table, rows=rows, row=row.strip(), lines=lines
    )
    return subprocess.run(
        [sys.executable, "-c", program],
        cwd=folder,
        env={**os.environ, "COLUMNS": "100"},
        capture_output=True,
        text=True,
        check=False,
    )
