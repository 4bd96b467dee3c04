"""Where commands write: the terminal, and files, whose places are checked before all else.

Documents are in colours and within the width of a terminal; a line says what takes long. What an
earlier run wrote is told by its content and may be written anew; all else is the user's.
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
    """Print a document: as it is on a pipe, dressed for a terminal."""
    # Help and what computes need neither of the two ways to draw.
    if not is_terminal(sys.stdout):
        from axisid.presentation.documents import plain_text

        click.echo(plain_text(document), nl=False)
        return
    from .rich_terminal import print_dressed

    coloured = not os.environ.get("NO_COLOR")
    print_dressed(document, sys.stdout, shutil.get_terminal_size().columns, coloured=coloured)


def is_terminal(stream: Any) -> bool:
    """Whether a stream is a terminal that knows colours and can erase a line."""
    return stream is not None and os.environ.get("TERM", "dumb") != "dumb" and bool(stream.isatty())


SECONDS_PER_LINE = 30.0  # of progress that no terminal shows


@contextlib.contextmanager
def progress_line(what: str, delay: float = 1.0) -> Iterator[Progress]:
    """Say on standard error what is going on, once that takes longer than a moment.

    It is drawn by a thread, so that what blocks (a compiler, a solver) is shown too, and erased at
    the end. Where standard error is no terminal, a line is printed every 30 s instead. What it
    gives is called as the `progress` of `sweep` and `compare`, and says what is done next.

    Parameters
    ----------
    what : str
        What is going on, until something else is said.
    delay : float
        Seconds until the line appears.
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
    """Print a line on standard error every 30 s that says what is going on."""
    said, ended, begun = [what], threading.Event(), monotonic()

    def say(done: int, total: int, what: str) -> None:
        said[0] = f"{what} ({done + 1} of {total})"

    def print_lines() -> None:
        while not ended.wait(SECONDS_PER_LINE):
            with contextlib.suppress(OSError, ValueError):  # nobody reads any more
                click.echo(f"axisid: {said[0]}, {monotonic() - begun:.0f} s", err=True)

    printer = threading.Thread(target=print_lines, daemon=True)
    printer.start()
    try:
        yield say
    finally:
        ended.set()
        printer.join()


def is_earlier(file: Path, kind: str) -> bool:
    """Whether a file is what a command of a kind writes, or is empty.

    Parameters
    ----------
    file : Path
        A regular file.
    kind : str
        As `kinds_of` has it.

    Raises
    ------
    OSError
        It cannot be read.
    """
    return kind in kinds_of(file) or not file.stat().st_size


json_option = click.option(
    "--json", "json_file", metavar="FILE", help="Write the result as JSON; - for standard output."
)
force_option = click.option(
    "--force", is_flag=True, help="Write over a file that this command did not write."
)


@dataclass(frozen=True, slots=True)
class Target:
    """Where a command is asked to write.

    Attributes
    ----------
    option : str
        That names the place.
    file : str or None
        None where it is not given.
    kind : str
        What the command writes there, as `is_earlier` knows it.
    endings : tuple of str
        Of names that say what is written, if they have to.
    """

    option: str
    file: str | None
    kind: str
    endings: tuple[str, ...] = ("",)


def check_targets(
    targets: Sequence[Target], inputs: Sequence[str | None], *, force: bool = False
) -> None:
    """Refuse places that cannot or must not be written to, before anything is computed.

    Parameters
    ----------
    targets : sequence of Target
    inputs : sequence of str or None
        Arguments that name files to read, which are never written to.
    force : bool
        Whether files may go that the command did not write.
    """
    taken = _read_by(inputs)
    for target in targets:
        if target.file is None:
            continue
        problem = _unfit(target, taken) or _foreign(target.file, target.kind, force=force)
        _refuse(target.file, problem, target.option)
        if not _is_special(target.file):
            real = os.path.realpath(target.file)
            taken[real] = f"{target.option} is written there; name another file"


def check_replaced(
    files: Mapping[Path, str], option: str, inputs: Sequence[str], *, force: bool
) -> None:
    """Refuse to lose what is there: inputs of the run, and what the command did not write.

    Parameters
    ----------
    files : mapping of Path to str
        What is to be written, with its kind as `is_earlier` knows it.
    option : str
        That names the place.
    inputs, force
        As in `check_targets`.
    """
    taken = _read_by(inputs)
    for file, kind in files.items():
        problem = taken.get(os.path.realpath(file), "") or _foreign(str(file), kind, force=force)
        folder = "it is a folder; take it away, or name another place" * file.is_dir()
        _refuse(str(file), problem or folder, option)


def _read_by(inputs: Sequence[str | None]) -> dict[str, str]:
    """What is said of the files that a run reads, by their real paths."""
    said = "it is an input of this run; name another file"
    files = [axis_file(given)[0] for given in inputs if given]
    return {os.path.realpath(file): said for file in (*files, *map(stages.log_of, files))}


def _refuse(file: str, problem: str, option: str) -> None:
    if problem:
        raise click.BadParameter(f"{file!r}: {problem}", param_hint=option)


