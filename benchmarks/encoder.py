"""The study that the paper leaves to others: how coarse an encoder each method bears.

The paper's axis is simulated with encoders of fewer and fewer counts a revolution, in the loop and
in the record, many twins each, and identified under both of the paper's filters. The screw has
20 mm a revolution. The velocity that the law reads is an ideal sensor's, as in the paper's twin.

    python benchmarks/encoder.py --jobs 2                   100 twins of each encoder, minutes
    python benchmarks/encoder.py --output FOLDER            figures too
    python benchmarks/encoder.py --runs 2 --counts 1000 20  in small
    python benchmarks/encoder.py --json -                   one JSON object
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from figures import give, parser_of

from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.choices import CONTROL, FIT
from axisid.estimation.monte_carlo import (
    PARAMETER,
    MonteCarlo,
    Share,
    interval_covariance,
    monte_carlo,
)
from axisid.estimation.noise_models import Chain
from axisid.modeling.parsing import load_axis
from axisid.paper import FILTERS
from axisid.presentation.documents import (
    Cell,
    Document,
    QuantityCell,
    TableBlock,
    TableColumn,
    paragraph,
    plain_text,
    text_columns,
)
from axisid.presentation.plots import Panel, Plot, PlotSeries, Tone
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError

#: Counts of an encoder a revolution, and the metres of a revolution.
COUNTS, REVOLUTION = (4000, 1000, 400, 200, 100, 50, 20), 0.02
NOISE = 3.8e-6  # m, of the position, as the paper's twin has
METHODS = ("idm-ls", "idm-iv", "didim")
#: The fit of the control beside them, which passes no filter.
CONTROL_FIT = "clie"
_FEWEST = 2  # estimates that a scatter is told of
_TONES: dict[str, Tone] = {
    "idm-ls": "error",
    "idm-iv": "model",
    "didim": "other",
    CONTROL_FIT: "violet",
}
#: The methods, as columns.
SHOWN = (*METHODS, CONTROL_FIT)
_MOST_OBJECTIONS = 3  # that are told of a case
_WIDEST = 30.0  # % of a bias that a figure shows at first
_NOTES = (
    "bias, sd: mean error and scatter over the twins of the value without its bias, percent of "
    "the true value. held: share of the 95 % intervals that hold it. estimates: share of the "
    "twins that a method gives one of; no error is told of fewer than two. The encoder rounds "
    "inside the loop and in the record; the motion begins anywhere in a count. The law's velocity"
    " is an ideal sensor's. clie: fit of the control (axisid fit), which passes no filter and is "
    "the same under both."
)


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
    runs: int = 100, counts: Sequence[int] = COUNTS, *, seed: int = 1, jobs: int = 1
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

    References
    ----------
    [Brunot2015]_, whose conclusion names it as future work.
    """
    axis = build(load_axis("emps2015"))
    found: list[EncoderCase] = []
    for each in counts:
        noise = Chain(position=NOISE, position_step=REVOLUTION / each, anywhere=True)
        how: dict[str, Any] = {"noise": noise, "seed": seed, "jobs": jobs}
        fits = _of_control(axis, runs, **how)
        for name, prefilter in FILTERS.items():
            made = _studied(axis, runs, METHODS, prefilter=prefilter, checks=runs, **how)
            found.append(_case(each, name, made, fits, len(axis.names)))
    return EncoderStudy(names=axis.names, runs=runs, cases=tuple(found))


def _studied(
    axis: GeneratedAxis, runs: int, methods: Sequence[str], **how: Any
) -> MonteCarlo | None:
    """The twins of one encoder, whose noise is that of the other ones; None without an estimate."""
    try:
        return monte_carlo(axis, runs, methods, **how)
    except EstimationError as error:
        if error.code != "no-twin-identified":
            raise
        return None


def _of_control(axis: GeneratedAxis, runs: int, **how: Any) -> MethodFigures:
    """Of the fit of the control."""
    method = f"{FIT}{CONTROL}"
    return _figures(_studied(axis, runs, [method], **how), method, len(axis.names))


def _case(
    counts: int, name: str, found: MonteCarlo | None, fits: MethodFigures, size: int
) -> EncoderCase:
    """The twins of one encoder under one filter."""
    methods = {method: _figures(found, method, size) for method in METHODS}
    objected = {
        check.name: check.fails.count / found.judged
        for check in (found.check_figures if found else ())
        if found and check.fails.count
    }
    return EncoderCase(
        counts=counts,
        filter=name,
        methods={**methods, CONTROL_FIT: fits},
        judged=found.judged / found.plan.runs if found else 0.0,
        objected=dict(sorted(objected.items(), key=lambda each: -each[1])),
        clean=1 - found.objected.value if found else math.nan,
    )


def _figures(found: MonteCarlo | None, method: str, size: int) -> MethodFigures:
    """Of a method, in percent of the true values; NaN of too few estimates to tell anything."""
    runs = [each.runs for each in found or () if each.method == method]
    estimated = Share(max(runs, default=0), len(found) if found else 1)
    figures = [
        each
        for each in (found.figures if found else ())
        if (each.method, each.kind) == (method, PARAMETER)
    ]
    if found is None or estimated.count < _FEWEST or len(figures) < size:
        unknown = np.full(size, np.nan)
        return MethodFigures(estimated=estimated.value, bias=unknown, scatter=unknown, held=unknown)
    stated = interval_covariance(method, found.chosen)
    truth = np.array([each.truth for each in figures])
    return MethodFigures(
        estimated=estimated.value,
        bias=100 * np.array([each.bias.value for each in figures]) / truth,
        scatter=100 * np.array([each.scatter.value for each in figures]) / truth,
        held=np.array([each.coverage[stated].value for each in figures]),
    )


