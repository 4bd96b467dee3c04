"""An identification, live or of a file: its estimates by method, and its checks."""

from collections.abc import Iterator, Mapping
from typing import Protocol, TypeVar

from axisid.estimation.diagnostics import Diagnosed
from axisid.support.errors import UsageError
from axisid.support.user_values import quoted

Estimated_co = TypeVar("Estimated_co", covariant=True)


class _HasEstimates(Protocol[Estimated_co]):
    @property
    def estimates(self) -> Mapping[str, Estimated_co]: ...


class ByMethod(Diagnosed):
    """Estimates by method: ``result["idm-iv"]``; it iterates over the methods."""

    __slots__ = ()

    def __getitem__(self: _HasEstimates[Estimated_co], method: str) -> Estimated_co:
        name = str(method).lower()
        if name not in self.estimates:
            raise UsageError(
                f"the result has no {quoted(method)}; choose from {', '.join(self.estimates)}.",
                code="no-such-estimate",
            )
        return self.estimates[name]

    def __iter__(self: _HasEstimates[object]) -> Iterator[str]:
        return iter(self.estimates)

    def __contains__(self: _HasEstimates[object], method: object) -> bool:
        return isinstance(method, str) and method.lower() in self.estimates

    def __len__(self: _HasEstimates[object]) -> int:
        return len(self.estimates)
