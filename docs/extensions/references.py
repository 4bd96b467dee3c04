"""The bibliography as citations, to which ``[Brunot2015]_`` in a docstring leads.

``{references} references.bib`` inside ``{eval-rst}`` lists every entry.
"""

from pathlib import Path

from docutils import nodes
from docutils.statemachine import StringList
from pybtex.database import parse_file
from pybtex.plugin import find_plugin
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


class References(SphinxDirective):
    """Every entry of a BibTeX file, in the order of its key."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Make a citation of each entry."""
        file = Path(self.env.srcdir) / self.arguments[0]
        self.env.note_dependency(str(file))
        entries = parse_file(file).entries
        style, backend = find_plugin("pybtex.style.formatting", "plain")(), _backend()
        lines = []
        for key in sorted(entries):
            (formatted,) = style.format_entries([entries[key]])
            lines += [f".. [{key}] {formatted.text.render(backend)}", ""]
        parent = nodes.Element()
        self.state.nested_parse(StringList(lines, str(file)), self.content_offset, parent)
        return parent.children


def _backend() -> object:
    return find_plugin("pybtex.backends", "plaintext")()


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("references", References)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
