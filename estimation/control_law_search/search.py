"""Search for a control law: start by a regression, fit of the gains by replay, held-out error.

The result ranks the laws by how well they explain a recorded control.
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
from axisid.support.errors import DataError, ModelError
from axisid.support.one_thread import in_one_thread
from axisid.support.presentable import Presentable
from axisid.support.progress import Progress, with_progress
from axisid.support.settings import setting

from .law_forms import FORMS, LawForm, ReadyLaw

# ratio of held-out control errors up to which they are equal; on the EMPS record four laws with
# more gains have the same error of 0.234 % as the law of the drive
_EQUAL_RATIO = 1.1
_NEGLIGIBLE_ERROR = 1e-5  # % of the control; a smaller control error is rounding of the replay

_BLOCKS = 10  # blocks of rows, every second of which is held out
_DELAYS = 4  # samples, the largest delay that is tried


@dataclass(frozen=True, slots=True, kw_only=True)
class ExplainedLaw(ReadyLaw):
    """A ready law with the gains that explain a control best.

    Attributes
    ----------
    law : ControlLaw
        The law with these gains and the delay.
    deviations : mapping of str to float
        Standard error of each gain that the record identifies, for autocorrelated residuals.
    held_out_percent : float
        Control error relative to the control (rms) on held-out rows, %.
    fitted_percent : float
        Control error relative to the control (rms) on the fitted rows, %.
    """

    law: ControlLaw
    deviations: Mapping[str, float]
    held_out_percent: float
    fitted_percent: float

    @property
    def toml(self) -> str:
        """The law as a line of a TOML declaration."""
        return f'control = {{ law = "{self.function}", {self._arguments(" = ")} }}'

    @property
    def python(self) -> str:
        """The law as an argument of a Python declaration."""
        law = f"{self.function}({self._arguments('=')})"
        if self.law.delay:
            return f"control=replace({law}, delay={self.law.delay})"
        return f"control={law}"

    def _arguments(self, between: str) -> str:
        """Return the arguments of the law as text: its gains, options and period.

        `between` is the text between name and value: an equal sign with spaces for TOML, without
        for Python. The delay is an argument in TOML only.
        """
        given = {name: f"{value:.6g}" for name, value in self.law.gains.items()}
        given |= {name: f'"{word}"' for name, word in self.words.items()}
        given["period"] = f"{self.law.period:.10g}"
        if self.law.delay and between != "=":
            given["delay"] = str(self.law.delay)
        return ", ".join(f"{name}{between}{text}" for name, text in given.items())


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class LawSearch(Checked, Presentable):
    """Ready laws ranked by how well they explain the recorded control, the best first.

    Attributes
    ----------
    axis : str
        Name of the axis.
    unit : str
        Unit of the control.
    record : Record
    laws : tuple of ExplainedLaw
        Sorted by the held-out control error; of laws with an equal error, the one with the fewest
        gains comes first.
    explained : bool
        True if the control error of the first law is within the limit of the law check.
    as_well : int
        Number of laws, the first of `laws`, whose control error equals the smallest.
    """

    axis: str
    unit: str
    record: Record
    laws: tuple[ExplainedLaw, ...]
    explained: bool
    as_well: int

    def __repr__(self) -> str:
        """Return the name of the best law with its control error."""
        error = f"{self.best.held_out_percent:.3g} % of the control (rms)"
        return f"laws of {self.axis}: {self.best.title}, control error {error}"

    @property
    def best(self) -> ExplainedLaw:
        """The law that explains the control best, the first of `laws`."""
        return self.laws[0]

    @property
    def checks(self) -> tuple[Check, ...]:
        """Check of the control error of the best law; it fails if no law explains the control."""
        best, percent = self.best.title, self.best.held_out_percent
        error = f"{percent:.3g} % of the control (rms)"
        fault = ""
        if not self.explained:
            fault = (
                f"No built-in law explains the control: the control error of the best law, {best}, "
                f"is {error}. The drive may run another law, read signals that the record lacks (a "
                "feed-forward, a second sensor), or run faster than the log"
            )
        held = f"the control error of {best} is {error}"
        return (Check.unless("control law", fault, held, percent, MAX_LAW_RESIDUAL.value),)


@np.errstate(all="ignore")  # a law that diverges along the record is discarded
@in_one_thread
def find_law(
    axis: Axis | GeneratedAxis, record: Record, *, progress: Progress | None = None
) -> LawSearch:
    """Find the ready law, its gains and delay, that explain a recorded control.

    For each form of the ready laws, a regression of the control on the signals of the law gives
    start values at every delay. The gains are then fitted by replay along half of the record, in
    blocks, and the control error is evaluated on the other half.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        Axis with the drive and signals of the record; its declared law is not used.
    record : Record
        Record with position, reference and control; its longest segment is used.
    progress : callable, optional
        Called with the number of finished forms, their total, and a text.

    Raises
    ------
    DataError
        The record has no reference, no control or no position, or is too short.
    """
    generated = as_generated(axis)
    piece, needed = record.longest(), 2 * _BLOCKS * MIN_SAMPLES_PER_FACTOR.value
    for role in ("reference", "control", "position"):
        if role not in record.channels():
            raise DataError(
                f"the record has no {role}. The search for a law needs position, reference and "
                f"control. Name the column: {setting('columns', {role: 'NAME'})}.",
                code="missing-column",
            )
    if len(piece) < needed:
        raise DataError(
            f"the longest segment of the record has {len(piece)} samples. The search for a law "
            f"needs {needed:g} or more. Record a longer motion.",
            code="too-short",
        )
    # Fit each form from its start values, then also with anti-windup where it may help.
    along, found = _AlongRecord.of(generated, piece), list[ExplainedLaw]()
    for form in with_progress(FORMS, progress, lambda form: form.title):
        law = along.begun(form)
        if law is not None and (explained := along.fitted(form, law)) is not None:
            found.append(explained)
            # Anti-windup cannot improve a law with a negligible error.
            if explained.held_out_percent > _NEGLIGIBLE_ERROR:
                found += along.wound(form, explained.law)
    if not found:
        raise DataError(
            "no built-in law can be replayed along the record. Check the units of its columns.",
            code="law-search",
        )
    return _ranked(generated, record, found)


@dataclass(frozen=True, slots=True, kw_only=True)
class _AlongRecord:
    """A record without gaps, along which control laws are fitted.

    Attributes
    ----------
    axis : GeneratedAxis
    record : Record
    used, held_out : (N,) array of bool
        True for samples that fit the gains, and for held-out samples that evaluate the fit.
    ticks : LawInputs
        Inputs of any law at the samples of the record.
    """

    axis: GeneratedAxis
    record: Record
    used: NDArray[np.bool_]
    held_out: NDArray[np.bool_]
    ticks: LawInputs

    @classmethod
    def of(cls, axis: GeneratedAxis, record: Record) -> "_AlongRecord":
        """Return the object for a record without gaps with position, reference and control.

        Samples that are masked, at the drive's limit or near an end of the record are neither
        fitted nor held out. The other samples are divided into ten blocks, every second of which is
        held out.
        """
        is_valid = unlimited(axis, record, (0, len(record))).copy()
        settling = round(1 / COMPARISON_CUTOFF.value)  # samples of a low-pass, at either end
        is_valid[: settling + _DELAYS] = is_valid[len(record) - settling :] = False
        is_held_out = (np.arange(len(record)) * _BLOCKS // len(record)) % 2 == 1
        return cls(
            axis=axis,
            record=record,
            used=is_valid & ~is_held_out,
            held_out=is_valid & is_held_out,
            ticks=LawInputs.at_samples(
                np.asarray(record.commanded),
                record.position,
                measured_velocity(record.position, record.period),
                recorded_signals(axis, record.provenance.source, record.signals),
                record.added_control,
            ),
        )

    def begun(self, form: LawForm, *, by_stretch: bool = False) -> ControlLaw | None:
        """Return a law of a form with start values of its gains, delay and filter.

        They are the values of the regression with the smallest residual, over all delays and
        filters. None if no regression gives valid gains. If `by_stretch` is True, the regression
        has a free constant, the initial value of an integral, in each stretch of samples between
        times at the drive's limit; by default the whole record has one constant.
        """
        starts: list[tuple[float, int, dict[str, float]]] = []
        for extra in form.begun(self.record.period):
            starts += self._starts(form, extra, by_stretch=by_stretch)
        for _, delay, gains in sorted(starts, key=lambda start: start[0]):
            with suppress(ModelError):  # a negative time
                return form.made(gains, self.record.period, delay)
        return None

    def _starts(
        self, form: LawForm, extra: float | None, *, by_stretch: bool
    ) -> Iterator[tuple[float, int, dict[str, float]]]:
        """Yield the residual norm, the delay in samples, and the gains of a regression per delay.

        Regressions with a gain that is 0 or not finite are not yielded. `extra` is the value of the
        gain of a filter, and None for a form without a filter; `by_stretch` is as in `begun`.
        """
        columns = form.signals(self.ticks, self.record.period, extra)
        if by_stretch:
            columns.pop("constant")
        undelayed = np.column_stack([*columns.values()])
        recorded, is_known = _commands(self.axis, self.record)
        used = self.used & is_known
        for delay in range(_DELAYS + 1):
            # Regress the commands that led to the recorded control on the delayed columns.
            delayed = undelayed[np.maximum(np.arange(len(undelayed)) - delay, 0)]
            commands = recorded - as_logged(self.axis, self.ticks.added_at_samples(delay))
            rows = np.column_stack([commands, as_logged(self.axis, delayed)])[used]
            if by_stretch:  # a constant for each stretch of consecutive samples
                rows = _about_means(rows, np.cumsum(np.diff(np.flatnonzero(used), prepend=-1) > 1))
            control, regressor = rows[:, 0], rows[:, 1:]
            values, _ = least_squares_step(regressor, control, len(rows) * np.finfo(float).eps)
            gains = form.gains(dict(zip(columns, values, strict=True)))
            if extra is not None:
                gains[form.extra] = extra
            if all(np.isfinite(value) and value for value in gains.values()):
                yield float(np.linalg.norm(control - regressor @ values)), delay, gains

    def _by_gains(self, law: ControlLaw) -> GainRegression:
        """Return the regression of the control on the gains of a law, on the fitted samples.

        No gain is fitted yet: both replays of the regression, `along` with the present gains and
        `declared` with the declared gains, are those of `law`.
        """
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
        """Return a law with its gains fitted to the control, starting from those of `law`.

        The gains are fitted on the samples `used`, and the control error is evaluated on those and
        on the held-out samples. None if the law diverges along the record.
        """
        best, smooth = self._by_gains(law).best([*law.gains]), comparison_filter(law, self.record)
        along, gains = best.along, best.gains
        control, error = smooth(along.control), smooth(along.control - along.output)
        held_out, fitted = (
            relative_error_percent(error[rows], control[rows])
            for rows in (self.held_out, self.used)
        )
        if not np.all(np.isfinite([held_out, fitted])):
            return None
        steps, covariance, _ = best.gain_steps
        deviations = zip(steps, np.sqrt(np.diag(covariance)), strict=True)
        return ExplainedLaw(
            law=replace(law, gains=gains),
            function=form.function,
            words=dict(form.words),
            deviations={name: float(abs(gains[name]) * sd) for name, sd in deviations},
            held_out_percent=held_out,
            fitted_percent=fitted,
            same=form.same,
        )

    def wound(self, form: LawForm, law: ControlLaw) -> list[ExplainedLaw]:
        """Return the law fitted with each kind of anti-windup.

        Start values are the gains of `law`, and the gains of a regression with a constant for each
        stretch between times at the drive's limit. Each fit starts from the values with the
        smallest control error. The list is empty for a law without an integral, and if the drive
        did not come near its limit, so that no integral wound up.
        """
        along = LawReplay.of(self.axis, law, self.ticks, self.record)
        if "sum of error" not in form.columns or not np.any(np.isfinite(along.limit)):
            return []
        starts, found = [law, self.begun(form, by_stretch=True)], list[ExplainedLaw | None]()
        for how in ANTI_WINDUP[1:]:
            wound = replace(form, words={**form.words, "anti_windup": how})
            laws: list[ControlLaw] = []
            for start in starts:
                if start is None:
                    continue
                period, delay = self.record.period, start.delay
                laws += [wound.made(g, period, delay) for g in wound.wound_gains(start.gains)]
            found.append(self.fitted(wound, min(laws, key=self._control_error)))
        return [each for each in found if each is not None]

    def _control_error(self, law: ControlLaw) -> float:
        """Return the norm of a law's control error on the fitted samples; infinite on overflow."""
        by_gains = self._by_gains(law)
        error = np.linalg.norm(by_gains.control - by_gains.output)
        return float(np.nan_to_num(error, nan=np.inf, posinf=np.inf))


