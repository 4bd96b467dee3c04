"""The command line: all commands, and the message and exit code of a failure.

Commands import the stages that they need when they run, so that help is instant.

Exit codes: 0 done, 1 generated code is stale or an internal fault, 2 usage, 3 data, 4 model,
6 estimation.
"""

import contextlib
import io
import os
import sys
import warnings
from collections.abc import Iterable
from textwrap import indent
from typing import Any, NoReturn

import click

from axisid.support.errors import AxisidError, asks_for_tracebacks
from axisid.support.one_thread import one_thread, without_arithmetic_warnings
from axisid.support.version import __version__

from .compare import compare, compare_results
from .export import export
from .fit import fit
from .fleet import fleet
from .generate import generate
from .identify import identify
from .law import law
from .new import new
from .paper import paper
from .show import show
from .study import study
from .sweep import sweep
from .trend import trend
from .twin import twin

_USAGE, _DATA, _INTERRUPTED = 2, 3, 130


_NO_MEMORY = (
    "there is not enough memory for this record and these options. Use only windows of the log "
    "(--window FROM..TO --window FROM..TO), which form one regression with one verdict, increase "
    "the decimation, or reduce the number of replicas (--bootstrap)."
)


@click.group(
    commands=[
        identify,
        fit,
        sweep,
        compare,
        compare_results,
        fleet,
        trend,
        law,
        study,
        twin,
        new,
        show,
        generate,
        export,
        paper,
    ],
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Example: axisid identify emps2015. Exit codes: 0 done, 1 stale generated code or "
    "internal fault, 2 usage, 3 data, 4 model, 6 estimation, 130 interrupted.",
)
@click.version_option(__version__, prog_name="axisid", message="%(prog)s %(version)s")
def cli() -> None:
    """Identify the parameters of one-degree-of-freedom electromechanical axes."""


def main() -> NoReturn:
    """Run the command line and exit; a failure is one message on stderr and an exit code."""
    one_thread()
    _fill_closed()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    code = _exit_code()
    for stream in filter(None, (sys.stdout, sys.stderr)):
        try:
            stream.flush()
        except OSError:  # unwritten output is discarded, so that the interpreter reports nothing
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    sys.exit(code)


def _run() -> Any:
    """Run the command, with each warning as one line on stderr, and return its exit code."""
    with warnings.catch_warnings():
        warnings.simplefilter("default", RuntimeWarning)
        without_arithmetic_warnings()
        # One line instead of Python's two lines, which name a line of the source.
        warnings.showwarning = lambda message, *_, **__: click.echo(f"axisid: {message}", err=True)
        code = cli.main(prog_name="axisid", standalone_mode=False)
    if sys.stdout is not None:
        sys.stdout.flush()
    return code


def _exit_code() -> Any:
    """Run the command and return its exit code; a failure is printed on stderr."""
    try:
        return _run()
    except click.exceptions.NoArgsIsHelpError as error:  # the message is the help
        click.echo(error.format_message(), err=True)
        return error.exit_code
    except click.ClickException as error:
        return _fail(error.format_message(), error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        return _fail("interrupted", _INTERRUPTED)
    except BrokenPipeError:
        return 1  # the reader has closed the pipe
    except MemoryError:
        return _fail(_NO_MEMORY, _DATA)
    except OSError as error:
        place = error.filename or "standard output or an output file"
        return _fail(f"{place} cannot be used: {error.strerror or error}.", _USAGE)
    except AxisidError as error:
        headline = getattr(error, "headline", str(error))
        return _fail(headline, error.exit_code, getattr(error, "mistakes", ()))
    except Exception as error:
        if asks_for_tracebacks():
            raise
        return _fail(
            f"internal fault: {type(error).__name__}: {error}. Run the command again with "
            "AXISID_DEBUG=1 in the environment, and report the traceback.",
            1,
        )


def _fill_closed() -> None:
    """Open each closed standard stream on the null device.

    Otherwise the next file that is opened, for instance a result, takes its number, and a library
    prints into it.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)


def _fail(message: str, code: int, mistakes: Iterable[str] = ()) -> int:
    """Print a message on stderr, with the mistakes of a file below it, and return the code."""
    with contextlib.suppress(OSError):  # if stderr is closed, only the exit code reports it
        click.echo(f"axisid: {' '.join(message.split())}", err=True)
        for mistake in mistakes:
            click.echo(indent(mistake, "  "), err=True)
    return code
