"""Formulas as MathML, which browsers draw by themselves: the pages need no network."""

import re

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

# latex2mathml sets a dot as an operator over its letter, which browsers without a mathematical font
# put on top of it; a combining dot is the text's own affair.
_DOTTED = re.compile(r"<mover><mi>(\w)</mi><mo>&#x(002D9|000A8);</mo></mover>")
_COMBINING = {"002D9": "&#x0307;", "000A8": "&#x0308;"}


def _mathml(formula: str, **options: str) -> str:
    def dotted(found: re.Match[str]) -> str:
        return f'<mi style="font-family: serif; font-style: italic">{found[1]}{_COMBINING[found[2]]}</mi>'

    return _DOTTED.sub(dotted, str(convert(formula, **options)))


def _inline(translator: HTML5Translator, node: nodes.math) -> None:
    translator.body.append(_mathml(node.astext()))
    raise nodes.SkipNode


def _block(translator: HTML5Translator, node: nodes.math_block) -> None:
    translator.body.append(f'<div class="math">{_mathml(node.astext(), display="block")}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
