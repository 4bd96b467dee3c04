"""Loops that are simulated beside a log, as columns of its blocks."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.simulation import SIMULATED, Simulation
from axisid.support.arrays import Array

from .carried_loop import CarriedLoop

TURNING, INSTRUMENTS = "turning", "instruments"


def commanded(block: Mapping[str, Array], injected_at: str | None) -> Array:
    """The reference that the law of a block follows, (N,), what is added to it among it."""
    reference = block["reference"]
    return reference + block["injected"] if injected_at == "reference" else reference


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopsBeside:
    """Which loops are simulated along a log.

    Attributes
    ----------
    instruments : CarriedLoop or None
        Whose rows stand beside the measured ones.
    turning : CarriedLoop or None
        Whose reversals and rests are left out; None for those that were measured.
    injected_at : str or None
        What the log's test signal was added to; None where there is none.
    """

    instruments: CarriedLoop | None = None
    turning: CarriedLoop | None = None
    injected_at: str | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Of the columns."""
        every = (f"{name}.{signal}" for name, _, wanted in self._all for signal in wanted)
        return tuple(every)

    @property
    def _all(self) -> list[tuple[str, CarriedLoop, tuple[str, ...]]]:
        """Name, loop and the signals that are wanted of it."""
        named = (
            (INSTRUMENTS, self.instruments, SIMULATED),
            (TURNING, self.turning, SIMULATED[:1]),
        )
        return [(name, loop, wanted) for name, loop, wanted in named if loop is not None]

    def along(
        self, axis: GeneratedAxis, blocks: Iterator[Mapping[str, Array]]
    ) -> Iterator[Mapping[str, Array]]:
        """The blocks with the loops' columns; each then ends a sample sooner, but for the last."""
        if not self._all:
            yield from blocks
            return
        for _, loop, _ in self._all:
            loop.begin()
        held: Mapping[str, Array] = {}
        for block in blocks:
            if not len(next(iter(block.values()))):
                continue
            joined = {role: np.concatenate([held.get(role, v[:0]), v]) for role, v in block.items()}
            if len(next(iter(joined.values()))) > 1:
                yield self._simulated(axis, joined, more=True)
            held = {role: values[-1:] for role, values in joined.items()}
        if held:
            yield self._simulated(axis, held, more=False)

    def _simulated(
        self, axis: GeneratedAxis, block: Mapping[str, Array], *, more: bool
    ) -> Mapping[str, Array]:
        reference = commanded(block, self.injected_at)
        added = block["injected"] if self.injected_at == "control" else None
        signals = tuple(block[signal.name] for signal in axis.axis.signals)
        columns = {role: values[: len(values) - more] for role, values in block.items()}
        for name, loop, wanted in self._all:
            found = loop.along(reference, added, signals, more=more)
            columns |= {f"{name}.{signal}": getattr(found, signal) for signal in wanted}
        return columns


def simulation_of(
    columns: Mapping[str, Array], recorded: tuple[Array, ...], period: float
) -> Simulation:
    """The simulated loop of the instruments, from its columns."""
    signals = {signal: columns[f"{INSTRUMENTS}.{signal}"] for signal in SIMULATED}
    return Simulation(
        time=period * np.arange(len(signals["position"]), dtype=np.float64),
        measured_position=signals["position"],
        recorded=recorded,
        **signals,
    )
