"""What is shown, in blocks that know nothing of where: plain text, a terminal, a page.

In: blocks. Out: plain text. Knows nothing of results.
"""

from .document import (
    Block as Block,
    Cell as Cell,
    CheckGroup as CheckGroup,
    Checks as Checks,
    Document as Document,
    Heading as Heading,
    Interval as Interval,
    Intervals as Intervals,
    Listing as Listing,
    Notes as Notes,
    Paragraph as Paragraph,
    QuantityCell as QuantityCell,
    Sentence as Sentence,
    Status as Status,
    TableBlock as TableBlock,
    TableColumn as TableColumn,
    paragraph as paragraph,
    text_columns as text_columns,
    text_table as text_table,
)
from .plain import (
    PAGE_WIDTH as PAGE_WIDTH,
    Grid as Grid,
    Line as Line,
    block_lines as block_lines,
    block_text as block_text,
    grid as grid,
    joined as joined,
    plain_text as plain_text,
)
