"""Sentences of the findings of checks: the only place where they are worded.

In: frozen findings with numbers, names and units. Out: plain English. Knows nothing of tables,
pages and files.
"""

# Importing a module registers its sentences.
from . import (
    agreement_of_estimates as agreement_of_estimates,
    alignment as alignment,
    control_law as control_law,
    fits as fits,
    general as general,
    measured_columns as measured_columns,
    missing_terms as missing_terms,
    model_error as model_error,
    precision as precision,
    several_records as several_records,
    timing as timing,
    validation as validation,
)
from .conclusion import conclusion_text as conclusion_text
from .covariances import (
    covariance_in_short as covariance_in_short,
    covariance_text as covariance_text,
    iid_text as iid_text,
    shared_covariance_text as shared_covariance_text,
)
from .dispatch import sentence as sentence
from .fits import (
    unseen_text as unseen_text,
)
