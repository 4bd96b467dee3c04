"""The study that the paper leaves to others: how coarse an encoder each method bears.

The paper's axis is simulated with encoders of fewer and fewer counts a revolution, in the loop and
in the record, many twins each, and identified under both of the paper's filters. The screw has
20 mm a revolution. The velocity that the law reads is an ideal sensor's, as in the paper's twin.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, build
from axisid.estimation.estimates import Estimate
from axisid.estimation.identification import Identification, identify
from axisid.estimation.records import Record
from axisid.estimation.signals import Prefilter
from axisid.estimation.simulation import simulate_batch, twin_record
from axisid.modeling.text import load_axis
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError, UsageError
from axisid.support.progress import Progress, with_progress
from axisid.support.real_numbers import is_whole
from axisid.support.user_values import quoted

from .study import APPROPRIATE, INAPPROPRIATE

#: Counts of an encoder a revolution, and the metres of a revolution.
COUNTS, REVOLUTION = (4000, 1000, 400, 200, 100, 50, 20), 0.02
NOISE = 3.8e-6  # m, of the position, as the paper's twin has
METHODS = ("idm-ls", "idm-iv", "didim")
FILTERS = {"appropriate": APPROPRIATE, "inappropriate": INAPPROPRIATE}


@dataclass(frozen=True, kw_only=True)
class MethodFigures:
    """What a method makes of the twins of one encoder under one filter.

    Attributes
    ----------
    estimated : float
        Share of the twins that it gives an estimate of.
    bias, scatter : (p,) array
        Mean error and standard deviation of the values without the filter's bias, in percent of the
        true ones; NaN of too few estimates.
    held : (p,) array
        Share of the 95 % intervals that hold the truth.
    """

    estimated: float
    bias: Array
    scatter: Array
    held: Array


@dataclass(frozen=True, kw_only=True)
class EncoderCase:
    """The twins of one encoder under one filter.

    Attributes
    ----------
    counts : int
        A revolution.
    filter : str
        Of `FILTERS`.
    methods : mapping of str to MethodFigures
    judged : float
        Share of the twins of which there is a verdict.
    objected : mapping of str to float
        By check, the share of these verdicts in which it fails.
    clean : float
        Share of these verdicts to which nothing is objected.
    """

    counts: int
    filter: str
    methods: Mapping[str, MethodFigures]
    judged: float
    objected: Mapping[str, float]
    clean: float


@dataclass(frozen=True, kw_only=True)
class EncoderStudy:
    """What becomes of each method as the encoder grows coarse.

    Attributes
    ----------
    names : tuple of str
        Of the parameters.
    runs : int
        Twins of each encoder.
    cases : tuple of EncoderCase
    """

    names: tuple[str, ...]
    runs: int
    cases: tuple[EncoderCase, ...]

    def under(self, name: str) -> tuple[EncoderCase, ...]:
        """The cases of one filter, the finest encoder first."""
        return tuple(case for case in self.cases if case.filter == name)


def run_encoder_study(
    runs: int = 100,
    counts: Sequence[int] = COUNTS,
    *,
    seed: int = 1,
    progress: Progress | None = None,
) -> EncoderStudy:
    """Identify twins of the paper's axis with coarser and coarser encoders.

    Parameters
    ----------
    runs : int
        Twins of each encoder; each has noise of its own, and its zero elsewhere in a count.
    counts : sequence of int
        A revolution of 20 mm.
    seed : int
    progress : callable, optional
        See `Progress`.

    Raises
    ------
    UsageError
        The runs are no whole number of 2 or more, or counts none of 1 or more.

    References
    ----------
    [Brunot2015]_, whose conclusion names it as future work.
    """
    for what, least, values in (("runs", 2, [runs]), ("counts", 1, counts)):
        if not all(is_whole(value) and value >= least for value in values):
            given = quoted(list(values) if what == "counts" else runs)
            raise UsageError(
                f"the {what} of the encoder's study are {given}; give whole numbers of {least} or "
                "more.",
                code="encoder-study",
            )
    axis = build(load_axis("emps2015"))
    cases = [(each, name) for each in counts for name in FILTERS]
    twins: dict[int, list[Record]] = {}
    found = []
    said = with_progress(cases, progress, lambda case: f"{case[0]} counts, {case[1]} filter")
    for each, name in said:
        if each not in twins:  # of one encoder at a time
            twins = {each: list(encoder_twins(axis, each, runs, seed))}
        found.append(_case(axis, twins[each], each, name))
    return EncoderStudy(names=axis.names, runs=runs, cases=tuple(found))


def encoder_twins(axis: GeneratedAxis, counts: int, runs: int, seed: int) -> Iterator[Record]:
    """Records of the paper's loop with an encoder of so many counts a revolution."""
    twin, truth = _twin(axis)
    reference, step = np.asarray(twin.reference), REVOLUTION / counts
    rng = np.random.default_rng([seed, counts])
    # Where in a count the motion begins decides how the loop hunts about it.
    moved = reference[:, None] + rng.uniform(0.0, step, runs)
    noise = rng.normal(0.0, NOISE, moved.shape)
    loops = simulate_batch(
        axis,
        np.tile(truth, (runs, 1)),
        moved,
        twin.period,
        position_noise=noise,
        resolution=step,
        wanted=("position", "control"),
    )
    measured = np.floor((loops["position"] + noise) / step + 0.5) * step
    for run in range(runs):
        yield Record(
            time=twin.time,
            position=measured[:, run],
            reference=moved[:, run],
            control=loops["control"][:, run],
        )


