"""Commands run in this process, and what every one of them keeps to."""

import contextlib
import io
import sys
from pathlib import Path
from unittest import mock

from axisid.commands.main import main
from tests.fuzz.cases import WrongError

CODES = {0, 2, 3, 4, 6}


def run(*arguments: object) -> tuple[int, str, str]:
    """Run the command line: exit code, standard output, standard error."""
    out, err, code = io.StringIO(), io.StringIO(), 0
    argv = ["axisid", *map(str, arguments)]
    with (
        mock.patch.object(sys, "argv", argv),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            main()
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else 0 if stop.code is None else 1
    return code, out.getvalue(), err.getvalue()


def kept_to(*arguments: object, output: Path) -> tuple[int, str]:
    """Run a command that writes a file; exit code and what it wrote.

    It ends with a documented exit code and one sentence, and writes the file whole or not at all.

    Raises
    ------
    WrongError
        It does not.
    """
    output.unlink(missing_ok=True)
    before = set(output.parent.iterdir())
    code, _, err = run(*arguments)
    if code not in CODES or "internal fault" in err or "Traceback" in err:
        raise WrongError(f"exit code {code}: {err}")
    if code and not err.startswith("axisid: "):
        raise WrongError(f"no sentence: {err}")
    if left := set(output.parent.iterdir()) - before - ({output} if code == 0 else set()):
        raise WrongError(f"left behind: {sorted(map(str, left))}")
    return code, output.read_text(encoding="utf-8") if code == 0 else ""
