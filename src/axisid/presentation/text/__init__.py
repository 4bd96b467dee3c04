"""Results as plain text and in notebooks.

In: a result. Out: text. Computes no statistics.
"""

from .comparison import comparison_text as comparison_text
from .identification import drawn_text as drawn_text
from .identification import identification_text as identification_text
from .identification import left_out_notes as left_out_notes
from .identification import shared_remarks as shared_remarks
from .notebook import estimate_html as estimate_html
from .notebook import result_html as result_html
from .physical import physical_notes as physical_notes
from .record import record_lines as record_lines
from .record import record_text as record_text
from .stream import stream_text as stream_text
from .sweep import sweep_text as sweep_text
from .tables import text_table as text_table
from .tables import wrapped as wrapped
from .validation import validation_text as validation_text
