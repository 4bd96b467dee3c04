"""Base classes of results, whose methods call `axisid.presentation` to show the results."""

from importlib import import_module
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure


class Shown:
    """Base of a result that can be shown as text and in a notebook.

    `axisid.presentation` makes these views; it is imported when a view is requested. A result of a
    type that `axisid.presentation` does not know has a method `document`.
    """

    __slots__ = ()

    def summary(self) -> str:
        """Return the result as text."""
        return str(view_of("as_text", self))

    def __str__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
        return str(view_of("as_html", self))


class Presentable(Shown):
    """Base of a result that is also available as plain data, file, figure and dataframe."""

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain numbers, texts and lists, the content of ``--json``."""
        return dict(view_of("as_document", self))

    def save(self, file: "str | Path", **how: Any) -> "Path":
        """Write `to_dict` as JSON; an incomplete file is never left behind.

        `load_result` reads the file of an identification, a fit, a validation of a fit or a study.

        Parameters
        ----------
        file : str or Path
            Name that ends in ``.json``.
        **how
            Arguments of `to_dict`: ``draws=2000`` for an identification.

        Raises
        ------
        UsageError
            The name does not end in ``.json``, or the file cannot be written.
        """
        return cast("Path", view_of("saved_as", self, file, **how))

    def plot(self, what: str = "", **how: Any) -> "Figure":
        """Draw one of the result's figures.

        Parameters
        ----------
        what : str
            Name of the figure, if the result has several.
        **how
            ``method="idm-ls"``: the method, if the result has several. ``record=2``: the record, if
            the result has several. ``ax``: Matplotlib axes to draw on, a sequence with one for each
            panel of the figure, or a single object for one panel; by default a new figure is made.

        Raises
        ------
        UsageError
            There is no such figure, or it has no data.
        """
        return cast("Figure", view_of("figure_of", self, what, **how))

    def to_frame(self, library: str | None = None) -> Any:
        """Return the numbers of the result as a dataframe.

        Parameters
        ----------
        library : {"pandas", "polars"}, optional
            Library of the dataframe; by default pandas if it is installed, otherwise polars.

        Raises
        ------
        UsageError
            The result has no table of numbers, or the library is unknown or not installed.
        """
        return view_of("as_frame", self, library=library)


def view_of(view: str, result: object, *what: Any, **how: Any) -> Any:
    """Return the value of a function of `axisid.presentation.views` for a result.

    Parameters
    ----------
    view : str
        Name of the function.
    result : object
    *what, **how
        Further arguments of the function.
    """
    return getattr(import_module("axisid.presentation.views"), view)(result, *what, **how)


def sentence_of(finding: object) -> str:
    """Return the sentence of a finding, as `axisid.presentation.sentences` words it."""
    return str(import_module("axisid.presentation.sentences").sentence(finding))
