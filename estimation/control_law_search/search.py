"""The search: each form started by a regression, its gains found by runs, judged on other rows.

The result names those that explain a recorded control.
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis, as_generated
from axisid.estimation.diagnostics.control_law import GainRegression, comparison_filter
from axisid.estimation.law_replay import (
    LawInputs,
    LawReplay,
    measured_velocity,
    unlimited,
)
from axisid.estimation.records import Record
from axisid.estimation.signals import RowTimes, as_logged, hides_command, recorded_signals
from axisid.estimation.thresholds import (
    COMPARISON_CUTOFF,
    LIMIT_TOLERANCE,
    MAX_LAW_RESIDUAL,
    MIN_SAMPLES_PER_FACTOR,
)
from axisid.estimation.verdict_checks import Check, Checked
from axisid.modeling.declaration import ANTI_WINDUP, Axis, ControlLaw
from axisid.support.arrays import Array, least_squares_step, relative_error_percent
from axisid.support.errors import DataError, ModelError, refuse
from axisid.support.one_thread import in_one_thread
from axisid.support.presentable import Presentable
from axisid.support.progress import Progress, with_progress

from .law_forms import FORMS, LawForm, ReadyLaw

# of the least that a law leaves on held-out rows; on the EMPS record four larger laws leave the
# same 0.234 % as the drive's own
_MAX_AS_WELL = 1.1
_NEGLIGIBLE_LEFT = 1e-5  # % of a control, below which laws leave the rounding of the runs only

_BLOCKS = 10  # of rows, every second of which is held out
_DELAYS = 4  # samples, the most that are tried


@dataclass(frozen=True, slots=True, kw_only=True)
class ExplainedLaw(ReadyLaw):
    """A ready law with the gains that explain a control best.

    Attributes
    ----------
    law : ControlLaw
        With these gains and the delay.
    deviations : mapping of str to float
        Standard deviation of each gain, for autocorrelated residuals; of those that the record
        tells apart from the others.
    held_out_percent : float
        What it leaves of the control on rows that the gains were not found from, percent of it.
    fitted_percent : float
        The same on the rows that they were found from.
    """

    law: ControlLaw
    deviations: Mapping[str, float]
    held_out_percent: float
    fitted_percent: float

    @property
    def toml(self) -> str:
        """How a TOML declaration has it."""
        return f'control = {{ law = "{self.function}", {self._arguments(" = ")} }}'

    @property
    def python(self) -> str:
        """How a Python declaration has it."""
        law = f"{self.function}({self._arguments('=')})"
        late = self.law.delay
        return f"control=replace({law}, delay={late})" if late else f"control={law}"

    def _arguments(self, between: str) -> str:
        given = {name: f"{value:.6g}" for name, value in self.law.gains.items()}
        given |= {name: f'"{word}"' for name, word in self.words.items()}
        given["period"] = f"{self.law.period:.10g}"
        if self.law.delay and between != "=":
            given["delay"] = str(self.law.delay)
        return ", ".join(f"{name}{between}{text}" for name, text in given.items())


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class LawSearch(Checked, Presentable):
    """Ready laws by how well they explain the recorded control, the best first.

    Attributes
    ----------
    axis : str
        Its name.
    unit : str
        Of the control.
    record : Record
    laws : tuple of ExplainedLaw
        By what they leave of rows that are held out; of those that leave as little, the one with
        the fewest gains first.
    explained : bool
        Whether the first leaves as little as the law check allows.
    as_well : int
        How many of the first leave as little as the best.
    """

    axis: str
    unit: str
    record: Record
    laws: tuple[ExplainedLaw, ...]
    explained: bool
    as_well: int

    def __repr__(self) -> str:
        return f"laws of {self.axis}: {self.best.title}, {self.best.held_out_percent:.3g} % left"

    @property
    def best(self) -> ExplainedLaw:
        """The first of them."""
        return self.laws[0]

    @property
    def checks(self) -> tuple[Check, ...]:
        """Whether a law explains the control."""
        best, left = self.best.title, self.best.held_out_percent
        fault = (
            f"No ready law explains the control: the best, {best}, leaves {left:.3g} % of it. The "
            "drive runs another law, reads other columns (a feed-forward, a sensor of its own), or "
            "runs faster than the log"
        ) * (not self.explained)
        held = f"{best} leaves {left:.3g} % of the control"
        return (Check.unless("control law", fault, held, left, MAX_LAW_RESIDUAL.value),)


@np.errstate(all="ignore")  # a law that runs away along the record is left out
@in_one_thread
def find_law(
    axis: Axis | GeneratedAxis, record: Record, *, progress: Progress | None = None
) -> LawSearch:
    """Which of the ready laws explains a recorded control, with which gains and delay.

    Each form of the ready laws is started by a regression of the control on what it is made of,
    at every delay; its gains are then found by runs along half of the record, in blocks, and it is
    judged on the other half.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        Whose drive and signals the record has; a law that it declares plays no part.
    record : Record
        With position, reference and control. Of several pieces the longest is taken.
    progress : callable, optional
        Called with how many forms are done, how many there are, and what is done.

    Raises
    ------
    DataError
        The record has no reference, no control or no position, or is too short.
    """
    generated = as_generated(axis)
    piece, needed = record.longest(), 2 * _BLOCKS * MIN_SAMPLES_PER_FACTOR.value
    lacking = [n for n in ("reference", "control", "position") if n not in record.channels()]
    refuse(
        DataError,
        (
            lacking,
            f"the record has no {''.join(lacking[:1])}; a law is found from position, reference "
            "and control. Name its columns, columns={...}",
            "missing-column",
        ),
        (
            len(piece) < needed,
            f"the record has {len(piece)} samples; to find a law it takes {needed:g} or more",
            "too-short",
        ),
    )
    along, found = _AlongRecord.of(generated, piece), list[ExplainedLaw]()
    for form in with_progress(FORMS, progress, lambda form: form.title):
        law = along.begun(form)
        if law is not None and (explained := along.fitted(form, law)) is not None:
            found.append(explained)
            if explained.held_out_percent > _NEGLIGIBLE_LEFT:  # else no anti-windup explains more
                found += along.wound(form, explained.law)
    if not found:
        raise DataError(
            "no ready law can be run along the record; check the units of its columns.",
            code="law-search",
        )
    return _ranked(generated, record, found)


@dataclass(frozen=True, slots=True, kw_only=True)
class _AlongRecord:
    """A record of one piece, along which laws are run.

    Attributes
    ----------
    axis : GeneratedAxis
    record : Record
    used, held_out : (N,) array of bool
        Samples that gains are found from, and those that a law is judged by.
    ticks : LawInputs
        What a law reads.
    """

    axis: GeneratedAxis
    record: Record
    used: NDArray[np.bool_]
    held_out: NDArray[np.bool_]
    ticks: LawInputs

    @classmethod
    def of(cls, axis: GeneratedAxis, record: Record) -> "_AlongRecord":
        """A record of one piece with position, reference and control."""
        told = unlimited(axis, record, (0, len(record))).copy()
        settling = round(1 / COMPARISON_CUTOFF.value)  # of a low-pass, at either end
        told[: settling + _DELAYS] = told[len(record) - settling :] = False
        odd = (np.arange(len(record)) * _BLOCKS // len(record)) % 2 == 1
        return cls(
            axis=axis,
            record=record,
            used=told & ~odd,
            held_out=told & odd,
            ticks=LawInputs.at_samples(
                np.asarray(record.commanded),
                record.position,
                measured_velocity(record.position, record.period),
                recorded_signals(axis, record.provenance.source, record.signals),
                record.added_control,
            ),
        )

    def begun(self, form: LawForm, *, apart: bool = False) -> ControlLaw | None:
        """The law with the delay and the filter of whose regression least is left.

        `apart` leaves open what an integral is after each time at the limit.
        """
        starts = [
            start
            for extra in form.begun(self.record.period)
            for start in self._starts(form, extra, apart=apart)
        ]
        for _, delay, gains in sorted(starts, key=lambda start: start[0]):
            with suppress(ModelError):  # a negative time
                return form.made(gains, self.record.period, delay)
        return None

    def _starts(
        self, form: LawForm, extra: float | None, *, apart: bool
    ) -> Iterator[tuple[float, int, dict[str, float]]]:
        """What a regression leaves, the delay, and the gains that it starts with."""
        columns = form.signals(self.ticks, self.record.period, extra)
        if apart:
            columns.pop("constant")
        at_once = np.column_stack([*columns.values()])
        given, told = _commands(self.axis, self.record)
        used = self.used & told
        for delay in range(_DELAYS + 1):
            late = at_once[np.maximum(np.arange(len(at_once)) - delay, 0)]
            commands = given - as_logged(self.axis, self.ticks.added_at_samples(delay))
            rows = np.column_stack([commands, as_logged(self.axis, late)])[used]
            if apart:
                rows = _about_means(rows, np.cumsum(np.diff(np.flatnonzero(used), prepend=-1) > 1))
            control, regressor = rows[:, 0], rows[:, 1:]
            values, _ = least_squares_step(regressor, control, len(rows) * np.finfo(float).eps)
            gains = form.gains(dict(zip(columns, values, strict=True)))
            if extra is not None:
                gains[form.extra] = extra
            if all(np.isfinite(value) and value for value in gains.values()):
                yield float(np.linalg.norm(control - regressor @ values)), delay, gains

    def _by_gains(self, law: ControlLaw) -> GainRegression:
        smooth = comparison_filter(law, self.record)
        along = LawReplay.of(self.axis, law, self.ticks, self.record)
        return GainRegression(
            along=along,
            declared=along,
            compared=lambda values: smooth(values)[self.used],
            neighbours=RowTimes(np.flatnonzero(self.used)),
            period=self.record.period,
        )

    def fitted(self, form: LawForm, law: ControlLaw) -> ExplainedLaw | None:
        """A law with the gains that explain the rows best, from those that it has.

        None where it does not explain the control at all. Deviations are of the gains that the
        record tells apart.
        """
        best, smooth = self._by_gains(law).best([*law.gains]), comparison_filter(law, self.record)
        along, gains = best.along, best.gains
        control, off = smooth(along.control), smooth(along.control - along.output)
        left = [
            relative_error_percent(off[some], control[some]) for some in (self.held_out, self.used)
        ]
        if not np.all(np.isfinite(left)):
            return None
        steps, covariance, _ = best.gain_steps
        deviations = zip(steps, np.sqrt(np.diag(covariance)), strict=True)
        return ExplainedLaw(
            law=replace(law, gains=gains),
            function=form.function,
            words=dict(form.words),
            deviations={name: float(abs(gains[name]) * sd) for name, sd in deviations},
            held_out_percent=left[0],
            fitted_percent=left[1],
            same=form.same,
        )

    def wound(self, form: LawForm, law: ControlLaw) -> list[ExplainedLaw]:
        """A law with each anti-windup, where the drive came near its limit; each the best start."""
        along = LawReplay.of(self.axis, law, self.ticks, self.record)
        if "sum of error" not in form.columns or not np.any(np.isfinite(along.limit)):
            return []  # no integral that may have wound up
        starts, found = [law, self.begun(form, apart=True)], list[ExplainedLaw | None]()
        for how in ANTI_WINDUP[1:]:
            wound = replace(form, words={**form.words, "anti_windup": how})
            laws = [
                wound.made(gains, self.record.period, start.delay)
                for start in starts
                if start is not None
                for gains in wound.wound_gains(start.gains)
            ]
            found.append(self.fitted(wound, min(laws, key=self._left)))
        return [each for each in found if each is not None]

    def _left(self, law: ControlLaw) -> float:
        """What a law leaves of the rows as it is; infinite where it runs away along them."""
        by_gains = self._by_gains(law)
        left = np.linalg.norm(by_gains.control - by_gains.output)
        return float(np.nan_to_num(left, nan=np.inf, posinf=np.inf))


def _commands(axis: GeneratedAxis, record: Record) -> tuple[Array, NDArray[np.bool_]]:
    """Commands of which the recorded control comes, (N,), and where it tells them, (N,).

    Behind a dead band it is less than they are, and 0 for many of them; behind a rate limit many
    are one where it changes as fast as it may.
    """
    control, path = np.asarray(record.control), axis.drive.path
    told = np.ones(len(control), dtype=bool)
    if not hides_command(axis):
        return control, told
    if path.deadband:
        told &= control != 0
        control = control + path.deadband * np.sign(control)
    fastest = (1 - LIMIT_TOLERANCE.value) * path.rate_limit * record.period
    return control, told & (np.abs(np.diff(control, prepend=control[:1])) < fastest)


def _about_means(rows: Array, stretches: NDArray[np.intp]) -> Array:
    """Rows (n, k) less their mean over the stretch that each is in."""
    firsts = np.flatnonzero(np.diff(stretches, prepend=-1))
    lengths = np.diff([*firsts, len(stretches)])
    means = np.add.reduceat(rows, firsts, axis=0) / lengths[:, None]
    return np.asarray(rows - np.repeat(means, lengths, axis=0))


def _ranked(axis: GeneratedAxis, record: Record, found: list[ExplainedLaw]) -> LawSearch:
    """The laws in their order: those that leave as little as the best by their gains.

    An ideal velocity is in no log; a law that reads one comes first where no other explains the
    control.
    """
    least = min(
        (each.held_out_percent for each in found if not each.law.takes_velocity), default=np.inf
    )
    explained = least < MAX_LAW_RESIDUAL.value
    if not explained:
        least = min(each.held_out_percent for each in found)
    found = [each for each in found if not any(_says_no_more(each, than) for than in found)]
    others = [
        each
        for each in found
        if each.held_out_percent > _as_well(least) or (explained and each.law.takes_velocity)
    ]
    first = sorted(
        (each for each in found if each not in others),
        key=lambda each: (
            len(each.law.gains),
            len(each.words),
            max(each.held_out_percent, _NEGLIGIBLE_LEFT),  # then in the order of `FORMS`
        ),
    )
    return LawSearch(
        axis=axis.name,
        unit=axis.drive.unit,
        record=record,
        laws=(*first, *sorted(others, key=lambda each: each.held_out_percent)),
        explained=first[0].held_out_percent < MAX_LAW_RESIDUAL.value,
        as_well=len(first),
    )


def _says_no_more(law: ExplainedLaw, than: ExplainedLaw) -> bool:
    """Whether a law is another one with more gains or words, which explain nothing more."""
    (gains, words), (fewer_gains, fewer_words) = (
        (len(each.law.gains), len(each.words)) for each in (law, than)
    )
    return (
        law.function == than.function
        and fewer_gains <= gains
        and fewer_words <= words
        and (fewer_gains, fewer_words) != (gains, words)
        and than.held_out_percent <= _as_well(law.held_out_percent)
    )


def _as_well(least: float) -> float:
    """Up to what a law leaves as little as one that leaves this."""
    return max(_MAX_AS_WELL * least, _NEGLIGIBLE_LEFT)
