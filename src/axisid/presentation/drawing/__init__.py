"""Figures drawn by Matplotlib, and their files. Imported only where one is drawn.

In: `Plot`. Out: figures, files. Knows nothing of what a figure shows.
"""

from .files import (
    NAMES as NAMES,
    force_figure as force_figure,
    sweep_figure as sweep_figure,
    write_figures as write_figures,
)
from .matplotlib import draw as draw, draw_on as draw_on
