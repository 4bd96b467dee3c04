"""Output of commands: to the terminal, and to files, whose paths are checked first.

Documents are coloured and fitted to the width of a terminal. A progress line names the current step
if it takes long. A file that an earlier run of the same command wrote is recognised by its content
and may be overwritten; any other file belongs to the user.
"""

import contextlib
import os
import shlex
import shutil
import sys
import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, TypeAlias

import click

from axisid.support.errors import AxisidError
from axisid.support.files import axis_file, json_text, kinds_of, write_file
from axisid.support.presentable import Presentable, Shown
from axisid.support.progress import Progress

from . import stages

if TYPE_CHECKING:
    from axisid.presentation.documents import Document


def print_document(document: "Document") -> None:
    """Print a document: plain if standard output is not a terminal, otherwise coloured."""
    # Imported here, because help and computations need neither way of drawing.
    if not is_terminal(sys.stdout):
        from axisid.presentation.documents import plain_text

        click.echo(plain_text(document), nl=False)
        return
    from .rich_terminal import print_dressed

    coloured = not os.environ.get("NO_COLOR")
    print_dressed(document, sys.stdout, shutil.get_terminal_size().columns, coloured=coloured)


def is_terminal(stream: Any) -> bool:
    """Return whether a stream is a terminal that knows colours and can erase a line."""
    return stream is not None and os.environ.get("TERM", "dumb") != "dumb" and bool(stream.isatty())


SECONDS_PER_LINE = 30.0  # between lines of progress, if standard error is not a terminal


@contextlib.contextmanager
def progress_line(what: str, delay: float = 1.0) -> Iterator[Progress]:
    """Show the current step on standard error, if it takes longer than `delay`.

    Yields a function that names the next step, with the arguments of `Progress`: number of steps
    done, total, text. A thread draws the line, so that a blocking step (a compiler, a solver) is
    shown too. The line is erased at the end. If standard error is not a terminal, a line is printed
    every 30 s instead.

    Parameters
    ----------
    what : str
        Name of the first step.
    delay : float
        Time until the line appears, s.
    """
    if not is_terminal(sys.stderr):
        with _progress_in_lines(what) as say_in_lines:
            yield say_in_lines
        return
    from rich.console import Console
    from rich.progress import Progress as Line, TextColumn, TimeElapsedColumn

    line = Line(
        TextColumn("{task.description}", markup=False),
        TimeElapsedColumn(),
        console=Console(file=sys.stderr),
        redirect_stdout=False,
        transient=True,
    )
    task = line.add_task(what, total=None)

    def say(done: int, total: int, what: str) -> None:
        line.update(task, description=f"{what} ({done + 1} of {total})")

    timer = threading.Timer(delay, line.start)
    timer.daemon = True
    timer.start()
    try:
        yield say
    finally:
        timer.cancel()
        timer.join()
        line.stop()


@contextlib.contextmanager
def _progress_in_lines(what: str) -> Iterator[Progress]:
    """Print a line with the current step on standard error every 30 s."""
    current, ended, begun = [what], threading.Event(), monotonic()

    def say(done: int, total: int, what: str) -> None:
        current[0] = f"{what} ({done + 1} of {total})"

    def print_lines() -> None:
        while not ended.wait(SECONDS_PER_LINE):
            with contextlib.suppress(OSError, ValueError):  # standard error was closed
                click.echo(f"axisid: {current[0]}, {monotonic() - begun:.0f} s", err=True)

    printer = threading.Thread(target=print_lines, daemon=True)
    printer.start()
    try:
        yield say
    finally:
        ended.set()
        printer.join()


def is_earlier(file: Path, kind: str) -> bool:
    """Return whether an earlier run of a command wrote a file, or the file is empty.

    Parameters
    ----------
    file : Path
        A regular file.
    kind : str
        Kind of file that the command writes, as in `kinds_of`.

    Raises
    ------
    OSError
        The file cannot be read.
    """
    return kind in kinds_of(file) or not file.stat().st_size


json_option = click.option(
    "--json",
    "json_file",
    metavar="FILE",
    help="Write the result as JSON into this file. - stands for standard output.",
)
force_option = click.option(
    "--force",
    is_flag=True,
    help="Overwrite a file even if this command did not write it. Without --force, only an empty "
    "file or a file that this command wrote is overwritten.",
)