def encoder_document(study: EncoderStudy) -> Document:
    """A table of errors and one of verdicts for each filter."""
    tables = [table(study, name) for name in FILTERS for table in (_errors_table, _verdicts_table)]
    made = f"{study.runs} twins of each encoder, screw of 20 mm a revolution"
    return paragraph(made), *tables, paragraph(_NOTES)


def _errors_table(study: EncoderStudy, name: str) -> TableBlock:
    rows: list[tuple[Cell, ...]] = []
    for case in study.under(name):
        for i, parameter in enumerate(study.names):
            label = "" if i else str(case.counts)
            cells = (_quantity(made, i) for made in case.methods.values())
            rows.append((label, parameter, *cells))
    return TableBlock(
        columns=(
            *text_columns(["counts", "%"]),
            *(TableColumn(method.upper(), parts=("sd", "held", "estimates")) for method in SHOWN),
        ),
        rows=tuple(rows),
        labels=2,
        title=f"{_titled(name)}: bias by method",
    )


def _quantity(made: MethodFigures, i: int) -> QuantityCell:
    """Of a parameter; how many estimates there are is told with the first."""
    estimated = "" if i else _share(made.estimated)
    return QuantityCell(
        _figure(made.bias[i]), _figure(made.scatter[i]), (_share(made.held[i]), estimated)
    )


def _verdicts_table(study: EncoderStudy, name: str) -> TableBlock:
    def objections(case: EncoderCase) -> str:
        first = list(case.objected.items())[:_MOST_OBJECTIONS]
        return ", ".join(f"{check} {_share(share)}" for check, share in first)

    rows = tuple(
        (str(case.counts), _share(case.judged), _share(case.clean), objections(case))
        for case in study.under(name)
    )
    return TableBlock(
        columns=(
            *text_columns(["counts"]),
            TableColumn("judged", "%"),
            TableColumn("nothing fails", "%"),
            *text_columns(["fails most, % of the verdicts"]),
        ),
        rows=rows,
        title=f"{_titled(name)}: what the verdicts say",
    )


def _titled(name: str) -> str:
    return f"{name.capitalize()} filter, {FILTERS[name].cutoff:g} Hz"


def _figure(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.2f}" if abs(value) < 10 else f"{value:.0f}"


def _share(value: float) -> str:
    return "" if np.isnan(value) else f"{100 * value:.0f}"


def encoder_plot(study: EncoderStudy, name: str) -> Plot:
    """Bias, with the scatter as whiskers, over the counts."""
    cases = study.under(name)
    counts = np.array([float(case.counts) for case in cases])
    panels = []
    for i, parameter in enumerate(study.names):
        series = []
        for shift, method in zip((0.91, 0.97, 1.03, 1.09), SHOWN, strict=True):
            bias = np.array([case.methods[method].bias[i] for case in cases])
            scatter = np.array([case.methods[method].scatter[i] for case in cases])
            series.append(
                PlotSeries(
                    label=method.upper() if not i else "",
                    x=shift * counts,
                    y=bias,
                    low=bias - scatter,
                    high=bias + scatter,
                    kind="points",
                    tone=_TONES[method],
                )
            )
        widest = (-_WIDEST, _WIDEST)
        panels.append(
            Panel(label=f"{parameter}, bias [%]", series=tuple(series), levels=(0.0,), span=widest)
        )
    return Plot(
        name=f"encoder_{name}",
        title=f"Bias over the encoder, {_titled(name).lower()}",
        caption="Whiskers are the scatter over the twins.",
        x_label="counts a revolution of 20 mm",
        panels=tuple(panels),
        log=True,
    )


def encoder_dict(study: EncoderStudy) -> dict[str, object]:
    """The study as plain data; what is not known is None."""
    return {
        "runs": study.runs,
        "parameters": list(study.names),
        "cases": [
            {
                "counts": case.counts,
                "filter": case.filter,
                "judged": case.judged,
                "clean": None if np.isnan(case.clean) else case.clean,
                "objected": dict(case.objected),
                "methods": {
                    name: {
                        "estimated": made.estimated,
                        "bias_percent": _known(made.bias),
                        "scatter_percent": _known(made.scatter),
                        "held": _known(made.held),
                    }
                    for name, made in case.methods.items()
                },
            }
            for case in study.cases
        ],
    }


def _known(values: Array) -> list[float | None]:
    return [None if np.isnan(value) else float(value) for value in values]


def main() -> None:
    """Print the tables, or write the JSON object; and draw the figures."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=100, help="twins of each encoder (default 100)")
    parser.add_argument("--counts", type=int, nargs="+", default=COUNTS, help="a revolution")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    parser.add_argument("--output", type=Path, metavar="FOLDER", help="of figures, which are drawn")
    options = parser.parse_args()
    study = run_encoder_study(options.runs, options.counts, seed=options.seed, jobs=options.jobs)
    if options.output is not None:
        from axisid.presentation.matplotlib import write_figures

        write_figures([encoder_plot(study, name) for name in FILTERS], options.output, "png")
    give(encoder_dict(study), options.json, [plain_text(encoder_document(study))])


if __name__ == "__main__":
    main()
