"""From a record to estimates. Dimensions: N samples, n rows, p parameters, m of the direct model.

`Record` + `Prefilter` -> `FilteredRecord` -> `Problem` -> `Fit` -> `Estimate` -> `Identification`.
SymPy is not used: an axis is given by its generated functions.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
