"""The blocks of code in a recipe of CONTRIBUTING, so that a test can follow it."""

import re
from pathlib import Path


def recipe_blocks(title: str) -> list[str]:
    """The Python blocks below a heading."""
    text = (Path(__file__).resolve().parents[1] / "CONTRIBUTING.md").read_text()
    below = text.partition(f"\n## {title}\n")[2].partition("\n## ")[0]
    return re.findall(r"```python\n(.*?)```", below, re.DOTALL)