def _commands(axis: GeneratedAxis, record: Record) -> tuple[Array, NDArray[np.bool_]]:
    """Return the commands of the law that led to the recorded control, and where they are known.

    A control that is logged after a dead band is smaller than the command, and 0 for many commands.
    A control that is logged after a rate limit does not show the command where it changes at this
    limit.

    Returns
    -------
    (N,) array
        Commands, in the unit of the control.
    (N,) array of bool
        True where the command is known.
    """
    control, path = np.asarray(record.control), axis.drive.path
    is_known = np.ones(len(control), dtype=bool)
    if not hides_command(axis):
        return control, is_known
    if path.deadband:
        is_known &= control != 0
        control = control + path.deadband * np.sign(control)
    fastest = (1 - LIMIT_TOLERANCE.value) * path.rate_limit * record.period
    return control, is_known & (np.abs(np.diff(control, prepend=control[:1])) < fastest)


def _about_means(rows: Array, stretches: NDArray[np.intp]) -> Array:
    """Return rows, (n, k), minus their mean over each stretch.

    `stretches` has the number of the stretch of each row, (n,).
    """
    firsts = np.flatnonzero(np.diff(stretches, prepend=-1))
    lengths = np.diff([*firsts, len(stretches)])
    means = np.add.reduceat(rows, firsts, axis=0) / lengths[:, None]
    return np.asarray(rows - np.repeat(means, lengths, axis=0))


