"""Sentences of the page: numbers and units as they are printed, options that never break."""

import re
from html import escape

from axisid.presentation.formulas import readable_text

_WHOLE = re.compile(r"->|--[a-z](?:-?[a-z0-9])*(?: [a-z]+-[a-z]+| [A-Z]+(?:=[\w+-]+)?)?")


def prose_html(sentence: str) -> str:
    """One sentence or more, with a full stop at the end; no letter changes its case.

    Parameters
    ----------
    sentence : str
        As for the terminal.
    """
    text = readable_text(sentence.rstrip())
    return unbroken(text if text.endswith((".", "?", "!")) else f"{text}.")


def unbroken(text: str) -> str:
    """Text as HTML, in which no line ends within an option of the command line or an arrow."""
    parts, at = [], 0
    for found in _WHOLE.finditer(text):
        parts += [
            escape(text[at : found.start()]),
            f'<span class="option">{escape(found[0])}</span>',
        ]
        at = found.end()
    return "".join(parts) + escape(text[at:])
