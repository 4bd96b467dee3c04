"""What every page has about it: its head, its sections, its scripts, and nothing from outside."""

import base64
import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from string import Template

from axisid.presentation.html import prose_html
from axisid.presentation.plots import TITLES, Plot
from axisid.support.missing import Missing
from axisid.support.remedy import Wording, as_arguments
from axisid.support.version import __version__

from .embedding import figures_data, script_json

_SCRIPTS = ("ticks.js", "panel.js", "plot.js", "page.js")


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """The sections of a page, as HTML but for the first three.

    Attributes
    ----------
    title : str
        Of the window.
    heading, subheading : str
    verdict, parameters, figures, model, provenance : str
    simulated : str
        What nobody may overlook.
    further : str
        The name of a style and a script beside those of every page; empty for none.
    """

    title: str
    heading: str
    subheading: str
    verdict: str
    parameters: str
    figures: str
    model: str
    provenance: str
    simulated: str = ""
    further: str = ""


def framed(page: Page, plots: Iterable[Plot]) -> str:
    """The page as one file; `plots` are those that its figures show."""
    style = _asset("page.css") + (_asset(f"{page.further}.css") if page.further else "")
    script = "".join(map(_asset, _SCRIPTS))
    script += _asset(f"{page.further}.js") if page.further else ""
    return Template(_asset("page.html")).substitute(
        version=__version__,
        title=escape(page.title),
        heading=escape(page.heading),
        subheading=escape(page.subheading),
        verdict=page.verdict,
        parameters=page.parameters,
        figures=page.figures,
        model=page.model,
        provenance=page.provenance,
        simulated=page.simulated,
        data=script_json(figures_data(plots)),
        style=style,
        script=script,
        style_hash=_hash(style),
        script_hash=_hash(script),
    )


def figure_html(
    name: str,
    plot: Plot | Missing,
    wording: Wording = as_arguments,
    of: str = "",
    *,
    half: bool = False,
) -> str:
    """A figure's place on a page, or why there is none; `of` is what else its element says."""
    wide = (' class="half"' if half else "") + of
    heading = TITLES.get(name, name) if isinstance(plot, Missing) else plot.title
    title = f'<div class="figure-head"><h3>{escape(heading)}</h3></div>'
    if isinstance(plot, Missing):
        why = prose_html(f"None: {plot.note.worded(wording)}")
        return f'<figure{wide}>{title}<p class="none">{why}</p></figure>'
    return (
        f'<figure{wide} id="figure-{plot.name}">{title}'
        f'<div class="plot" id="plot-{plot.name}" aria-label="{escape(plot.title)}"></div>'
        f"<figcaption>{prose_html(plot.caption)}</figcaption></figure>"
    )


def _asset(name: str) -> str:
    return (files(__package__) / "assets" / name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    """What the page's security policy knows its own script or style by."""
    digest = hashlib.sha256(text.encode()).digest()
    return f"sha256-{base64.b64encode(digest).decode()}"
