"""The paper's study on its twin: both filters, all four methods, tables 1 to 8, figures 3 and 4.

The published figures stand beside the twin's. The twin has the paper's parameters, gains and
noise; its motion and its velocity sensor are ours, so the two agree in kind, not digit by digit.
The published tables have one record and one noise; of many twins under both filters bias, scatter
and coverage stand with their Monte-Carlo errors.
"""

import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from axisid.codegen.artefacts import build
from axisid.estimation.estimates import Estimate, Value
from axisid.estimation.identification import Identification, identify
from axisid.estimation.monte_carlo import MonteCarlo, monte_carlo
from axisid.estimation.signals import Prefilter
from axisid.estimation.simulation import twin_record
from axisid.modeling.text import load_axis
from axisid.presentation.blocks import (
    Cell,
    Column,
    Document,
    Quantity,
    Table,
    block_text,
    paragraph,
    plain_text,
    text_columns,
)
from axisid.presentation.saved import study_facts
from axisid.presentation.text import estimand_tables, findings, legend
from axisid.support.errors import EstimationError, UsageError
from axisid.support.files.json_text import json_text
from axisid.support.files.regular_file import replace_file
from axisid.support.progress import Progress, with_progress

#: The paper's four methods.
METHODS = ("idm-ls", "ddm-ls", "idm-iv", "ddm-iv")
#: The paper's two filters.
APPROPRIATE = Prefilter(cutoff=60.0, decimate=10, drop=(50, 50), hold="raw", reversals="keep")
INAPPROPRIATE = Prefilter(cutoff=180.0, decimate=3, drop=(50, 50), hold="raw", reversals="keep")
_NOTES = """\
The twin's viscous friction comes out low because force and motion are paired as in the paper (hold
raw): the force acts half a sample late. With hold zoh and the appropriate filter it comes within
1 % of the truth.
paper: Brunot et al., SYSID 2015. The twin's motion is ours, so figures agree in kind, not by digit.
rel. sd: i.i.d., delta method where mapped. error of LS: ||y - X theta||/||y||; error of IV:
||y - y_simulated||/||y||, the loop simulated with the estimate (the published IV figures can be no
other: on the same X no estimate has a smaller equation error than LS). The error of DDM-IV is
taken against the measured acceleration, whose own noise the inappropriate filter lets through.
Table 7: the published column of DDM-LS cannot come from the rows of table 6. On one set of rows,
M of IDM-LS times theta1 of DDM-LS is r^2, the squared partial correlation of force and
acceleration; an equation error of 48.7 % leaves r^2 at most 1 - 0.487^2 = 0.763. With M = 54.9,
theta1 is at most 0.0139, and the M of table 8 at least 72, whatever the noise, derivative, filter
or delay. The column is twice that of table 2: 0.02, 4.64, 0.46 for 0.01, 2.32, 0.23."""
#: What `write_study` writes, and of which kind it is.
STUDY_FILES = {
    "tables.txt": "paper",
    "appropriate.json": "identify",
    "inappropriate.json": "identify",
    "figure3.png": "figure",
    "figure4.png": "figure",
}
#: The filters by name, as files are named for them.
FILTERS = {"appropriate": APPROPRIATE, "inappropriate": INAPPROPRIATE}
#: What `write_distributions` writes, and of which kind it is.
DISTRIBUTION_FILES = {
    "distributions.txt": "paper-distributions",
    **{f"distributions_{name}.json": "study" for name in FILTERS},
}


@cache
def published_tables(kind: str) -> dict[int, dict[str, Any]]:
    """The paper's tables of a kind by their numbers: estimates, mapped or iterations."""
    text = (resources.files("axisid.paper") / "published.toml").read_text(encoding="utf-8")
    return {table["number"]: table for table in tomllib.loads(text)[kind]}


@dataclass(frozen=True, slots=True)
class Study:
    """The twin identified under both filters."""

    appropriate: Identification
    inappropriate: Identification

    def under(self, *, appropriate: bool) -> Identification:
        """The identification under one filter."""
        return self.appropriate if appropriate else self.inappropriate


