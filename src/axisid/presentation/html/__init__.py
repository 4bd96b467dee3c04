"""Blocks and sentences as HTML, for notebooks and the report.

In: blocks. Out: HTML without scripts or styles. Knows nothing of results.
"""

from .blocks import STATUS_CLASSES as STATUS_CLASSES
from .blocks import blocks_html as blocks_html
from .blocks import checks_html as checks_html
from .blocks import method_kind as method_kind
from .blocks import sign_html as sign_html
from .blocks import table_html as table_html
from .prose import prose_html as prose_html
from .prose import unbroken as unbroken
