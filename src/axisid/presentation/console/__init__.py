"""A terminal: colours, width, progress.

In: documents of blocks. Out: what a terminal shows. Knows nothing of results.
"""

from .progress import ProgressLine as ProgressLine
from .terminal import print_document as print_document
