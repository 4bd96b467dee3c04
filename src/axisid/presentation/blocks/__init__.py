"""What is shown, in blocks that know nothing of where: plain text, a terminal, a page.

In: blocks. Out: plain text. Knows nothing of results.
"""

from .document import Block as Block
from .document import Cell as Cell
from .document import CheckGroup as CheckGroup
from .document import Checks as Checks
from .document import Column as Column
from .document import Document as Document
from .document import Heading as Heading
from .document import Interval as Interval
from .document import Intervals as Intervals
from .document import Listing as Listing
from .document import NotedText as NotedText
from .document import Notes as Notes
from .document import Paragraph as Paragraph
from .document import Quantity as Quantity
from .document import Sentence as Sentence
from .document import Status as Status
from .document import Table as Table
from .document import paragraph as paragraph
from .document import text_columns as text_columns
from .grid import Grid as Grid
from .grid import grid as grid
from .grid import joined as joined
from .plain import FACT_WIDTH as FACT_WIDTH
from .plain import PAGE_WIDTH as PAGE_WIDTH
from .plain import STATUS_HEADS as STATUS_HEADS
from .plain import block_text as block_text
from .plain import plain_text as plain_text