def run_study(progress: Progress | None = None) -> Study:
    """Identify the twin of `emps2015` by the paper's methods under both filters."""
    axis = build(load_axis("emps2015"))
    record = twin_record(axis)
    filters = with_progress(
        (APPROPRIATE, INAPPROPRIATE), progress, lambda f: f"filter of {f.cutoff:g} Hz"
    )
    return Study(
        *(identify(axis, record, prefilter, METHODS, start="nominal") for prefilter in filters)
    )


def study_document(study: Study) -> Document:
    """The paper's tables in its order, each with the published figures beside the twin's."""
    record = study.appropriate.record
    made = f"{record.provenance.source}, {len(record)} samples of {1e3 * record.period:g} ms"
    return (
        paragraph(made, f"true values: {_truth(study)}", filled=False),
        *(study_table(study, number) for number in range(1, 9)),
        paragraph(*_NOTES.splitlines(), filled=False),
    )


def table_text(study: Study, number: int) -> str:
    """One of the paper's tables, 1 to 8, as plain text."""
    return block_text(study_table(study, number))


def study_table(study: Study, number: int) -> Table:
    """One of the paper's tables, 1 to 8, with the published figures beside the twin's."""
    for kind, written in (("mapped", _mapped), ("iterations", _iterations)):
        if number in published_tables(kind):
            return written(study, published_tables(kind)[number])
    return _estimates(study, published_tables("estimates")[number])


def write_study(study: Study, folder: Path) -> list[Path]:
    """Write tables, figures and both results into a folder.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    from axisid.presentation.drawing import force_figure

    texts = {
        "tables.txt": plain_text(study_document(study)),
        "appropriate.json": json_text(study.appropriate.to_dict()),
        "inappropriate.json": json_text(study.inappropriate.to_dict()),
    }
    figures = {
        "figure3.png": (study.appropriate["idm-iv"], "IDM-IV, appropriate filter (figure 3)"),
        "figure4.png": (study.inappropriate["idm-ls"], "IDM-LS, inappropriate filter (figure 4)"),
    }

    def drawn() -> list[Path]:
        for name, (estimate, title) in figures.items():
            force_figure(estimate, title, folder / name)
        return [folder / name for name in figures]

    return written_into(folder, texts, drawn)


def written_into(
    folder: Path, texts: Mapping[str, str], draw: Callable[[], list[Path]]
) -> list[Path]:
    """Write a study's texts by their names, and then its figures, into a folder.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            replace_file(folder / name, text)
        return [*(folder / name for name in texts), *draw()]
    except OSError as error:
        raise UsageError(f"{folder} cannot be written to: {error.strerror}.") from error


def _truth(study: Study) -> str:
    axis = study.appropriate.axis.axis
    truth = axis.experiment.truth if axis.experiment else {}
    return ", ".join(f"{p.name} = {truth[p.name]:g} {p.unit}" for p in axis.parameters)


def _error(estimate: Estimate) -> float:
    """The error that the published tables can mean: simulated for IV, of the equation for LS."""
    if not estimate.iterates:
        return estimate.equation_error_percent
    if estimate.simulation_error_percent is None:
        raise EstimationError(f"{estimate.method} has no simulation error.")
    return estimate.simulation_error_percent


def _estimates(study: Study, table: dict[str, Any]) -> Table:
    result = study.under(appropriate=table["appropriate"])
    methods = table["methods"]
    columns = [Column(m.upper(), parts=("rel. sd", "paper", "rel. sd")) for m in methods]
    estimates = [result[method] for method in methods]
    values = [list((e.ddm_parameters or e.parameters).items()) for e in estimates]
    rows: list[tuple[Cell, ...]] = []
    for i, (name, first) in enumerate(values[0]):
        of_methods = zip(values, table["published"], strict=True)
        cells = (_beside(column[i][1], *published[i]) for column, published in of_methods)
        rows.append((name, first.unit, *cells))
    errors = zip(estimates, table["errors"], strict=True)
    cells = (Quantity(f"{_error(estimate):.1f}", "", (f"{paper:g}",)) for estimate, paper in errors)
    rows.append(("error", "%", *cells))
    return _titled(table["number"], table["title"], columns, rows)


