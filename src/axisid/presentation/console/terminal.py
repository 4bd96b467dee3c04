"""Documents on a terminal: in colours and within its width; on a pipe they are plain text."""

import os
import shutil
import sys
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from axisid.presentation.blocks import Document


def print_document(document: "Document") -> None:
    """Print a document: as it is on a pipe, dressed for a terminal."""
    # Help and what computes need neither of the two ways to draw.
    if not is_terminal(sys.stdout):
        from axisid.presentation.blocks import plain_text

        click.echo(plain_text(document), nl=False)
        return
    from .dressed import print_dressed

    coloured = not os.environ.get("NO_COLOR")
    print_dressed(document, sys.stdout, shutil.get_terminal_size().columns, coloured=coloured)


def is_terminal(stream: Any) -> bool:
    """Whether a stream is a terminal that knows colours and can erase a line."""
    dumb = os.environ.get("TERM", "dumb") == "dumb"
    return stream is not None and not dumb and bool(stream.isatty())
