"""The link from results, which hold data, to `axisid.presentation`, which shows them."""

from importlib import import_module
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure


class Shown:
    """Base of a result that has a view as text and in a notebook.

    `axisid.presentation` makes the view and is imported when it is needed. A result whose type it
    does not know has a method `document`.
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
    """Base of a result that also has views as plain data, file, figure and dataframe."""

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the content of ``--json``: plain numbers, texts and lists."""
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
            ``method="idm-ls"``: the method, if there are several. ``record=2``: the record, if
            there are several. ``ax``: Matplotlib axes to draw on, one per panel of the figure (a
            single one for one panel). By default a new figure is made.

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
            By default the installed one, pandas first.

        Raises
        ------
        UsageError
            The result has no table of numbers, or there is no such library.
        """
        return view_of("as_frame", self, library=library)


def view_of(view: str, result: object, *what: Any, **how: Any) -> Any:
    """Return a view of a result, made by a function of `axisid.presentation.views`.

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
