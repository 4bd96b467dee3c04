"""The paper's study made again.

In: nothing, or its record. Out: its tables beside ours, figures, files. Knows nothing of other
records, and of the command line.
"""

from .distributions import (
    DISTRIBUTION_FILES as DISTRIBUTION_FILES,
    distributions_document as distributions_document,
    run_distributions as run_distributions,
    write_distributions as write_distributions,
)
from .encoder import run_encoder_study as run_encoder_study
from .encoder_document import (
    ENCODER_FILES as ENCODER_FILES,
    encoder_document as encoder_document,
    write_encoder_study as write_encoder_study,
)
from .study import (
    STUDY_FILES as STUDY_FILES,
    run_study as run_study,
    study_document as study_document,
    table_text as table_text,
    write_study as write_study,
)
