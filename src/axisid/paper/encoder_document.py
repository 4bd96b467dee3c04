"""What the study of encoders looks like: tables, a figure, files."""

from pathlib import Path

import numpy as np

from axisid.presentation.blocks import (
    Cell,
    Column,
    Document,
    Quantity,
    Table,
    paragraph,
    plain_text,
    text_columns,
)
from axisid.presentation.plots import Panel, Plot, Series, Tone
from axisid.support.arrays import Array
from axisid.support.files.json_text import json_text

from .encoder import CONTROL_FIT, FILTERS, METHODS, EncoderCase, EncoderStudy, MethodFigures
from .study import written_into

#: What `write_encoder_study` writes, and of which kind it is.
ENCODER_FILES = {
    "encoder.txt": "paper",
    "encoder.json": "paper",
    **{f"encoder_{name}.png": "figure" for name in FILTERS},
}
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
_NOTES = """\
bias, sd: mean error and scatter over the twins of the value without its bias, percent of
the true value. held: share of the 95 % intervals that hold it. estimates: share of the twins that a
method gives one of; no error is told of fewer than two. The encoder rounds inside the loop and in
the record; the motion begins anywhere in a count. The law's velocity is an ideal sensor's. clie:
fit of the control (axisid fit), which passes no filter and is the same under both."""


def encoder_document(study: EncoderStudy) -> Document:
    """A table of errors and one of verdicts for each filter."""
    tables = [table(study, name) for name in FILTERS for table in (_errors_table, _verdicts_table)]
    made = f"{study.runs} twins of each encoder, screw of 20 mm a revolution"
    return paragraph(made, filled=False), *tables, paragraph(*_NOTES.splitlines(), filled=False)


def _errors_table(study: EncoderStudy, name: str) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for case in study.under(name):
        for i, parameter in enumerate(study.names):
            label = "" if i else str(case.counts)
            cells = (_quantity(made, i) for made in case.methods.values())
            rows.append((label, parameter, *cells))
    return Table(
        columns=(
            *text_columns(["counts", "%"]),
            *(Column(method.upper(), parts=("sd", "held", "estimates")) for method in SHOWN),
        ),
        rows=tuple(rows),
        labels=2,
        title=f"{_titled(name)}: bias by method",
    )


def _quantity(made: MethodFigures, i: int) -> Quantity:
    """Of a parameter; how many estimates there are is told with the first."""
    estimated = "" if i else _share(made.estimated)
    return Quantity(
        _figure(made.bias[i]), _figure(made.scatter[i]), (_share(made.held[i]), estimated)
    )


def _verdicts_table(study: EncoderStudy, name: str) -> Table:
    def objections(case: EncoderCase) -> str:
        first = list(case.objected.items())[:_MOST_OBJECTIONS]
        return ", ".join(f"{check} {_share(share)}" for check, share in first)

    rows = tuple(
        (str(case.counts), _share(case.judged), _share(case.clean), objections(case))
        for case in study.under(name)
    )
    return Table(
        columns=(
            *text_columns(["counts"]),
            Column("judged", "%"),
            Column("nothing fails", "%"),
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
                Series(
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


def write_encoder_study(study: EncoderStudy, folder: Path) -> list[Path]:
    """Write tables, figures and figures as data into a folder.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    from axisid.presentation.drawing import write_figures

    texts = {
        "encoder.txt": plain_text(encoder_document(study)),
        "encoder.json": json_text(encoder_dict(study)),
    }
    plots = [encoder_plot(study, name) for name in FILTERS]
    return written_into(folder, texts, lambda: write_figures(plots, folder, "png"))


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
