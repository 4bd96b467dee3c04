"""The paper's study made again.

In: nothing, or its record. Out: its tables beside ours, figures, files. Knows nothing of other
records, and of the command line.
"""

from .distributions import DISTRIBUTION_FILES as DISTRIBUTION_FILES
from .distributions import distributions_document as distributions_document
from .distributions import run_distributions as run_distributions
from .distributions import write_distributions as write_distributions
from .encoder import run_encoder_study as run_encoder_study
from .encoder_document import ENCODER_FILES as ENCODER_FILES
from .encoder_document import encoder_document as encoder_document
from .encoder_document import write_encoder_study as write_encoder_study
from .study import STUDY_FILES as STUDY_FILES
from .study import run_study as run_study
from .study import study_document as study_document
from .study import table_text as table_text
from .study import write_study as write_study
