"""A terminal: colours, width, progress.

In: documents of blocks. Out: what a terminal shows. Knows nothing of results.
"""

from .terminal import ProgressLine as ProgressLine, print_document as print_document
