"""Figures of a benchmark: as a table, or as one JSON object where ``--json`` asks for it."""

import argparse
import json
from collections.abc import Iterable, Mapping
from pathlib import Path


def parser_of(doc: str | None) -> argparse.ArgumentParser:
    """Return a parser with ``--json``, described by the first line of a benchmark."""
    parser = argparse.ArgumentParser(description=(doc or "").splitlines()[0])
    parser.add_argument("--json", metavar="FILE", help="write one JSON object; - for stdout")
    return parser


def give(figures: Mapping[str, object], file: str | None, lines: Iterable[str]) -> None:
    """Print the lines of a table, or write the figures to a file, to stdout for ``-``."""
    if not file:
        print("\n".join(lines))
        return
    text = json.dumps(figures, indent=2)
    if file == "-":
        print(text)
    else:
        Path(file).write_text(text + "\n")
