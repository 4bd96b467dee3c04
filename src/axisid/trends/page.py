"""A trend as a page: what there is to say, and a figure of each series. It needs no network."""

import base64
import io
from collections.abc import Sequence
from html import escape
from string import Template

from axisid.presentation.blocks import Document
from axisid.presentation.html import blocks_html
from axisid.support.version import __version__

from .figure import trend_plot
from .series import Series, notable_first

_MOST_DRAWN = 50  # series, the notable first
_PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="axisid $version">
<title>$title</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; color: #1f2328; background: #fff;
  max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; margin: 0.5rem 0; font-variant-numeric: tabular-nums; }
caption { text-align: left; font-weight: 600; padding: 0.5rem 0; }
th, td { padding: 0.2rem 0.8rem 0.2rem 0; border-bottom: 1px solid #e3e5e8; text-align: right; }
th:first-child, td:first-child { text-align: left; }
dl { display: grid; grid-template-columns: max-content auto; gap: 0 1rem; }
dd { margin: 0; }
figure { margin: 1.5rem 0; }
img { max-width: 100%; }
</style>
</head>
<body>
<main>
$text
$figures
</main>
</body>
</html>
""")


def trend_page(series: Sequence[Series], by: str, document: Document) -> str:
    """One page with a figure of each series, those with a change first."""
    ordered = notable_first(series)[:_MOST_DRAWN]
    figures = "\n".join(_figure(each, by) for each in ordered)
    title = escape(f"Trend of {', '.join(dict.fromkeys(each.axis for each in series))}")
    return _PAGE.substitute(
        version=__version__, title=title, text=blocks_html(document), figures=figures
    )


def _figure(series: Series, by: str) -> str:
    from axisid.presentation.drawing import draw

    plot = trend_plot(series, by)
    image = io.BytesIO()
    draw(plot, plot.title).savefig(image, format="svg")
    data = base64.b64encode(image.getvalue()).decode()
    told = escape(f"{plot.title}. {plot.caption}")
    return (
        f'<figure><img alt="{told}" src="data:image/svg+xml;base64,{data}">'
        f"<figcaption>{escape(plot.caption)}</figcaption></figure>"
    )
