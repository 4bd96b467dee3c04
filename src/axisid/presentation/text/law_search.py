"""Which ready laws explain a recorded control, as a document."""

from axisid.estimation.law_search import ExplainedLaw, LawSearch
from axisid.presentation.blocks import (
    Column,
    Document,
    Heading,
    Paragraph,
    Sentence,
    Table,
    paragraph,
    text_columns,
)
from axisid.presentation.formulas import figure_text
from axisid.support.remedy import Wording, as_arguments

from .record import record_facts

_MOST = 8  # laws that are listed


def law_search_document(search: LawSearch, *, wording: Wording = as_arguments) -> Document:
    """The laws by what they leave, the gains of the best, and how to declare it."""
    heading = Heading(facts=tuple(record_facts(search.record, wording).items()))
    return heading, _ranking(search), _gains(search.best), _conclusion(search)


def _ranking(search: LawSearch) -> Table:
    return Table(
        columns=(
            *text_columns(["", "law"]),
            Column("gains", align="left"),
            Column("delay", "samples"),
            Column("held-out", "%"),
            Column("own", "%"),
        ),
        rows=tuple(
            (
                str(i),
                each.title,
                ", ".join(each.law.gains),
                str(each.law.delay),
                figure_text(each.held_out_percent),
                figure_text(each.fitted_percent),
            )
            for i, each in enumerate(search.laws[:_MOST], 1)
        ),
        labels=2,
        title="Ready laws by what they leave of the control, of held-out and of their own rows",
    )


def _gains(best: ExplainedLaw) -> Table:
    return Table(
        columns=(*text_columns([best.title]), Column("value"), Column("sd")),
        rows=tuple(
            (
                name,
                f"{value:.6g}",
                f"{best.deviations[name]:.2g}" if name in best.deviations else "not shown",
            )
            for name, value in best.law.gains.items()
        ),
    )


def _conclusion(search: LawSearch) -> Paragraph:
    best = search.best
    if not search.explained:
        return paragraph(f"{search.checks[0].meaning}.", filled=False)
    others = search.as_well - 1
    more = f"{others} other{'s' * (others > 1)} with more gains" if others else ""
    lines = [f"The control is explained as well by {more}."] if more else []
    lines += [f"The same control gives {best.same}."] if best.same else []
    lines += [f"in TOML:   {best.toml}"]
    said = Sentence(lead="declare: ", text=best.python, filled=False)
    return paragraph(*lines, said, filled=False)
