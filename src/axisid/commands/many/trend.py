"""``axisid trend``."""

from pathlib import Path

import click

from axisid.commands.options import (
    Command,
    Target,
    check_targets,
    complete_file,
    force_option,
    json_option,
    put_json,
    stages,
)
from axisid.presentation.console import ProgressLine, print_document


@click.command(
    cls=Command,
    short_help="Follow parameters over results.",
    epilog="Example: axisid identify emps2015 --json a.json && axisid trend a.json, or "
    "axisid trend results --by date --report trend.html --csv trend.csv",
)
@click.argument("results", nargs=-1, required=True, shell_complete=complete_file)
@click.option(
    "--by",
    metavar="CONDITION",
    help="What orders the results: a column of a fleet's manifest with numbers or dates.  "
    "[default: the order in which they are named]",
)
@click.option(
    "--method", metavar="METHOD", help="Whose estimates are taken.  [default: the judged one]"
)
@click.option(
    "--count-failing",
    is_flag=True,
    help="Let results whose verdict fails set limits and tell changes like the others.",
)
@click.option("--csv", "table", metavar="FILE", help="Write a row for each value of each result.")
@click.option("--report", metavar="FILE", help="Write a page of HTML with a figure of each series.")
@json_option("Write the trend as JSON; - for stdout.")
@force_option
def trend(
    results: tuple[str, ...],
    by: str | None,
    method: str | None,
    count_failing: bool,
    table: str | None,
    report: str | None,
    json_file: str | None,
    force: bool,
) -> None:
    """Follow the parameters of axes over RESULTS, and tell what changed.

    RESULTS are files that identify --json or fit --json wrote, and folders of them, such as those
    of a fleet.
    Results of one axis and serial number are a series: control limits are from the results'
    deviations and the scatter between them; results beyond the limits and steps are told.
    """
    targets = (
        Target("--csv", table, "trend-table", (".csv",)),
        Target("--report", report, "report", (".html",)),
        Target("--json", json_file, "trend"),
    )
    check_targets(targets, results, force=force)

    with ProgressLine("reading results"):
        result = stages.trend(results, by=by, method=method, count_failing=count_failing)
    for file in filter(None, (table, report)):
        click.echo(f"wrote {result.write(Path(file))}", err=json_file == "-")
    if json_file is not None:
        put_json(json_file, result.to_dict())
    if json_file != "-":
        print_document(result.document())
