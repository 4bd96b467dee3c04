"""Figures of a study: errors in standard errors, coverage of intervals, bias by runs."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from scipy.special import ndtr

from axisid.estimation.choices import fitted_output
from axisid.estimation.monte_carlo import PARAMETER, Mean, MonteCarlo, Share
from axisid.support.arrays import Array
from axisid.support.mappings import grouped
from axisid.support.missing import Missing

from .plot import TITLES, Panel, Plot, PlotSeries, Tone, labelled, paired

_REACH = 5.0  # half width of a histogram, in standard errors
_BINS = (10, 60)  # smallest and largest number of bins; between them the root of the runs
_LEVELS = np.array([0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.975, 0.99])  # of confidence intervals
_FINE = 20  # points that draw one bar of a histogram
_MOST_POINTS = 300  # points of the mean error over the runs
_FEWEST_RUNS = 10  # with fewer there is no figure


def method_title(method: str) -> str:
    """Return the name of a method in figures: ``IDM-IV``, or ``fit:control`` for a fit."""
    return method if fitted_output(method) else method.upper()


def monte_carlo_plots(result: MonteCarlo) -> dict[str, Plot | Missing]:
    """Return every figure of a study by name; Missing, with the reason, if it cannot be drawn."""
    return {name: monte_carlo_plot(result, name) for name in PLOTS}


def monte_carlo_plot(result: MonteCarlo, name: str) -> Plot | Missing:
    """Return the figure `name` of a study, one of `PLOTS`.

    Missing, with the reason, if no parameter can be compared or there are too few runs.
    """
    if not _by_parameter(result):
        return Missing("the identified model and the simulated one have no parameter in common")
    if len(result) < _FEWEST_RUNS:
        return Missing(f"a figure needs {_FEWEST_RUNS} runs or more")
    return PLOTS[name](result)


def _by_parameter(result: MonteCarlo) -> list[tuple[str, str, dict[str, int]]]:
    """Return each parameter with a known true value: name, unit, and index by method.

    The index is that of the pair of parameter and method among the estimands of the study.
    """
    found = grouped(
        ((each.name, each.unit), (each.method, place))
        for place, (each, truth) in enumerate(zip(result.estimands, result.truths, strict=True))
        if each.kind == PARAMETER and np.isfinite(truth)
    )
    return [(name, unit, dict(places)) for (name, unit), places in found.items()]


def _panels(
    result: MonteCarlo,
    label: Callable[[str, str], str],
    series: Callable[[int, str, Tone], PlotSeries],
    *beside: PlotSeries,
    levels: tuple[float, ...] = (),
) -> tuple[Panel, ...]:
    """Return one panel per parameter, with one curve per method; the first has the legend.

    Parameters
    ----------
    result : MonteCarlo
    label : callable
        Returns the label of y, from name and unit of a parameter.
    series : callable
        Returns the curve, from the index of the estimand, its label in the legend and its tone.
    *beside : PlotSeries
        Further series of each panel.
    levels : tuple of float
        Values of y with a dashed line.
    """
    tones = dict(paired(result.plan.methods))
    return tuple(
        Panel(
            label=label(name, unit),
            series=(
                *(
                    series(place, "" if i else method_title(method), tones[method])
                    for method, place in places.items()
                ),
                *beside,
            ),
            levels=levels,
        )
        for i, (name, unit, places) in enumerate(_by_parameter(result))
    )


def _errors(result: MonteCarlo) -> Plot:
    """Return the figure of the density of errors, in standard errors."""
    bins = 2 * round(float(np.clip(np.sqrt(len(result)), *_BINS)) / 2)
    edges = np.linspace(-_REACH, _REACH, bins + 1)
    # Enough points that the steps are drawn as steps.
    x = np.linspace(-_REACH, _REACH, _FINE * bins + 1)
    bars = np.minimum(np.arange(len(x)) // _FINE, bins - 1)

    def density(place: int, label: str, tone: Tone) -> PlotSeries:
        """Return the histogram of the errors of one estimand, as steps."""
        errors = np.clip(result.normalised(place), -_REACH, _REACH)
        share = np.histogram(errors, edges)[0] / max(len(errors), 1) / np.diff(edges)
        return PlotSeries(label=label, x=x, y=share[bars], tone=tone)

    y = np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi)
    normal = PlotSeries(label="", x=x, y=y, tone="measured", dashed=True)
    return Plot(
        name="errors",
        title=TITLES["errors"],
        caption="Density of the error divided by the standard error of its run. Dashed: normal "
        f"distribution. Errors beyond {_REACH:g} standard errors are in the outermost bars.",
        x_label="error / standard error",
        panels=_panels(result, lambda name, _: f"{name}, density", density, normal),
    )


def _coverage(result: MonteCarlo) -> Plot:
    """Return the figure of the coverage of confidence intervals over their level."""
    percent = 100 * _LEVELS

    def shares(place: int, label: str, tone: Tone) -> PlotSeries:
        """Return the coverage of the intervals of one estimand, with Wilson's intervals."""
        # An interval contains the truth if its level is above this two-sided probability.
        inside = 2 * ndtr(np.abs(result.normalised(place))) - 1
        found = [Share.of_truths(inside <= level) for level in _LEVELS]
        low, high = 100 * np.array([share.interval for share in found]).T
        y = 100 * np.array([share.value for share in found])
        return PlotSeries(label=label, x=percent, y=y, low=low, high=high, tone=tone)

    ideal = PlotSeries(label="", x=percent, y=percent, tone="measured", dashed=True)
    return Plot(
        name="coverage",
        title=TITLES["coverage"],
        caption="Share of the intervals that contain the true value, by level, with Wilson's 95 % "
        "interval. Dashed: nominal coverage; below it, intervals are too narrow. Levels other than "
        "95 % are calculated from the 95 % interval with a normal distribution.",
        x_label="level of the interval [%]",
        panels=_panels(result, lambda name, _: f"{name}, coverage [%]", shares, ideal),
    )


def _bias(result: MonteCarlo) -> Plot:
    """Return the figure of the mean error over the number of runs."""

    def running(place: int, label: str, tone: Tone) -> PlotSeries:
        """Return the mean error of one estimand over the runs so far."""
        errors = result.corrected[:, place] - result.truths[place]
        there = np.flatnonzero(np.isfinite(errors))
        ends = np.unique(np.linspace(min(2, len(there)), len(there), _MOST_POINTS).astype(int))
        means = [Mean.of_values(errors[there[:end]]) for end in ends]
        y = np.array([mean.value for mean in means])
        half: Array = 2 * np.array([mean.error for mean in means])
        runs = (result.numbers.runs[there[ends - 1]] + 1).astype(float)
        return PlotSeries(label=label, x=runs, y=y, low=y - half, high=y + half, tone=tone)

    return Plot(
        name="bias",
        title=TITLES["bias"],
        caption="Mean error over the runs so far, +- two standard errors.",
        x_label="runs",
        panels=_panels(
            result, lambda name, unit: labelled(f"{name}, bias", unit), running, levels=(0.0,)
        ),
        whole=True,
    )


#: Figures by name, in the order of a page.
PLOTS: Mapping[str, Callable[[MonteCarlo], Plot]] = MappingProxyType(
    {"errors": _errors, "coverage": _coverage, "bias": _bias}
)