def _ranked(axis: GeneratedAxis, record: Record, found: list[ExplainedLaw]) -> LawSearch:
    """Return the laws ranked by their held-out control error.

    Laws with more gains than a law of the same function, but no smaller error, are removed. Laws
    whose error equals the smallest come first, sorted by their number of gains. As the velocity of
    an ideal sensor is not logged, a law that reads this velocity can only be the first if no other
    law explains the control.
    """
    least = min(
        (each.held_out_percent for each in found if not each.law.takes_velocity), default=np.inf
    )
    explained = least < MAX_LAW_RESIDUAL.value
    if not explained:
        least = min(each.held_out_percent for each in found)
    found = [each for each in found if not any(_is_superfluous(each, than) for than in found)]
    others = [
        each
        for each in found
        if each.held_out_percent > _largest_equal(least) or (explained and each.law.takes_velocity)
    ]
    first = sorted(
        (each for each in found if each not in others),
        key=lambda each: (
            len(each.law.gains),
            len(each.words),
            max(each.held_out_percent, _NEGLIGIBLE_ERROR),  # then in the order of `FORMS`
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


def _is_superfluous(law: ExplainedLaw, than: ExplainedLaw) -> bool:
    """Return True if a law has more gains or options than the law `than`, but no smaller error.

    Both must be of the same function. The error of `than` may be up to 1.1 times as large.
    """
    gains, words = len(law.law.gains), len(law.words)
    fewer_gains, fewer_words = len(than.law.gains), len(than.words)
    return (
        law.function == than.function
        and fewer_gains <= gains
        and fewer_words <= words
        and (fewer_gains, fewer_words) != (gains, words)
        and than.held_out_percent <= _largest_equal(law.held_out_percent)
    )


def _largest_equal(percent: float) -> float:
    """Return the largest control error, %, that counts as equal to a given control error, %."""
    return max(_EQUAL_RATIO * percent, _NEGLIGIBLE_ERROR)
