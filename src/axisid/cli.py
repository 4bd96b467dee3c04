"""The command line: the commands together, and what becomes of their failures.

Stages are imported by the commands that need them, when they run, so that help is instant.

Exit codes: 0 done, 1 generated code is stale or an internal fault, 2 usage, 3 data, 4 model,
6 estimation.
"""

import io
import os
import sys
import warnings
from collections.abc import Iterable
from textwrap import indent
from typing import Any, NoReturn

import click

from axisid import __version__
from axisid.compare_commands import compare, compare_results
from axisid.completion import completion
from axisid.declaration_commands import new, show
from axisid.export_command import export
from axisid.generate_command import generate
from axisid.identify_command import identify
from axisid.paper_command import paper
from axisid.sweep_command import sweep

_INTERRUPTED = 130


@click.group(
    commands=[
        identify,
        sweep,
        compare,
        compare_results,
        new,
        show,
        generate,
        export,
        paper,
        completion,
    ],
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Example: axisid identify emps2015. Exit codes: 0 done, 1 stale code or internal fault, "
    "2 usage, 3 data, 4 model, 6 estimation.",
)
@click.version_option(__version__, prog_name="axisid", message="%(prog)s %(version)s")
def cli() -> None:
    """Identify one-degree-of-freedom electromechanical axes, from Newton to trustworthy numbers."""


def main() -> NoReturn:
    """Run the command line: every failure is one sentence on stderr and an exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("default", RuntimeWarning)
            warnings.showwarning = _show_warning  # type: ignore[assignment]
            code = cli.main(prog_name="axisid", standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
    except click.ClickException as error:
        code = _refused(error)
    except (click.Abort, KeyboardInterrupt):
        code = _fail("interrupted", _INTERRUPTED)
    except BrokenPipeError:
        # Whoever read the output has left; nothing can be said to them.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 1
    except Exception as error:
        # Only an error that speaks to the user carries an exit code.
        known: int | None = getattr(error, "exit_code", None)
        if known is None and os.environ.get("AXISID_DEBUG"):
            raise
        if known is None:
            code = _fail(_fault(error), 1)
        else:
            headline = getattr(error, "headline", str(error))
            code = _fail(headline, known, getattr(error, "mistakes", ()))
    sys.exit(code)


def _show_warning(message: Warning | str, *_: Any) -> None:
    """One line on stderr in place of Python's two, which name a source line."""
    click.echo(f"axisid: {message}", err=True)


def _refused(error: click.ClickException) -> int:
    """What click says in one sentence; the help, which it gives for want of a command, whole."""
    if isinstance(error, click.exceptions.NoArgsIsHelpError):
        click.echo(error.format_message(), err=True)
        return error.exit_code
    return _fail(error.format_message(), error.exit_code)


def _fail(message: str, code: int, listed: Iterable[str] = ()) -> int:
    """One sentence on stderr; the mistakes of a declaration, one under the other."""
    click.echo(f"axisid: {' '.join(message.split())}", err=True)
    for mistake in listed:
        click.echo(indent(mistake, "  "), err=True)
    return code


def _fault(error: Exception) -> str:
    if isinstance(error, OSError):
        return f"{error.filename or 'standard output'} cannot be used: {error.strerror}."
    return (
        f"internal fault: {type(error).__name__}: {error}. Set AXISID_DEBUG=1 for the traceback "
        "and report it."
    )
