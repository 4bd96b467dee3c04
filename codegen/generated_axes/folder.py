"""The folder of generated code: write it, and check that no file in it is outdated."""

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from axisid.codegen.printers import print_c_loop_header
from axisid.modeling.declaration import Axis
from axisid.modeling.derivation import derive
from axisid.support.errors import UsageError
from axisid.support.files import read_regular, replace_file
from axisid.support.progress import Progress, with_progress

from .texts import FUNCTIONS, MANIFEST, axis_artefacts

_FOLDER = "output"
_MOST_SHOWN = 12  # lines of a difference
_LOOP = Path("loop.h")  # a header that the native code of every axis includes
_MARKS = (FUNCTIONS, MANIFEST)  # of a folder that was generated


@dataclass(frozen=True, slots=True, kw_only=True)
class OutdatedFile:
    """A file of the generated folder that differs from what would be generated.

    Attributes
    ----------
    path : Path
        The file, inside the folder.
    state : str
        ``missing``, ``stale`` (the content differs) or ``orphan``, a file of none of the axes.
    diff : str
        The first lines of a unified difference from the file to the generated text; empty for an
        orphan.
    """

    path: Path
    state: str
    diff: str = ""


def expected_files(axes: Iterable[Axis], progress: Progress | None = None) -> dict[Path, str]:
    """Return every generated file of the axes by its path in the folder.

    Parameters
    ----------
    axes : iterable of Axis
    progress : callable, optional
        Called before each axis with the number done, the total, and the axis's name.

    Raises
    ------
    ModelError
        An axis cannot be derived or lowered: nothing is generated for any.
    UsageError
        Two axes have the same name.
    """
    files = {_LOOP: print_c_loop_header()}
    for axis in with_progress(axes, progress, lambda axis: axis.name):
        for name, text in axis_artefacts(derive(axis)).items():
            path = Path(axis.name) / name
            if path in files:
                raise UsageError(f"two axes are named {axis.name!r}. Rename one of them.")
            files[path] = text
    return files


def write_files(folder: Path, files: Mapping[Path, str]) -> list[Path]:
    """Write the files that changed, and return their paths inside the folder.

    Each file is written completely or not at all; a manifest follows the other files of its folder.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    written = []
    for path in sorted(files, key=lambda p: (p.parent, p.name == MANIFEST, p.name)):
        if _read(folder / path) != files[path]:
            try:
                replace_file(folder / path, files[path])
            except OSError as error:
                raise UsageError(
                    f"{folder / path} cannot be written ({error.strerror}). The file is unchanged. "
                    f"Free disk space, or choose another folder with {_FOLDER}.",
                    code="file",
                ) from error
            written.append(path)
    return written


def check_files(
    folder: Path, files: Mapping[Path, str], *, others: Iterable[str] | None = None
) -> list[OutdatedFile]:
    """Return the files of a folder that differ from what would be generated.

    Parameters
    ----------
    folder : Path
    files : mapping of Path to str
        Generated texts, from `expected_files`.
    others : iterable of str, optional
        Names of further axes that may be generated in the folder. Files and folders next to those
        of axes are then ignored. Without it, everything in the folder must belong to the axes.
    """
    outdated = []
    for path, text in sorted(files.items()):
        there = _read(folder / path)
        if there != text:
            state = "missing" if there is None else "stale"
            outdated.append(
                OutdatedFile(path=path, state=state, diff=_diff(path, there or "", text))
            )
    found = {
        path.relative_to(folder)
        for path in folder.rglob("*")
        # Names that begin with a dot are temporary, of a concurrent or an interrupted run.
        if not (path.is_dir() or "__pycache__" in path.parts or path.name.startswith("."))
    }
    named = {path.parts[0] for path in found}
    empty = (p.name for p in folder.glob("[!.]*") if p.is_dir() and p.name not in named)
    present = {*found, *map(Path, empty)} - set(files)  # such as folders of former axes
    if others is not None:
        axes = {path.parts[0] for path in files}
        made = {p.name for p in folder.glob("*") if {Path(p.name, x) for x in _MARKS} <= present}
        present = {path for path in present if path.parts[0] in axes | made - set(others)}
    return [*outdated, *(OutdatedFile(path=path, state="orphan") for path in sorted(present))]


def _read(path: Path) -> str | None:
    """Return the text of a file; None if it does not exist, empty if it is not text."""
    try:
        return read_regular(path).decode()
    except (FileNotFoundError, NotADirectoryError):
        return None
    except UnicodeDecodeError:
        return ""
    except OSError as error:
        raise UsageError(
            f"{path} cannot be read ({error.strerror}). Remove it, or choose another folder with "
            f"{_FOLDER}.",
            code="file",
        ) from error


def _diff(path: Path, found: str, wanted: str) -> str:
    """Return the first twelve lines of a difference, and the number of further lines."""
    lines = [
        *difflib.unified_diff(
            found.splitlines(keepends=True),
            wanted.splitlines(keepends=True),
            f"{path} (on disk)",
            f"{path} (generated)",
            n=1,
        )
    ]
    shown, rest = lines[:_MOST_SHOWN], lines[_MOST_SHOWN:]
    more = sum(line[:1] in "+-" for line in rest)
    return "".join(shown) + (f"... and {more} more lines differ\n" if more else "")