@dataclass(frozen=True, slots=True)
class Target:
    """A file that a command is asked to write.

    Attributes
    ----------
    option : str
        Option that names the file.
    file : str or None
        Name of the file; None if the option is not given.
    kind : str
        Kind of file, as in `is_earlier`.
    endings : tuple of str
        Permitted endings of the name.
    """

    option: str
    file: str | None
    kind: str
    endings: tuple[str, ...] = ("",)


def check_targets(
    targets: Sequence[Target], inputs: Sequence[str | None], *, force: bool = False
) -> None:
    """Refuse files that cannot or must not be written, before anything is computed.

    Parameters
    ----------
    targets : sequence of Target
        The files to be written.
    inputs : sequence of str or None
        Arguments that name files to read, which are never written to.
    force : bool
        Whether files that the command did not write may be overwritten.
    """
    taken = _read_by(inputs)
    for target in targets:
        if target.file is None:
            continue
        problem = _unfit(target, taken) or _foreign(target.file, target.kind, force=force)
        _refuse(target.file, problem, target.option)
        if not _is_special(target.file):
            real = os.path.realpath(target.file)
            taken[real] = f"{target.option} is written to the same file. Name another file"


def check_replaced(
    files: Mapping[Path, str], option: str, inputs: Sequence[str], *, force: bool
) -> None:
    """Refuse to overwrite inputs of the run and files that the command did not write.

    Parameters
    ----------
    files : mapping of Path to str
        Files to be written, with their kind as in `is_earlier`.
    option : str
        Option that names the place.
    inputs, force
        As in `check_targets`.
    """
    taken = _read_by(inputs)
    for file, kind in files.items():
        problem = taken.get(os.path.realpath(file), "") or _foreign(str(file), kind, force=force)
        folder = "it is a folder. Remove the folder, or name another place" * file.is_dir()
        _refuse(str(file), problem or folder, option)


def _read_by(inputs: Sequence[str | None]) -> dict[str, str]:
    """Return the real path of each input file, with the reason why it must not be overwritten.

    The log that a run.toml describes is an input too.
    """
    reason = "it is an input of this run. Name another file"
    files = [axis_file(given)[0] for given in inputs if given]
    return {os.path.realpath(file): reason for file in (*files, *map(stages.log_of, files))}


def _refuse(file: str, problem: str, option: str) -> None:
    """Refuse an option whose file has a problem; an empty problem means that there is none."""
    if problem:
        raise click.BadParameter(f"{file!r}: {problem}.", param_hint=option)


def _unfit(target: Target, taken: Mapping[str, str]) -> str:
    """Return the reason why a file cannot be written to; empty if it can.

    `taken` has the reason for files that must not be written, by their real path.
    """
    file, real = str(target.file), os.path.realpath(str(target.file))
    if file == "-" and target.option == "--json":
        return "standard output is closed" if sys.stdout is None else ""
    is_read_only = os.path.isfile(real) and not os.access(real, os.W_OK)
    # The first condition that is true decides.
    cases = (
        (file in ("", "-") or os.path.isdir(file), "it is not a file. Name a file"),
        (_is_special(file), ""),
        (real in taken, taken.get(real, "")),
        (
            not os.path.isdir(os.path.dirname(real)),
            "the folder does not exist. Create the folder first",
        ),
        (os.path.islink(real), "the link points to itself. Name another file"),
        (is_read_only, "the file is read-only. Name another file"),
        (
            not file.endswith(target.endings),
            f"the name must end in {', '.join(target.endings)}. Name another file",
        ),
    )
    found = [problem for is_so, problem in cases if is_so]
    return found[0] if found else _unwritable(real)


def _is_special(file: str) -> bool:
    """Return whether a file exists and is written to, not replaced: a device or a pipe."""
    return os.path.exists(file) and not os.path.isfile(file)


def _unwritable(path: str) -> str:
    """Return the reason why no file can be created at a path; empty if it can.

    A temporary file is created in the same folder, because no other test works on every system. Its
    name is as long as that of the temporary file through which the path will be written.
    """
    folder, name = os.path.split(path)
    try:
        with tempfile.NamedTemporaryFile(prefix=f".{name}.", dir=folder):
            return ""
    except OSError as error:
        return f"no file can be created there ({error.strerror}). Name another place"


