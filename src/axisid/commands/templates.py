"""The declaration that `axisid new` starts: complete, commented, and identified at once."""

import contextlib
from importlib import resources
from importlib.util import find_spec
from pathlib import Path

from axisid.modeling.library import LIBRARY
from axisid.modeling.quantities import check_name
from axisid.support.errors import ModelError, UsageError


def write_scaffold(name: str, *, newton: bool = True, toml: bool = True) -> Path:
    """Write ``NAME.toml`` or ``NAME.py`` into the current folder; return it.

    Raises
    ------
    UsageError
        The name cannot be an axis's or a module's, the file is there already, or the place cannot
        be written to.
    """
    _check(name, toml=toml)
    file = Path(f"{name}.toml" if toml else f"{name}.py")
    try:
        with file.open("x", encoding="utf-8") as stream:
            try:
                stream.write(scaffold(name, newton=newton, toml=toml))
                stream.flush()
            except OSError:
                with contextlib.suppress(OSError):
                    file.unlink()
                raise
    except FileExistsError as error:
        raise UsageError(f"{file} is there already; choose another name or move it.") from error
    except OSError as error:
        raise UsageError(f"{file} cannot be written: {error.strerror}.") from error
    return file


def scaffold(name: str, *, newton: bool, toml: bool) -> str:
    """The text of a declaration: one of `scaffolds`, in which it is called NAME."""
    file = f"{'newton' if newton else 'lagrange'}.{'toml' if toml else 'py.txt'}"
    template = resources.files("axisid.commands") / "scaffolds" / file
    return template.read_text(encoding="utf-8").replace("NAME", name)


def _check(name: str, *, toml: bool) -> None:
    try:
        check_name(name, "the axis")
    except ModelError as error:
        raise UsageError(str(error)) from error
    if name in LIBRARY:
        raise UsageError(f"{name!r} is an axis of the library; choose another name.")
    if not toml and find_spec(name) is not None and not Path(f"{name}.py").exists():
        raise UsageError(f"{name}.py would hide the Python module {name}; choose another name.")
