"""A terminal: colours, width, progress.

In: text. Out: what a terminal shows. Knows nothing of results.
"""

from .progress import ProgressLine as ProgressLine
from .terminal import show_text as show_text