def _foreign(file: str, kind: str, *, force: bool) -> str:
    """Return the reason why an existing file must be kept; empty if it may be overwritten.

    `kind` is the kind of file that the command writes, as in `is_earlier`.
    """
    if force or file == "-" or not os.path.isfile(file):
        return ""
    try:
        if is_earlier(Path(file), kind):
            return ""
    except OSError as error:
        return f"the file exists and cannot be read ({error.strerror}). Name another file"
    return (
        "the file exists and this command did not write it. Name another file, or add --force to "
        "overwrite its content"
    )


def check_folder(
    folder: str | None,
    option: str,
    files: Mapping[str, str],
    *,
    force: bool = False,
) -> None:
    """Refuse a folder that cannot be used or created, or in which a user's file would be replaced.

    Parameters
    ----------
    folder : str or None
        The folder. It and its parents may be new. None if no folder is asked for.
    option : str
        Option that names the folder.
    files : mapping of str to str
        Files that may be written into it, by name, with their kind as in `is_earlier`.
    force : bool
        Whether files that the command did not write may be overwritten.
    """
    if folder is None:
        return
    place = Path(os.path.abspath(folder))
    existing = next(each for each in (place, *place.parents) if os.path.lexists(each))
    if not folder or not existing.is_dir():
        problem = "it is not a folder, and no folder can be created there. Name a folder"
        _refuse(folder, problem, option)
    _refuse(folder, _unwritable(str(existing / next(iter(files), "new"))), option)
    inside = {Path(folder, name): kind for name, kind in files.items()}
    check_replaced(inside, option, (), force=force)


def write_output(file: str | None, text: str) -> None:
    """Write a text into a file, or to standard output for ``-`` or None."""
    if file is None or file == "-":
        click.echo(text, nl=False)
    else:
        write_file(Path(file), text)


def write_page(file: str, page: Callable[..., str], result: Presentable) -> list[str]:
    """Write the HTML page of a result with command and date; return the file in a list.

    Parameters
    ----------
    file : str
    page : callable
        Returns the page of the result, with the arguments `command` and `made`.
    result : Presentable
    """
    write_output(file, page(result, command=command_line(), made=datetime.now().astimezone()))
    return [file]


def command_line() -> str:
    """Return the running command as it would be typed."""
    return shlex.join(["axisid", *sys.argv[1:]])


#: A file or folder (None if it is not asked for), and a function that writes there. The function
#: returns the files that it wrote, or None.
Way: TypeAlias = tuple[str | None, Callable[[str], Iterable[object] | None]]


def put_result(result: "Presentable | stages.Trend", json_file: str | None, *ways: Way) -> None:
    """Print a result, and write it to every file asked for; see `put_out`."""
    put_out(json_file, result.to_dict, lambda: print_result(result), *ways)


def put_out(
    json_file: str | None,
    document: Callable[[], Mapping[str, Any]],
    show: Callable[[], None],
    *ways: Way,
) -> None:
    """Print a result, and write it to every requested file; a failure does not stop the others.

    The order is JSON, terminal, further files. The result is printed before a page is made, which
    may take long. If the reader of standard output closes the pipe, all files are still written.

    Parameters
    ----------
    json_file : str or None
        File of ``--json``; None for none.
    document : callable
        Returns the content of that file.
    show : callable
        Prints the result, unless JSON is on standard output.
    *ways : (str or None, callable)
        Further files or folders, each with the function that writes there (`Way`).

    Raises
    ------
    AxisidError, OSError
        The first failure.
    """
    written: Way = (json_file, lambda file: write_output(file, json_text(document())))
    shown: Way = (None if json_file == "-" else "", lambda _: show())
    made, failures = list[object](), list[Exception]()
    for place, put in (written, shown, *ways):
        if place is not None:
            try:
                made += put(place) or ()
            except (AxisidError, OSError) as error:
                failures.append(error)
    try:
        for path in made:
            click.echo(f"wrote {path}", err=json_file == "-")
        for further in failures[1:]:
            click.echo(f"axisid: {further}", err=True)
    finally:
        if failures:
            raise failures[0]


def print_result(result: Shown) -> None:
    """Print the summary of a result, coloured on a terminal."""
    print_document(stages.as_blocks(result))
