"""Results as documents of sentences and tables.

In: a result, live or read from a file. Out: a document of blocks. Knows nothing of how statistics
are computed.
"""

from .comparison import comparison_document as comparison_document
from .fits_and_sweeps import (
    fit_validation_document as fit_validation_document,
    law_search_document as law_search_document,
    output_fit_document as output_fit_document,
    saved_fit_document as saved_fit_document,
    sweep_document as sweep_document,
    validation_document as validation_document,
)
from .identification import (
    judged_table as judged_table,
    missing_notes as missing_notes,
    saved_document as saved_document,
    verdict_block as verdict_block,
)
from .identification_details import (
    checks_table as checks_table,
    details_document as details_document,
    saved_estimate_document as saved_estimate_document,
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
    record_document as record_document,
)
