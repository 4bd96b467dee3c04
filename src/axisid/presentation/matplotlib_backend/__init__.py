"""Figures drawn by Matplotlib, and their files. Imported only where one is drawn.

In: `Plot`. Out: figures, files. Knows nothing of what a figure shows.
"""

from .matplotlib import (
    NAMES as NAMES,
    draw as draw,
    draw_on as draw_on,
    force_figure as force_figure,
    rendered as rendered,
    sweep_figure as sweep_figure,
    write_figures as write_figures,
)
