"""Files that tests write."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np


def text_file(file: Path, text: str) -> Path:
    file.write_text(text, encoding="utf-8")
    return file


def csv_file(file: Path, columns: Mapping[str, Any], digits: str = "%.18e") -> Path:
    """Columns by name, separated by commas."""
    table, names = np.column_stack(list(columns.values())), ",".join(columns)
    np.savetxt(file, table, fmt=digits, delimiter=",", header=names, comments="")
    return file
