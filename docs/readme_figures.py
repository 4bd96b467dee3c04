"""Write the result that the README shows anew, from the run.toml and the command above it.

python docs/readme_figures.py FOLDER/DATA_EMPS.mat
"""

import json
import re
import shlex
import sys
from contextlib import redirect_stdout, suppress
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

from axisid.commands.main import main as axisid

README = Path(__file__).resolve().parents[1] / "README.md"
_BLOCK = re.compile(
    r"(?s)(```console\n\$ \.venv/bin/axisid )(identify emps run\.toml[^\n]*\n)(.*?)```"
)
_SAID = re.compile(r"(?s)```toml\nlog = \"DATA_EMPS\.mat\"\n(.*?)```")


def command(text: str, log: Path, folder: Path) -> list[str]:
    """Arguments of the command whose result the README shows, with its run.toml of a log."""
    said, found = _SAID.search(text), _BLOCK.search(text)
    if said is None or found is None:
        raise ValueError("the README has no run.toml of DATA_EMPS.mat, or no command with it")
    file = folder / "run.toml"
    file.write_text(f"log = {json.dumps(str(log.absolute()))}\n{said[1]}", encoding="utf-8")
    return [str(file) if a == file.name else a for a in shlex.split(found[2])]


def with_result(text: str, output: str) -> str:
    """The README with what the command prints."""
    result = output.rstrip()
    return _BLOCK.sub(lambda found: f"{found[1]}{found[2]}{result}\n```", text)


def main() -> None:
    """Run the command on a record and write the README."""
    text = README.read_text(encoding="utf-8")
    printed = StringIO()
    with TemporaryDirectory() as folder, suppress(SystemExit), redirect_stdout(printed):
        sys.argv = ["axisid", *command(text, Path(sys.argv[1]), Path(folder))]
        axisid()
    README.write_text(with_result(text, printed.getvalue()), encoding="utf-8")


if __name__ == "__main__":
    main()
