"""Documents: blocks that do not depend on the output format, and their rendering.

In: blocks, expressions, numbers, the models of an axis. Out: plain text, HTML without scripts or
styles, LaTeX, MathML. Knows nothing of results and estimators.
"""

from .axis_page import (
    axis_document as axis_document,
    axis_page as axis_page,
    motion_sections as motion_sections,
)
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
    decimals as decimals,
    figure_text as figure_text,
    paragraph as paragraph,
    readable_text as readable_text,
    readable_unit as readable_unit,
    text_columns as text_columns,
    text_table as text_table,
    without_empty_last_column as without_empty_last_column,
)
from .html import (
    STATUS_CLASSES as STATUS_CLASSES,
    blocks_html as blocks_html,
    checks_html as checks_html,
    prose_html as prose_html,
    table_html as table_html,
    unbroken as unbroken,
)
from .latex import (
    formula_mathml as formula_mathml,
    symbol_latex as symbol_latex,
    unit_latex as unit_latex,
)
from .plain import (
    COLUMN_GAP as COLUMN_GAP,
    PAGE_WIDTH as PAGE_WIDTH,
    Grid as Grid,
    block_lines as block_lines,
    grid as grid,
    joined as joined,
    plain_text as plain_text,
)
