"""The page of a fit of an output."""

from datetime import datetime
from html import escape

from axisid.estimation.fitting import OutputFit
from axisid.presentation.blocks import Heading, Notes, Table
from axisid.presentation.html import blocks_html
from axisid.presentation.plots import Plot, numbered, output_plot
from axisid.presentation.text import output_fit_document
from axisid.support.errors import Missing

from .page import figures_html, model_html, page_of, simulated_html
from .parameters import verdict_html
from .provenance import facts_html, made_by, made_text


def fit_report_html(
    fit: OutputFit,
    *,
    command: str = "",
    made: datetime | None = None,
) -> str:
    """One page about a fit, self-contained: it asks the network for nothing.

    Parameters
    ----------
    fit : OutputFit
    command : str, optional
        What reproduces it.
    made : datetime, optional
        When it was made.
    """
    axis, document = fit.axis.axis, output_fit_document(fit)
    shown = [block for block in document if isinstance(block, (Table, Notes))]
    facts = {k: v for b in document if isinstance(b, Heading) for k, v in b.facts}
    samples = sum(map(len, fit.records))
    sources = [record.provenance.source for record in fit.records]
    plots = fit_plots(fit)
    return page_of(
        (p for of in plots.values() for p in of.values() if isinstance(p, Plot)),
        several=len(fit.records) > 1,
        heading=escape(axis.title or axis.name),
        subheading=escape(
            f"{axis.name}, {fit.output} fitted to {', '.join(sources)}, {samples} samples"
        ),
        verdict=verdict_html(fit.checks, f"fit of the {fit.output}"),
        parameters="".join(f'<div class="scroll">{blocks_html((block,))}</div>' for block in shown),
        figures=figures_html(plots, sources),
        model=model_html(axis),
        provenance=facts_html(
            {
                "made": made_text(made),
                **facts,
                **made_by(fit.axis),
            },
            command,
        ),
        simulated=simulated_html(_truth(fit)),
    )


def fit_plots(fit: OutputFit) -> dict[int, dict[str, Plot | Missing]]:
    """Figures by the number of the record, from 1, each by its name; of one record under 0."""
    if len(fit.records) == 1:
        return {0: {"output": output_plot(fit)}}
    found: dict[int, dict[str, Plot | Missing]] = {0: {}}
    for i, record in enumerate(fit.records, 1):
        plot = output_plot(fit, i - 1)
        found[i] = {f"output-{i}": numbered(plot, i, record.provenance.source)}
    return found


def _truth(fit: OutputFit) -> str:
    truth = fit.records[0].provenance.truth
    return ", ".join(f"{name} = {value:g}" for name, value in truth.items())
