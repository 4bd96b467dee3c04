"""OutputResiduals by a formula, in place of simulated loops."""

from collections.abc import Callable

import numpy as np

from axisid.estimation.output_residuals.output_residuals import BatchResiduals
from axisid.support.arrays import Array


class Formula:
    """Errors (n, B) of parameters (B, P); lanes whose last parameter is beyond a limit fail."""

    units = ("m",)

    def __init__(self, errors: Callable[[Array], Array], rows: int, limit: float = np.inf) -> None:
        self.seen: list[Array] = []
        self.measured = self.counted = np.ones(rows)
        self.spans = ((slice(0, rows),),)
        self._errors, self._limit = errors, limit

    def settle(self, physical: Array) -> None:
        """There is nothing to settle."""

    def __call__(self, physical: Array) -> BatchResiduals:
        self.seen.append(physical)
        failed = {i: "it runs away" for i, p in enumerate(physical) if p[-1] > self._limit}
        errors = self._errors(physical)
        errors[:, [*failed]] = np.nan
        return BatchResiduals(errors=errors, failures=failed)