def _unfit(target: Target, taken: Mapping[str, str]) -> str:
    """Why a place cannot be written to; empty if it can."""
    file, real = str(target.file), os.path.realpath(str(target.file))
    if file == "-" and target.option == "--json":
        return "standard output is closed" if sys.stdout is None else ""
    is_read_only = os.path.isfile(real) and not os.access(real, os.W_OK)
    ways = (
        (file in ("", "-") or os.path.isdir(file), "it is no file; name one"),
        (_is_special(file), ""),
        (real in taken, taken.get(real, "")),
        (not os.path.isdir(os.path.dirname(real)), "the folder does not exist; make it first"),
        (os.path.islink(real), "the link leads to itself; name another file"),
        (is_read_only, "the file is read-only; name another file"),
        (
            not file.endswith(target.endings),
            f"the name must end in {', '.join(target.endings)}",
        ),
    )
    found = [said for is_so, said in ways if is_so]
    return found[0] if found else _unwritable(real)


def _is_special(file: str) -> bool:
    """Whether it is there and is written to, not replaced: a device or a pipe."""
    return os.path.exists(file) and not os.path.isfile(file)


def _unwritable(path: str) -> str:
    """Why nothing can be made at a path; only making a file beside it tells that everywhere.

    The file has a name as long as the one through which the path is written to.
    """
    folder, name = os.path.split(path)
    try:
        with tempfile.NamedTemporaryFile(prefix=f".{name}.", dir=folder):
            return ""
    except OSError as error:
        return f"no file can be made there ({error.strerror}); name another place"


def _foreign(file: str, kind: str, *, force: bool) -> str:
    """Why what is there must stay: the command did not write it; empty if it may go."""
    if force or file == "-" or not os.path.isfile(file):
        return ""
    try:
        if is_earlier(Path(file), kind):
            return ""
    except OSError as error:
        return f"what is there cannot be read ({error.strerror}); name another file"
    return (
        "it is there and this command did not write it; name another file, or add --force to lose "
        "what it holds"
    )


def check_folder(
    folder: str | None,
    option: str,
    files: Mapping[str, str],
    *,
    force: bool = False,
) -> None:
    """Refuse a folder that can neither be used nor made, or that holds files of others.

    Parameters
    ----------
    folder : str or None
        It may be new, with the folders that it is in.
    option : str
        That names it.
    files : mapping of str to str
        What may be written into it, by name, with its kind as `is_earlier` knows it.
    force : bool
        Whether files may go that the command did not write.
    """
    if folder is None:
        return
    place = Path(os.path.abspath(folder))
    existing = next(each for each in (place, *place.parents) if os.path.lexists(each))
    if not folder or not existing.is_dir():
        _refuse(folder, "it is no folder, nor a new one in a folder; name one", option)
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
    """Write a page of HTML of a result, which says what command made it and when; tell the file.

    Parameters
    ----------
    file : str
    page : callable
        Gives the page of the result, with `command`, `made` and `wording`.
    result : Presentable
    """
    write_output(file, page(result, command=command_line(), made=datetime.now().astimezone()))
    return [file]


def command_line() -> str:
    """The command that runs, as it would be typed."""
    return shlex.join(["axisid", *sys.argv[1:]])


#: A place, None where it is not asked for, and what writes there and returns what is told of it.
Way: TypeAlias = tuple[str | None, Callable[[str], Iterable[object] | None]]


def put_result(result: "Presentable | stages.Trend", json_file: str | None, *ways: Way) -> None:
    """Put out a result as it is; see `put_out`."""
    put_out(json_file, result.to_dict, lambda: print_result(result), *ways)


def put_out(
    json_file: str | None,
    document: Callable[[], Mapping[str, Any]],
    show: Callable[[], None],
    *ways: Way,
) -> None:
    """Put out a result every way that is asked for; one that fails costs none of the others.

    It is printed last, when nothing can be lost any more by who reads it.

    Parameters
    ----------
    json_file : str or None
        Where ``--json`` says.
    document : callable
        Gives what is written there.
    show : callable
        Prints the result, unless JSON is on standard output.
    *ways : (str or None, callable)
        Further places, in their order.

    Raises
    ------
    AxisidError, OSError
        As the first that failed.
    """
    written: Way = (json_file, lambda file: write_output(file, json_text(document())))
    shown: Way = (None if json_file == "-" else "", lambda _: show())
    made, refused = list[object](), list[Exception]()
    for place, put in (written, *ways, shown):
        if place is not None:
            try:
                made += put(place) or ()
            except (AxisidError, OSError) as error:
                refused.append(error)
    try:
        for path in made:
            click.echo(f"wrote {path}", err=json_file == "-")
        for further in refused[1:]:
            click.echo(f"axisid: {further}", err=True)
    finally:
        if refused:
            raise refused[0]


def print_result(result: Shown) -> None:
    """Print a result as its summary, dressed on a terminal."""
    print_document(stages.as_blocks(result))
