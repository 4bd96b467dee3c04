"""Sentences of the page: numbers and units as they are printed, options that never break."""

import re
from html import escape

from axisid.estimation.typeset import readable_text

_OPTION = re.compile(r"--[a-z](?:-?[a-z0-9])*(?: [a-z]+-[a-z]+| [A-Z]+(?:=[\w+-]+)?)?")


def prose_html(sentence: str) -> str:
    """One sentence or more, with a full stop at the end; no letter changes its case.

    Parameters
    ----------
    sentence : str
        As for the terminal.
    """
    text = readable_text(sentence.rstrip())
    return unbroken_options(text if text.endswith((".", "?", "!")) else f"{text}.")


def unbroken_options(text: str) -> str:
    """Text as HTML, its options of the command line each on one line."""
    return _OPTION.sub(lambda m: f'<span class="option">{m[0]}</span>', escape(text))
