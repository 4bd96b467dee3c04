"""Fits of a simulated output in words and tables.

In: a result. Out: a document of blocks. Knows nothing of how it was searched for.
"""

from .output_fit import output_fit_document as output_fit_document
