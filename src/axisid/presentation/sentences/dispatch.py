"""The sentence of a finding, by its type."""

from functools import singledispatch

from axisid.estimation.findings import Finding


@singledispatch
def sentence(finding: Finding) -> str:
    """Return the sentence of a finding, without a full stop at its end.

    The first letter is small, except in names. Each module of this package registers one function
    for each type of finding.

    Raises
    ------
    TypeError
        No sentence is registered for findings of this type.
    """
    raise TypeError(f"there is no sentence for a {type(finding).__name__}")
