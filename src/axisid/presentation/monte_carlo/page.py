"""A study as one self-contained page."""

from datetime import datetime
from html import escape

from axisid.estimation.monte_carlo import MonteCarlo
from axisid.modeling.declaration import Axis
from axisid.presentation.blocks import Heading
from axisid.presentation.html import blocks_html
from axisid.presentation.plots import Plot
from axisid.presentation.report import figures_html, model_html, page_of
from axisid.support.remedy import Wording, as_arguments
from axisid.support.version import __version__

from .document import checks_table, estimand_tables, findings, heading_facts, legend
from .plots import monte_carlo_plots
from .written import study_facts


def monte_carlo_page(
    result: MonteCarlo,
    *,
    command: str = "",
    made: datetime | None = None,
    wording: Wording = as_arguments,
) -> str:
    """One page about a study, self-contained: it asks the network for nothing.

    Parameters
    ----------
    result : MonteCarlo
    command : str, optional
        What reproduces it.
    made : datetime, optional
        When it was made.
    wording : callable
        How settings are told, see `axisid.support.remedy`.
    """
    plan, plots = result.plan, monte_carlo_plots(result)
    heading = plan.axis.axis.title or plan.axis.axis.name
    study = study_facts(result)
    facts = heading_facts(study)
    checks = (checks_table(study),) if study.judged else ()
    return page_of(
        (plot for plot in plots.values() if isinstance(plot, Plot)),
        several=False,
        heading=escape(f"{heading}: a Monte-Carlo study"),
        subheading=escape(f"{facts['twins']}, {facts['noise']}"),
        verdict='<section class="verdict"><h2>What it shows</h2>'
        f"{blocks_html((findings(study),))}</section>",
        parameters=blocks_html((*estimand_tables(study), *checks, legend(study))),
        figures=figures_html({0: plots}, (), wording),
        model=_models(plan.axis.axis, plan.twin.axis, right=plan.is_right),
        provenance=_provenance(facts, command, made),
        simulated='<p class="simulated"><b>SIMULATED.</b> Nothing here is measured: every run is a '
        "twin of the axis with noise of its own.</p>",
    )


def _models(axis: Axis, twin: Axis, *, right: bool) -> str:
    """The model that is identified, and that of the twins where it is another."""
    if right:
        return model_html(axis)
    return f"<h3>Identified</h3>{model_html(axis)}<h3>Simulated</h3>{model_html(twin)}"


def _provenance(facts: dict[str, str], command: str, made: datetime | None) -> str:
    told = {"made": "" if made is None else made.isoformat(" ", "seconds"), **facts}
    told["axisid"] = __version__
    again = f"<p>The command that reproduces it:</p><pre>{escape(command)}</pre>" * bool(command)
    return blocks_html((Heading(facts=tuple(told.items())),)) + again
