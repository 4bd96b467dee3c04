"""Write the result that the README shows anew, from the command above it.

python docs/readme_figures.py FOLDER/DATA_EMPS.mat
"""

import re
import shlex
import sys
from contextlib import redirect_stdout, suppress
from io import StringIO
from pathlib import Path

from axisid.commands.main import main as axisid

README = Path(__file__).resolve().parents[1] / "README.md"
_BLOCK = re.compile(
    r"(?s)(```console\n\$ \.venv/bin/axisid )(identify emps DATA_EMPS[^\n]*\n)(.*?)```"
)


def command(text: str) -> list[str]:
    """Arguments of the command whose result the README shows."""
    found = _BLOCK.search(text)
    if found is None:
        raise ValueError("the README has no `identify emps DATA_EMPS.mat`")
    return shlex.split(found[2])


def with_result(text: str, output: str) -> str:
    """The README with what the command prints."""
    result = output.rstrip()
    return _BLOCK.sub(lambda found: f"{found[1]}{found[2]}{result}\n```", text)


def main() -> None:
    """Run the command on a record and write the README."""
    text = README.read_text(encoding="utf-8")
    arguments = [sys.argv[1] if a == "DATA_EMPS.mat" else a for a in command(text)]
    printed = StringIO()
    sys.argv = ["axisid", *arguments]
    with suppress(SystemExit), redirect_stdout(printed):
        axisid()
    README.write_text(with_result(text, printed.getvalue()), encoding="utf-8")


if __name__ == "__main__":
    main()
