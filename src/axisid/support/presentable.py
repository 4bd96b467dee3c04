"""The one way from a result to what it looks like: results hold data, presentation shows them."""

from importlib import import_module
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure


class Shown:
    """A result that can be looked at: as text and in a notebook.

    What it looks like is the affair of `axisid.presentation`, which is imported when it is asked;
    a result that it does not know has a `document` of its own.
    """

    __slots__ = ()

    def summary(self) -> str:
        """The result as text."""
        return str(view_of("as_text", self))

    def __str__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
        return str(view_of("as_html", self))


class Presentable(Shown):
    """A result that can be looked at as plain data and in a figure too."""

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the content of ``--json``: plain numbers, texts and lists."""
        return dict(view_of("as_document", self))

    def save(self, file: "str | Path", **how: Any) -> "Path":
        """Write `to_dict` as JSON, whole or not at all.

        Of an identification, a fit, its validation and a study `load_result` reads it back.

        Parameters
        ----------
        file : str or Path
            Ends in ``.json``.
        **how
            As `to_dict` takes it: ``draws=2000`` of an identification.

        Raises
        ------
        UsageError
            The ending is another one, or the file cannot be written.
        """
        return cast("Path", view_of("saved_as", self, file, **how))

    def plot(self, what: str = "", **how: Any) -> "Figure":
        """Draw one of the result's figures.

        Parameters
        ----------
        what : str
            Which one, if there are several.
        **how
            Of which method, if there are several: ``method="idm-ls"``; of which record, if there
            are several: ``record=2``; ``ax``, Matplotlib's axes to
            draw on, as many as the figure has panels (one alone for one panel). By default a new
            figure is made.

        Raises
        ------
        UsageError
            There is no such figure, or nothing to draw in it.
        """
        return cast("Figure", view_of("figure_of", self, what, **how))

    def to_frame(self, library: str | None = None) -> Any:
        """The result's numbers as a dataframe.

        Parameters
        ----------
        library : {"pandas", "polars"}, optional
            By default the one that is installed, pandas first.

        Raises
        ------
        UsageError
            The result has no table of numbers, or there is no such library.
        """
        return view_of("as_frame", self, library=library)


def view_of(view: str, result: object, *what: Any, **how: Any) -> Any:
    """A view of a result, by the view's name in `axisid.presentation.views`."""
    return getattr(import_module("axisid.presentation.views"), view)(result, *what, **how)


def sentence_of(finding: object) -> str:
    """Return the sentence of a finding, as `axisid.presentation.sentences` words it."""
    return str(import_module("axisid.presentation.sentences").sentence(finding))
