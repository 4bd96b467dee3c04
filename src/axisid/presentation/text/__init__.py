"""Results in words and tables.

In: a result. Out: a document of blocks. Knows nothing of how statistics are computed.
"""

from .comparison import comparison_document as comparison_document
from .details import checks_table as checks_table
from .estimate import (
    iterations as iterations,
    moves_notes as moves_notes,
    physical_notes as physical_notes,
    quantity as quantity,
    saved_estimate_document as saved_estimate_document,
)
from .identification import (
    diagnosis_blocks as diagnosis_blocks,
    identification_document as identification_document,
    missing_notes as missing_notes,
    preferred_physical as preferred_physical,
    saved_document as saved_document,
    shared_remarks as shared_remarks,
    verdict_block as verdict_block,
)
from .output_fit import (
    output_fit_document as output_fit_document,
    saved_fit_document as saved_fit_document,
)
from .record import (
    listed_facts as listed_facts,
    record_document as record_document,
    record_facts as record_facts,
    records_table as records_table,
)
from .studies import (
    fit_validation_document as fit_validation_document,
    law_search_document as law_search_document,
    sweep_document as sweep_document,
    validation_document as validation_document,
    validation_table as validation_table,
)
