"""The one way from a result to what it looks like: results hold data, presentation shows them."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Shown:
    """A result that can be looked at: as text, as plain data, in a figure, in a notebook.

    What it looks like is the affair of `axisid.presentation`, which is imported when it is asked.
    """

    __slots__ = ()

    def summary(self) -> str:
        """The result as text."""
        return str(shown_by("as_text", self))

    def __str__(self) -> str:
        return self.summary()

    def to_dict(self) -> dict[str, Any]:
        """What ``--json`` writes: plain numbers, texts and lists."""
        return dict(shown_by("as_document", self))

    def plot(self, what: str = "", **how: Any) -> "Figure":
        """Draw one of the result's figures.

        Parameters
        ----------
        what : str
            Which one, if there are several.
        **how
            Of which method, if there are several: ``method="idm-ls"``.

        Raises
        ------
        UsageError
            There is no such figure, or nothing to draw in it.
        """
        drawn: Figure = shown_by("figure_of", self, what, **how)
        return drawn

    def _repr_html_(self) -> str:
        """For notebooks."""
        return str(shown_by("as_html", self))


def shown_by(view: str, result: Shown, *what: str, **how: Any) -> Any:
    """A view of a result, by the view's name in `axisid.presentation.views`."""
    return getattr(import_module("axisid.presentation.views"), view)(result, *what, **how)
