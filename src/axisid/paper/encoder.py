"""The study that the paper leaves to others: how coarse an encoder each method bears.

The paper's axis is simulated with encoders of fewer and fewer counts a revolution, in the loop and
in the record, many twins each, and identified under both of the paper's filters. The screw has
20 mm a revolution. The velocity that the law reads is an ideal sensor's, as in the paper's twin.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, build
from axisid.estimation.monte_carlo import MonteCarlo, monte_carlo
from axisid.estimation.twins import Chain
from axisid.modeling.text import load_axis
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError, UsageError
from axisid.support.progress import Progress, with_progress
from axisid.support.real_numbers import is_whole
from axisid.support.user_values import quoted

from .encoder_fits import control_fits
from .study import APPROPRIATE, INAPPROPRIATE

#: Counts of an encoder a revolution, and the metres of a revolution.
COUNTS, REVOLUTION = (4000, 1000, 400, 200, 100, 50, 20), 0.02
NOISE = 3.8e-6  # m, of the position, as the paper's twin has
METHODS = ("idm-ls", "idm-iv", "didim")
#: The fit of the control beside them, which passes no filter.
CONTROL_FIT = "clie"
_FEWEST = 2  # estimates that a scatter is told of
FILTERS = {"appropriate": APPROPRIATE, "inappropriate": INAPPROPRIATE}


@dataclass(frozen=True, kw_only=True)
class MethodFigures:
    """What a method makes of the twins of one encoder under one filter.

    Attributes
    ----------
    estimated : float
        Share of the twins that it gives an estimate of.
    bias, scatter : (p,) array
        Mean error and standard deviation of the values without its bias, in percent of the
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
    jobs: int = 1,
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
    jobs : int
        Processes, as `monte_carlo` takes them.
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
    found: list[EncoderCase] = []
    for each in with_progress(counts, progress, lambda each: f"{each} counts"):
        fits = {CONTROL_FIT: _fitted(axis, _noise(each), runs, seed)}
        cases = (_case(axis, each, name, runs, seed, jobs) for name in FILTERS)
        found += (replace(case, methods={**case.methods, **fits}) for case in cases)
    return EncoderStudy(names=axis.names, runs=runs, cases=tuple(found))


def _noise(counts: int) -> Chain:
    return Chain(position=NOISE, position_step=REVOLUTION / counts, anywhere=True)


def _fitted(axis: GeneratedAxis, noise: Chain, runs: int, seed: int) -> MethodFigures:
    """Of the fit of the control, in percent of the true values."""
    fits = control_fits(axis, noise, runs, seed)
    if len(fits) < _FEWEST:
        return _nothing(len(fits) / runs, len(axis.names))
    experiment = axis.declared.experiment
    known = {} if experiment is None else experiment.truth
    truth = np.array([known[name] for name in axis.names])
    values = np.array([[each.parameters[n].value for n in axis.names] for each in fits])
    ends = np.array([[each.parameters[n].interval for n in axis.names] for each in fits])
    return MethodFigures(
        estimated=len(fits) / runs,
        bias=100 * (values.mean(axis=0) / truth - 1),
        scatter=100 * values.std(axis=0, ddof=1) / truth,
        held=((ends[..., 0] <= truth) & (truth <= ends[..., 1])).mean(axis=0),
    )


def _case(
    axis: GeneratedAxis, counts: int, name: str, runs: int, seed: int, jobs: int
) -> EncoderCase:
    """The twins of one encoder under one filter; their noise is that of the other encoders."""
    noise = _noise(counts)
    try:
        found = monte_carlo(
            axis,
            runs,
            METHODS,
            prefilter=FILTERS[name],
            noise=noise,
            checks=runs,
            seed=seed,
            jobs=jobs,
        )
    except EstimationError as error:
        if error.code != "no-twin-identified":
            raise
        return EncoderCase(
            counts=counts,
            filter=name,
            methods={method: _nothing(0.0, len(axis.names)) for method in METHODS},
            judged=0.0,
            objected={},
            clean=float("nan"),
        )
    objected = {
        check.name: check.fails.count / found.judged
        for check in found.check_figures
        if check.fails.count
    }
    return EncoderCase(
        counts=counts,
        filter=name,
        methods={method: _figures(found, method) for method in METHODS},
        judged=found.judged / runs,
        objected=dict(sorted(objected.items(), key=lambda each: -each[1])),
        clean=1 - found.objected.value,
    )


def _figures(found: MonteCarlo, method: str) -> MethodFigures:
    """Of a method, in percent of the true values."""
    estimated = found.estimated(method)
    if estimated.count < _FEWEST:
        return _nothing(estimated.value, len(found.plan.axis.names))
    figures = [found.of(method, name) for name in found.plan.axis.names]
    truth = np.array([each.truth for each in figures])
    return MethodFigures(
        estimated=estimated.value,
        bias=100 * np.array([each.bias.value for each in figures]) / truth,
        scatter=100 * np.array([each.scatter.value for each in figures]) / truth,
        held=np.array([each.coverage[found.plan.chosen].value for each in figures]),
    )


def _nothing(estimated: float, size: int) -> MethodFigures:
    """Of a method that gives too few estimates to tell anything."""
    unknown = np.full(size, np.nan)
    return MethodFigures(estimated=estimated, bias=unknown, scatter=unknown, held=unknown)
