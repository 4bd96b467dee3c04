"""Study of Brunot et al. (SYSID 2015) on a twin: two filters, four methods, tables and figures.

In: nothing, or the number of twins. Out: published tables next to the tables of the twin, figures,
files. Knows nothing of other records, and of the command line.

The twin has the parameters, gains and noise of the paper. Its motion and its velocity sensor are
not published, so they differ, and the numbers agree qualitatively, not digit by digit. The
published tables are from one record with one noise. For many twins, bias, scatter and coverage
under both filters are given with their Monte-Carlo errors.
"""

import tomllib
from collections.abc import Mapping
from importlib import resources
from itertools import chain, zip_longest
from pathlib import Path
from typing import Any

from axisid.codegen.generated_axes import build
from axisid.estimation.estimates import Value
from axisid.estimation.identification import Identification, identify
from axisid.estimation.monte_carlo import MonteCarlo, monte_carlo
from axisid.estimation.signals import Prefilter
from axisid.estimation.simulation import twin_record
from axisid.modeling.parsing import load_axis
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
from axisid.presentation.result_files import written_study
from axisid.presentation.text import estimand_tables, findings, legend
from axisid.support.files import json_text, write_file
from axisid.support.progress import Progress, with_progress

#: The paper's four methods.
METHODS = ("idm-ls", "ddm-ls", "idm-iv", "ddm-iv")
#: The paper's two filters.
APPROPRIATE = Prefilter(cutoff=60.0, decimate=10, drop=(50, 50), hold="raw", reversals="keep")
INAPPROPRIATE = Prefilter(cutoff=180.0, decimate=3, drop=(50, 50), hold="raw", reversals="keep")
_NOTES = (
    "The viscous friction of the twin is estimated too low, because force and motion are paired "
    "as in the paper (hold raw): the force acts half a sample late. With hold zoh and the "
    "appropriate filter the estimate is within 1 % of the truth.",
    "paper: Brunot et al., SYSID 2015. The motion of the twin is ours, so the figures agree "
    "qualitatively, not digit by digit.",
    "rel. sd: relative standard error, i.i.d., by the delta method for mapped parameters. error "
    "of LS: ||y - X theta||/||y||. error of IV: ||y - y_simulated||/||y|| with the loop simulated "
    "with the estimate. The published IV figures must have this meaning, because for the same X "
    "no estimate has a smaller equation error than LS. The error of DDM-IV is relative to the "
    "measured acceleration, whose noise passes the inappropriate filter.",
    "Table 7: the published column of DDM-LS cannot come from the rows of table 6. On one set of "
    "rows, M of IDM-LS times theta1 of DDM-LS is r^2, the squared partial correlation of force "
    "and acceleration. With an equation error of 48.7 %, r^2 is at most 1 - 0.487^2 = 0.763. With "
    "M = 54.9, theta1 is then at most 0.0139, and the M of table 8 at least 72, for any noise, "
    "derivative, filter or delay. The column is twice that of table 2: 0.02, 4.64, 0.46 instead of "
    "0.01, 2.32, 0.23.",
)
#: Files that `write_study` writes, with their kind as in `kinds_of`.
STUDY_FILES = {
    "tables.txt": "paper",
    "appropriate.json": "identify",
    "inappropriate.json": "identify",
    "figure3.png": "figure",
    "figure4.png": "figure",
}
#: The filters by name; the name is part of the names of files.
FILTERS = {"appropriate": APPROPRIATE, "inappropriate": INAPPROPRIATE}
#: Files that `write_distributions` writes, with their kind as in `kinds_of`.
DISTRIBUTION_FILES = {
    "distributions.txt": "paper-distributions",
    **{f"distributions_{name}.json": "study" for name in FILTERS},
}


def run_study(progress: Progress | None = None) -> dict[str, Identification]:
    """Return the identification of the twin of `emps2015` by four methods, by filter name."""
    axis = build(load_axis("emps2015"))
    record = twin_record(axis)
    filters = with_progress(FILTERS.items(), progress, lambda f: f"filter of {f[1].cutoff:g} Hz")
    return {n: identify(axis, record, f, METHODS, start="nominal", judge=False) for n, f in filters}


def study_document(study: Mapping[str, Identification]) -> Document:
    """Return tables 1 to 8, each with the published numbers next to the numbers of the twin."""
    record = study["appropriate"].record
    made = f"{record.provenance.source}, {len(record)} samples of {1e3 * record.period:g} ms"
    true, axis = record.provenance.truth, study["appropriate"].axis.axis
    values = ", ".join(f"{p.name} = {true[p.name]:g} {p.unit}" for p in axis.parameters)
    return (
        paragraph(made, f"true values: {values}"),
        *(study_table(study, number) for number in range(1, 9)),
        paragraph(*_NOTES),
    )


def study_table(study: Mapping[str, Identification], number: int) -> TableBlock:
    """Return a table of the paper, number 1 to 8, with published numbers next to the twin's."""
    text = (resources.files("axisid") / "published.toml").read_text(encoding="utf-8")
    published = tomllib.loads(text)
    (table,) = (t for each in published.values() for t in each if t["number"] == number)
    return _iterations(study, table) if "method" in table else _estimates(study, table)


