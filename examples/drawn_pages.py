"""Figures of the pages of documentation that a study draws, alike in size and look."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure


def figure_of(rows: int, height: float, **settings: object) -> tuple[Figure, list[Axes]]:
    """Make a figure, so high in inches, with panels one under the other."""
    figure = Figure(figsize=(8.0, height), layout="constrained")
    made = list(np.atleast_1d(figure.subplots(rows, 1, **settings)))  # type: ignore[arg-type]
    for axes in made:
        axes.grid(visible=True, color="#e3e5e8", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    return figure, made


def written(figures: Mapping[str, Figure], folder: Path) -> tuple[Path, ...]:
    """Write figures into a folder, named as they are, and give the files."""
    paths = []
    for name, figure in figures.items():
        path = folder / f"{name}.png"
        settings = {"optimize": True}
        figure.savefig(path, dpi=100, metadata={"Software": "axisid"}, pil_kwargs=settings)
        paths.append(path)
    return tuple(paths)
