"""The paper's study made again.

In: nothing, or its record. Out: its tables beside ours, figures, files. Knows nothing of other
records, and of the command line.
"""

from .study import (
    DISTRIBUTION_FILES as DISTRIBUTION_FILES,
    STUDY_FILES as STUDY_FILES,
    distributions_document as distributions_document,
    run_distributions as run_distributions,
    run_study as run_study,
    study_document as study_document,
    study_table as study_table,
    write_distributions as write_distributions,
    write_study as write_study,
)
