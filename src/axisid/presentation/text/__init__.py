"""Results in words and tables.

In: a result. Out: a document of blocks. Knows nothing of how statistics are computed.
"""

from .comparison import comparison_document as comparison_document
from .estimate import (
    checks_table as checks_table,
    details_document as details_document,
    iterations as iterations,
    moves_notes as moves_notes,
    physical_notes as physical_notes,
    saved_estimate_document as saved_estimate_document,
)
from .identification import (
    covariance_name as covariance_name,
    diagnosis_blocks as diagnosis_blocks,
    identification_document as identification_document,
    missing_notes as missing_notes,
    preferred_physical as preferred_physical,
    rows_of as rows_of,
    saved_document as saved_document,
    shared_remarks as shared_remarks,
    verdict_block as verdict_block,
)
from .monte_carlo import (
    estimand_tables as estimand_tables,
    findings as findings,
    heading_facts as heading_facts,
    legend as legend,
    study_checks as study_checks,
    study_document as study_document,
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
    output_fit_document as output_fit_document,
    saved_fit_document as saved_fit_document,
    sweep_document as sweep_document,
    validation_document as validation_document,
    validation_table as validation_table,
)
