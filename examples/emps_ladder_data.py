"""The public record of the EMPS in cycles, and the models that are held against them."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np
import scipy.io
from emps_ladder_models import axis_with

from axisid import Record, build, read_record
from axisid.codegen import GeneratedAxis
from axisid.estimation.output_residuals import MultipleShootingResiduals
from axisid.estimation.regression import InverseForm

STEP = 1e-3  # s
TURNS = (0.0, 6.224, 12.464, 18.704, 24.841)  # s: where the reference begins its cycles
Windows = list[tuple[float, float]]
Array = np.ndarray


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """A rung.

    Attributes
    ----------
    terms : tuple of str
        Beside the published ones.
    lag : float
        Of the drive, s.
    """

    terms: tuple[str, ...] = ()
    lag: float = 0.0

    @property
    def axis(self) -> GeneratedAxis:
        """Built once."""
        return _built(self.terms, self.lag)

    @property
    def words(self) -> str:
        """For tables."""
        return " + ".join(
            ["published", *self.terms, *([f"lag {1e3 * self.lag:g} ms"] * bool(self.lag))]
        )


@cache
def _built(terms: tuple[str, ...], lag: float) -> GeneratedAxis:
    return build(axis_with(terms, lag=lag))


@dataclass(frozen=True, slots=True, kw_only=True)
class Split:
    """What is fitted, and what is held out.

    Attributes
    ----------
    fitted, held : list of (float, float)
        First and last time of each part, s.
    """

    fitted: Windows
    held: Windows = field(default_factory=list)


def cycle(k: int) -> tuple[float, float]:
    """First and last time of a cycle, from 0."""
    return TURNS[k], TURNS[k + 1] - STEP


def leave_one_out() -> list[Split]:
    """Each cycle held out once."""
    every = range(4)
    return [Split(fitted=[cycle(j) for j in every if j != k], held=[cycle(k)]) for k in every]


def halves() -> list[Split]:
    """Each half of the record held out once."""
    first, last = (TURNS[0], TURNS[2] - STEP), (TURNS[2], TURNS[4])
    return [Split(fitted=[first], held=[last]), Split(fitted=[last], held=[first])]


def nothing_held() -> list[Split]:
    """The whole record, as one window."""
    return [Split(fitted=[(TURNS[0], TURNS[4])])]


@dataclass(frozen=True, slots=True)
class Data:
    """The record's columns."""

    columns: Mapping[str, Array]

    def record(self, model: Model, windows: Windows | tuple[()] = ()) -> Record:
        """Parts of it, for a model."""
        return self.read(model.axis, windows)

    def read(self, axis: GeneratedAxis, windows: Windows | tuple[()] = ()) -> Record:
        """Parts of it, for an axis."""
        return read_record(dict(self.columns), axis, windows=windows)

    def pieces(self, held: Windows, horizon: float) -> Iterator[Windows]:
        """What is scored of held-out parts: all, of longer windows the first and the last."""
        for begin, end in held:
            if horizon < (end - begin) / 2 or horizon > end - begin - 1.0:
                yield [(begin, end)]
            else:
                yield [(begin, begin + horizon)]
                yield [(end - horizon, end)]


def read_data(file: Path) -> Data:
    """The record, with the time since its middle as a signal."""
    loaded = scipy.io.loadmat(file)
    columns = {name: np.ravel(loaded[name]) for name in ("t", "qm", "vir")}
    columns["elapsed"] = columns["t"] - columns["t"].mean()
    return Data(columns)


def left(model: Model, record: Record, values: Mapping[str, float], horizon: float) -> Array:
    """What parameters leave in open loop along a record, m; `validate_fit` without a fit."""
    axis = model.axis
    windows = MultipleShootingResiduals(InverseForm(axis), [axis], [record], horizon)
    theta = np.array([values[p.name] for p in axis.declared.parameters])
    windows.settle(theta)
    return np.asarray(windows(theta[None, :]).errors[:, 0])
