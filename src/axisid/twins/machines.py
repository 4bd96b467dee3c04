"""Machines of one kind: what their true values are, on each day, and a log of each."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from datetime import date, timedelta

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.monte_carlo import drawn_twin, noise_of, twin_of
from axisid.estimation.records import Record
from axisid.estimation.simulation import twin_plan
from axisid.estimation.twins import Chain
from axisid.support.errors import UsageError
from axisid.support.real_numbers import is_real, is_whole
from axisid.support.user_values import quoted

_FIRST_DAY = date(2026, 1, 1)
_MOST = 1_000_000  # machines: the noise of each day is that of runs from here on
_MOST_DAYS = 10_000
_VALUES = 100  # of the random numbers of a machine, beside those of its noise


@dataclass(frozen=True, slots=True, kw_only=True)
class TwinMachines:
    """Twins whose true values differ, each with a log a day.

    Attributes
    ----------
    axis : GeneratedAxis
        With an experiment and its true values.
    count, days : int
    scatter : mapping of str to float
        By parameter, the relative deviation between machines, at most 1.
    drift : mapping of str to float
        By parameter, the share of its value that it changes by a day, from -1 to 1.
    noise : Chain or None
        The experiment's where there is none.
    seed : int
        Of all: machines and days that are added change none that were there.
    sample_period : float or None
        Of the logs, s; the law's by default.

    Raises
    ------
    UsageError, ModelError
        One of these cannot be.
    """

    axis: GeneratedAxis
    count: int = 1
    days: int = 1
    scatter: Mapping[str, float] = field(default_factory=dict)
    drift: Mapping[str, float] = field(default_factory=dict)
    noise: Chain | None = None
    seed: int = 1
    sample_period: float | None = None

    def __post_init__(self) -> None:
        _check_whole("number of machines", self.count, 1, _MOST)
        _check_whole("number of days", self.days, 1, _MOST_DAYS)
        _check_whole("seed", self.seed, 0, None)
        true = self.true_values
        for what, shares in (("scatter", self.scatter), ("drift", self.drift)):
            for name, share in shares.items():
                _check_share(what, name, share, true)
        if least := [name for name in self.scatter if self.scatter[name] < 0]:
            raise UsageError(
                f"the scatter of {least[0]} is {self.scatter[least[0]]:g}; give 0 or more.",
                code="twin-scatter",
            )
        noise_of(self.noise, self.axis)

    @property
    def true_values(self) -> dict[str, float]:
        """What those of the machines scatter about, by declared parameter, SI."""
        plan = twin_plan(self.axis, sample_period=self.sample_period)
        return {p.name: plan.true_values[p.name] for p in self.axis.declared.parameters}

    def truth(self, machine: int, day: int) -> dict[str, float]:
        """True values of a machine on a day, both from 0.

        A value that scatters is log-normal, so that it keeps its sign.
        """
        child = np.random.SeedSequence(self.seed, spawn_key=(machine, _VALUES))
        true = self.true_values
        drawn = dict(
            zip(true, np.random.default_rng(child).standard_normal(len(true)), strict=True)
        )
        return {
            name: value
            * math.exp(self.scatter.get(name, 0.0) * drawn[name])
            * (1 + self.drift.get(name, 0.0) * day)
            for name, value in true.items()
        }

    def record(self, machine: int, day: int) -> Record:
        """The log of a machine on a day.

        Raises
        ------
        AxisidError
            Its loop runs away.
        """
        axis = self.axis
        if self.scatter or self.drift:
            axis = twin_of(axis, self.truth(machine, day), None)
        plan = twin_plan(axis, sample_period=self.sample_period)
        made = drawn_twin(plan, noise_of(self.noise, axis), self.seed, machine + _MOST * day)
        named = filter(None, (self.serial(machine), self.date(day)))
        source = f"twin {' '.join(named)} of {axis.axis.name}, seed {self.seed}"
        return replace(made, provenance=replace(made.provenance, source=source))

    def date(self, day: int) -> str:
        """Of a log, where there are several of a machine."""
        return (_FIRST_DAY + timedelta(days=day)).isoformat() if self.days > 1 else ""

    def serial(self, machine: int) -> str:
        """Its number, from 1."""
        return f"{machine + 1:04}"

    def each(self) -> Iterator[tuple[int, int]]:
        """Every machine with every day."""
        return ((machine, day) for machine in range(self.count) for day in range(self.days))


def _check_whole(what: str, value: object, least: int, most: int | None) -> None:
    if not (is_whole(value) and least <= int(value) and (most is None or value <= most)):
        span = f"of {least} or more" if most is None else f"from {least} to {most}"
        raise UsageError(
            f"the {what} of twins is {quoted(value)}; give a whole number {span}.",
            code="twin-count",
        )


def _check_share(what: str, name: str, share: object, true: Mapping[str, float]) -> None:
    if name not in true:
        raise UsageError(
            f"the {what} is of {quoted(name)}, which the axis does not declare; its parameters are "
            f"{', '.join(true)}.",
            code="twin-share-name",
        )
    if not (is_real(share) and abs(share) <= 1):
        raise UsageError(
            f"the {what} of {name} is {quoted(share)}; give a share of its value, at most 1, such "
            "as 0.02 for 2 %.",
            code="twin-share",
        )
    if share and not true[name]:
        raise UsageError(
            f"the {what} of {name} is {share:g} of its true value, which is 0; give it another one "
            "as its truth, or leave that out.",
            code="twin-share-of-zero",
        )
