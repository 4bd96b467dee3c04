"""Sentences of what estimation finds: the one place that words it.

In: frozen findings with numbers, names and units. Out: plain English. Knows nothing of tables,
pages and files.
"""

from .covariances import (
    covariance_in_short as covariance_in_short,
    covariance_text as covariance_text,
    shared_covariance_text as shared_covariance_text,
)
