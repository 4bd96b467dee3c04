"""Blocks and sentences as HTML, for notebooks and the report.

In: blocks. Out: HTML without scripts or styles. Knows nothing of results.
"""

from .blocks import (
    STATUS_CLASSES as STATUS_CLASSES,
    blocks_html as blocks_html,
    checks_html as checks_html,
    prose_html as prose_html,
    table_html as table_html,
    unbroken as unbroken,
)