@cache
def _twin(axis: GeneratedAxis) -> tuple[Record, Array]:
    """The twin of `axisid.paper.study` and its true values."""
    twin = twin_record(axis)
    truth = twin.provenance.truth or {}
    return twin, np.array([truth[name] for name in axis.names])


def _case(axis: GeneratedAxis, twins: Sequence[Record], counts: int, name: str) -> EncoderCase:
    _, truth = _twin(axis)
    made: dict[str, list[tuple[Array, Array]]] = {method: [] for method in METHODS}
    objected: Counter[str] = Counter()
    judged = clean = 0
    for twin in twins:
        result = _identified(axis, twin, FILTERS[name])
        if result is None:
            continue
        for method, estimate in result.estimates.items():
            made[method].append(_errors(estimate, truth))
        fails = [check.name for check in result.verdict if check.status == "fail"]
        objected.update(fails)
        judged, clean = judged + 1, clean + (not fails)
    return EncoderCase(
        counts=counts,
        filter=name,
        methods={method: _figures(each, len(twins), len(truth)) for method, each in made.items()},
        judged=judged / len(twins),
        objected={check: times / judged for check, times in objected.most_common()},
        clean=clean / judged if judged else float("nan"),
    )


def _identified(axis: GeneratedAxis, twin: Record, prefilter: Prefilter) -> Identification | None:
    """By all methods that give an estimate of the twin; None where none does."""
    try:
        return _estimated(axis, twin, prefilter, METHODS)
    except AxisidError:
        able = [method for method in METHODS if _is_able(axis, twin, prefilter, method)]
    return _estimated(axis, twin, prefilter, able) if able else None


def _is_able(axis: GeneratedAxis, twin: Record, prefilter: Prefilter, method: str) -> bool:
    try:
        _estimated(axis, twin, prefilter, [method])
    except AxisidError:
        return False
    return True


def _estimated(
    axis: GeneratedAxis, twin: Record, prefilter: Prefilter, methods: Sequence[str]
) -> Identification:
    """The result by methods, with intervals, which are else found when they are asked for."""
    result = identify(axis, twin, prefilter, methods)
    for method in methods:
        _ = result[method].parameters
    return result


def _errors(estimate: Estimate, truth: Array) -> tuple[Array, Array]:
    """Errors in percent, and whether the intervals hold the truth."""
    values = list(estimate.parameters.values())
    off = np.array([value.corrected for value in values]) / truth - 1
    low, high = np.array([value.interval for value in values]).T
    return 100 * off, ((low <= truth) & (truth <= high)).astype(float)


def _figures(made: Sequence[tuple[Array, Array]], runs: int, size: int) -> MethodFigures:
    if len(made) < 2:
        nothing = np.full(size, np.nan)
        return MethodFigures(
            estimated=len(made) / runs, bias=nothing, scatter=nothing, held=nothing
        )
    off, held = (np.array(each) for each in zip(*made, strict=True))
    return MethodFigures(
        estimated=len(made) / runs,
        bias=off.mean(axis=0),
        scatter=off.std(axis=0, ddof=1),
        held=held.mean(axis=0),
    )