def write_study(study: Mapping[str, Identification], folder: Path) -> list[Path]:
    """Write tables, figures and both results into a folder, and return the files.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    from axisid.presentation.matplotlib import force_figure

    write_file(folder / "tables.txt", plain_text(study_document(study)))
    for name, result in study.items():
        write_file(folder / f"{name}.json", json_text(result.to_dict()))
    least, instruments = study["inappropriate"]["idm-ls"], study["appropriate"]["idm-iv"]
    force_figure(instruments, "IDM-IV, appropriate filter (figure 3)", folder / "figure3.png")
    force_figure(least, "IDM-LS, inappropriate filter (figure 4)", folder / "figure4.png")
    return [folder / name for name in STUDY_FILES]


def _estimates(study: Mapping[str, Identification], table: dict[str, Any]) -> TableBlock:
    """Return a table of the estimates of several methods, next to the published estimates.

    `table` is the published table, from ``published.toml``.
    """
    result = study["appropriate" if table["appropriate"] else "inappropriate"]
    published, is_mapped = table["published"], table.get("mapped", False)
    estimates = [result[method] for method in table["methods"]]
    values = [
        list(((not is_mapped and e.ddm_parameters) or e.parameters).items()) for e in estimates
    ]
    rows: list[tuple[Cell, ...]] = []
    for i, (name, first) in enumerate(values[0]):
        cells = (
            _with_published(column[i][1], *paper[i])
            for column, paper in zip(values, published, strict=True)
        )
        rows.append((name, first.unit, *cells))
    if errors := table["errors"]:
        # The only possible meaning of the published errors: simulation for IV, equation for LS.
        own = (
            each.simulation_error_percent if each.iterates else each.equation_error_percent
            for each in estimates
        )
        cells = (
            QuantityCell(f"{error:.1f}", "", (f"{paper:g}",))
            for error, paper in zip(own, errors, strict=True)
        )
        rows.append(("error", "%", *cells))
    parts = ("rel. sd", "paper", "rel. sd")[: 1 + len(published[0][0])]
    return TableBlock(
        columns=(
            *text_columns(["", "unit"]),
            *(TableColumn(method.upper(), parts=parts) for method in table["methods"]),
        ),
        rows=tuple(rows),
        labels=2,
        title=f"Table {table['number']}. {table['title']}",
    )


def _with_published(value: Value, paper: float, paper_sd: float | None = None) -> QuantityCell:
    """Return a value and its relative standard error, next to the published ones if given."""
    published = [f"{paper:g}", *([] if paper_sd is None else [f"{paper_sd:g} %"])]
    return QuantityCell(
        _significant(value.value), f"{value.relative_sd_percent:.1f} %", tuple(published)
    )


def _iterations(study: Mapping[str, Identification], table: dict[str, Any]) -> TableBlock:
    """Return a table of the iterations of one method, next to the published iterations.

    `table` is the published table, from ``published.toml``.
    """
    method, published = table["method"], table["published"]
    estimate = study["appropriate"][method]
    labels = [
        f"{q.name} [{q.unit}]"
        for q in estimate.ddm_quantities or study["appropriate"].axis.parameters
    ]
    lines = [*labels, "error [%]"]
    ours = [[*map(_significant, (*i.theta, i.simulation_error_percent))] for i in estimate.iterates]
    papers = [[f"{figure:g}" for figure in step] for step in published]
    # Two columns for each iteration; the shorter of the two lists is filled with empty columns.
    steps = [*zip_longest(ours, papers, fillvalue=[""] * len(lines))]
    columns = (
        TableColumn(head, group=str(step))
        for step in range(len(steps))
        for head in (str(step), "paper")
    )
    return TableBlock(
        columns=(*text_columns(["iteration"]), *columns),
        rows=tuple(zip(lines, *chain(*steps), strict=True)),
        title=f"Table {table['number']}. {method.upper()} by iteration, appropriate filter",
    )


def _significant(value: float) -> str:
    """Return a number with four significant digits, as text."""
    return f"{value:#.4g}".rstrip(".") if value else "0"


def run_distributions(
    runs: int, *, seed: int = 1, jobs: int = 1, progress: Progress | None = None
) -> dict[str, MonteCarlo]:
    """Return the Monte-Carlo study of `emps2015` by four methods, by name of the filter.

    Parameters
    ----------
    runs : int
        Number of twins, which are the same for both filters.
    seed, jobs
        As in `monte_carlo`.
    progress : callable, optional
        As in `monte_carlo`.

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
    """Return the studies of both filters as tables of estimates, with their findings."""
    studies = {name: written_study(result) for name, result in found.items()}
    return (
        *(
            block
            for name, study in studies.items()
            for title in [f"{len(study)} twins, {name} filter, {FILTERS[name].cutoff:g} Hz"]
            for block in (*estimand_tables(study, title), findings(study))
        ),
        *(legend(study) for study in [*studies.values()][:1]),
    )


def write_distributions(found: Mapping[str, MonteCarlo], folder: Path) -> list[Path]:
    """Write the tables and the results of both filters into a folder, and return the files.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    write_file(folder / "distributions.txt", plain_text(distributions_document(found)))
    for name, result in found.items():
        write_file(folder / f"distributions_{name}.json", json_text(result.to_dict()))
    return [folder / name for name in DISTRIBUTION_FILES]
