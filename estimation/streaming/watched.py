"""The blocks of a log, of which a pass takes note what its simulated loop starts from."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.loops import start_of_log
from axisid.estimation.records import Extent, LogBlocks, Record, law_ratio
from axisid.estimation.regression import loop_reference
from axisid.estimation.tables import Provenance
from axisid.support.arrays import Array
from axisid.support.errors import DataError, UsageError
from axisid.support.remedy import Remedy, Setting

from .carried_loop import LoopExtent
from .log_rows import Blocks
from .loops_beside import commanded

_HEAD = 4096  # samples of a log that tell where its loop starts
_WHOLE = Remedy.of("read the log whole: ", Setting("stream", given=False), ".")


class Watched:
    """The blocks of a log, of which a pass takes note what its loop needs.

    Parameters
    ----------
    blocks : iterable of mappings of str to (N,) array
    injected_at : str or None
        What a test signal was added to.
    """

    def __init__(self, blocks: Blocks, injected_at: str | None) -> None:
        self._blocks, self.injected_at = blocks, injected_at
        self.head: dict[str, Array] = {}
        self.least, self.most, self.added, self.squares = np.inf, -np.inf, 0.0, 0.0

    def __iter__(self) -> Iterator[Mapping[str, Array]]:
        self.head, self.squares, self.added = {}, 0.0, 0.0
        self.least, self.most = np.inf, -np.inf
        for block in self._blocks:
            self._add(block)
            yield block

    def _add(self, block: Mapping[str, Array]) -> None:
        if "reference" in block:
            reference = commanded(block, self.injected_at)
            self.least = min(self.least, float(np.min(reference, initial=np.inf)))
            self.most = max(self.most, float(np.max(reference, initial=-np.inf)))
        if "control" in block:
            self.squares += float(np.sum(np.square(block["control"])))
        if "injected" in block:
            self.added = max(self.added, float(np.abs(block["injected"]).max(initial=0.0)))
        if len(next(iter(self.head.values()), ())) < _HEAD:
            self.head = {
                role: np.concatenate([self.head.get(role, v[:0]), v]) for role, v in block.items()
            }

    def extent(self, axis: GeneratedAxis, found: Extent, origin: Provenance) -> LoopExtent:
        """What a loop needs to know of the whole log, after a pass.

        Raises
        ------
        ModelError, LoopDataError
            As `loop_reference` does.
        UsageError, DataError
            The loop is not one that is simulated in blocks.
        """
        if "position" not in self.head:
            raise DataError(
                f"{origin.source} has no position, of which the loop of a log that is read in "
                "blocks is simulated; ",
                _WHOLE,
                code="loop-position-in-blocks",
            )
        if axis.axis.drive.path.is_limited:
            raise UsageError(
                f"the drive of axis {axis.axis.name!r} limits the rate of its commands, which rows "
                "of a loop in blocks do not follow; ",
                _WHOLE,
                code="loop-rate-in-blocks",
            )
        rows = len(self.head["position"])
        head = self._record(axis, rows, found.period, origin)
        loop_reference(axis, head)
        law = axis.axis.control
        if law_ratio(law, found.period, found.clock) != 1:
            raise DataError(
                f"{origin.source} is sampled every {found.period:.6g} s, the control law of axis "
                f"{axis.axis.name!r} runs at another period: in blocks a loop is simulated at the "
                "samples of its law; ",
                _WHOLE,
                code="loop-clocks-in-blocks",
            )
        power = self.squares / found.samples
        signals = tuple(float(self.head[signal.name][0]) for signal in axis.axis.signals)
        return LoopExtent(
            start=start_of_log(axis, head, rows, power),
            period=found.period,
            first=float(commanded(self.head, self.injected_at)[0]),
            signals=signals,
            span=self.most - self.least,
            most_added=self.added if self.injected_at == "control" else None,
        )

    def _record(self, axis: GeneratedAxis, rows: int, period: float, origin: Provenance) -> Record:
        """The head as a record, and a row more.

        A log may begin with a rest, and columns of a record are not constant: they vary in that
        row, which nothing is asked of.
        """
        signals = {signal.name for signal in axis.axis.signals}
        columns = {
            role: np.append(values, values[-1] + float(np.ptp(values) == 0))
            for role, values in self.head.items()
            if role != "time"
        }
        roles: dict[str, Any] = {n: v for n, v in columns.items() if n not in signals}
        return Record(
            time=period * np.arange(rows + 1, dtype=np.float64),
            injected_at=self.injected_at,
            signals={name: values for name, values in columns.items() if name in signals},
            provenance=origin,
            sample_period=period,
            **roles,
        )


def injection_point(axis: GeneratedAxis, blocks: Blocks) -> str | None:
    """What the test signal of a log was added to; None for a log without one."""
    given = blocks.injected_at if isinstance(blocks, LogBlocks) else None
    if "injected" not in next(iter(blocks)):
        return None
    return given or axis.axis.injected_at or None
