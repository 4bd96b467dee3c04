"""Find an axis by its name in the library, or in a file of the user's.

A Python file is run; a TOML file never is.
"""

import contextlib
import os
import runpy
import sys
import traceback
from pathlib import Path
from typing import Any

from axisid.modeling.declaration import Axis
from axisid.modeling.library import LIBRARY, library_axis
from axisid.support.errors import ModelError, quoted, refuse

from .toml_axis import axis_from_toml


def load_axis(name: str | Path) -> Axis:
    """Return a library axis by name, or the axis declared in a Python or TOML file.

    A Python file is run as a program is: load those that you trust. A TOML file is only read.

    Parameters
    ----------
    name : str or Path
        A name of the library (``emps``), ``FILE.toml``, ``FILE.py`` or ``FILE.py:VARIABLE`` where
        the file declares several axes.

    Raises
    ------
    ModelError
        There is no such axis, or the file does not import or declares none.
    """
    if not isinstance(name, (str, Path)):
        raise ModelError(
            f"the axis is {quoted(name)}; give the name of one of the library, or of a file that "
            "declares one."
        )
    name = str(name)
    if name in LIBRARY:
        return library_axis(name)
    path, _, variable = name.partition(".py:")
    file = Path(f"{path}.py" if variable else name)
    refuse(
        ModelError,
        (
            file.suffix not in (".py", ".toml"),
            f"there is no axis {name!r}: give one of the library ({', '.join(LIBRARY)}) or a "
            "file that declares one, such as my_axis.toml or my_axis.py; `axisid new my_axis` "
            "starts one",
        ),
        (
            not os.path.isfile(file),  # which takes any name
            f"there is no axis file {str(file)!r}, or it is no regular file; check the path",
        ),
        code="axis-file",
    )
    if file.suffix == ".toml":
        return axis_from_toml(file)
    return _only_axis(_run(file), file, variable)


def _run(file: Path) -> dict[str, Any]:
    """Names that the file binds. It is run from its text: compiled files may be of an older one."""
    folder = str(file.resolve().parent)
    sys.path.insert(0, folder)
    try:
        # What the file prints must not get between the results on standard output.
        with contextlib.redirect_stdout(sys.stderr):
            return runpy.run_path(str(file), run_name=f"axisid_user_{file.stem}")
    except ModelError as error:
        raise ModelError(f"{file}, {_line(error, file)}: {error}", code="axis-file") from error
    except (Exception, SystemExit) as error:
        raise ModelError(
            f"{file} does not import: {type(error).__name__} at {_line(error, file)}: {error}",
            code="axis-file",
        ) from error
    finally:
        if folder in sys.path:
            sys.path.remove(folder)


def _line(error: BaseException, file: Path) -> str:
    if isinstance(error, SyntaxError) and error.lineno:
        return f"line {error.lineno}"
    own = [f for f in traceback.extract_tb(error.__traceback__) if Path(f.filename) == file]
    return f"line {own[-1].lineno}" if own else "an unknown line"


def _only_axis(bound: dict[str, Any], file: Path, variable: str) -> Axis:
    """The axis of a variable; else the one there is, or of several the one called ``axis``."""
    axes = {name: value for name, value in bound.items() if isinstance(value, Axis)}
    wanted = variable or (next(iter(axes)) if len(axes) == 1 else "axis")
    refuse(
        ModelError,
        (not axes, f"{file} declares no axis; bind the result of newton(...) to a name"),
        (
            wanted not in axes,
            f"{file} declares {', '.join(axes)}; choose one with {file}:NAME",
        ),
        code="axis-file",
    )
    return axes[wanted]