def _mapped(study: Study, table: dict[str, Any]) -> Table:
    published, result = table["published"], study.under(appropriate=table["appropriate"])
    methods = ("ddm-ls", "ddm-iv")
    columns = [Column(method.upper(), parts=("rel. sd", "paper")) for method in methods]
    rows: list[tuple[Cell, ...]] = []
    for i, quantity in enumerate(result.axis.parameters):
        values = [result[method].parameters[quantity.name] for method in methods]
        cells = (_beside(v, paper[i]) for v, paper in zip(values, published, strict=True))
        rows.append((quantity.name, quantity.unit, *cells))
    which = "appropriate" if table["appropriate"] else "inappropriate"
    title = f"DDM mapped to physical parameters, {which} filter"
    return _titled(table["number"], title, columns, rows)


def _beside(value: Value, paper: float, paper_sd: float | None = None) -> Quantity:
    """A value with its relative deviation, and the published ones."""
    published = [f"{paper:g}", *([] if paper_sd is None else [f"{paper_sd:g} %"])]
    relative = f"{value.relative_sd_percent:.1f} %"
    return Quantity(_significant(value.value), relative, tuple(published))


def _iterations(study: Study, table: dict[str, Any]) -> Table:
    method, published = table["method"], table["published"]
    estimate = study.appropriate[method]
    labels = [
        f"{q.name} [{q.unit}]" for q in estimate.ddm_quantities or study.appropriate.axis.parameters
    ]
    steps = range(max(len(estimate.iterates), len(published)))
    columns = [Column(head, group=str(step)) for step in steps for head in (str(step), "paper")]
    rows: list[tuple[Cell, ...]] = []
    for i, label in enumerate([*labels, "error [%]"]):
        row = [label]
        for step in steps:
            ours = estimate.iterates[step] if step < len(estimate.iterates) else None
            values = [] if ours is None else [*ours.theta, ours.simulation_error_percent]
            row.append(_significant(values[i]) if values else "")
            row.append(f"{published[step][i]:g}" if step < len(published) else "")
        rows.append(tuple(row))
    return Table(
        columns=(*text_columns(["iteration"]), *columns),
        rows=tuple(rows),
        title=f"Table {table['number']}. {method.upper()} by iteration, appropriate filter",
    )


def _significant(value: float) -> str:
    """Four significant digits, never in exponent form for table-sized numbers."""
    return f"{value:#.4g}".rstrip(".") if value else "0"


def _titled(
    number: int, title: str, columns: Iterable[Column], rows: Iterable[tuple[Cell, ...]]
) -> Table:
    return Table(
        columns=(*text_columns(["", "unit"]), *columns),
        rows=tuple(rows),
        labels=2,
        title=f"Table {number}. {title}",
    )


def run_distributions(
    runs: int, *, seed: int = 1, jobs: int = 1, progress: Progress | None = None
) -> dict[str, MonteCarlo]:
    """Identify many twins of `emps2015` by all methods of the tables, by filter.

    Parameters
    ----------
    runs : int
        Twins; under both filters the same ones.
    seed, jobs
        As in `monte_carlo`.
    progress : callable, optional

    Raises
    ------
    UsageError
        As `monte_carlo`.
    """
    axis = build(load_axis("emps2015"))
    return {
        name: monte_carlo(
            axis,
            runs,
            METHODS,
            prefilter=prefilter,
            start="nominal",
            seed=seed,
            jobs=jobs,
            progress=progress,
        )
        for name, prefilter in FILTERS.items()
    }


def distributions_document(found: Mapping[str, MonteCarlo]) -> Document:
    """The estimates of every method and filter, and what stands out."""
    blocks: Document = ()
    studies = {name: study_facts(result) for name, result in found.items()}
    for name, result in studies.items():
        title = f"{len(result)} twins, {name} filter, {FILTERS[name].cutoff:g} Hz"
        blocks = *blocks, *estimand_tables(result, title), findings(result)
    return *blocks, *(legend(result) for result in [*studies.values()][:1])


def write_distributions(found: Mapping[str, MonteCarlo], folder: Path) -> list[Path]:
    """Write the tables and the figures of both filters into a folder.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    texts = {
        "distributions.txt": plain_text(distributions_document(found)),
        **{
            f"distributions_{name}.json": json_text(result.to_dict())
            for name, result in found.items()
        },
    }
    return written_into(folder, texts, list)
