"""``axisid trend``: report changes of parameters over many results."""

import click

from axisid.commands.options import (
    Command,
    Target,
    check_targets,
    complete_file,
    force_option,
    json_option,
    progress_line,
    put_result,
    stages,
)


@click.command(
    cls=Command,
    short_help="Show the trend of parameters over results.",
    epilog="Example: axisid identify emps2015 --json a.json && axisid trend a.json, or "
    "axisid trend results --by date --report trend.html --csv trend.csv",
)
@click.argument("results", nargs=-1, required=True, shell_complete=complete_file)
@click.option(
    "--by",
    metavar="CONDITION",
    help="Order the results by this column of the manifest of a fleet. The column must have "
    "numbers or dates.  [default: the order of RESULTS]",
)
@click.option(
    "--method",
    metavar="METHOD",
    help="Method whose estimates are used.  [default: the method that the verdict judges]",
)
@click.option(
    "--count-failing",
    is_flag=True,
    help="Also use results with a failed check to compute the limits and to find changes. Without "
    "this option, such results are shown but not used.",
)
@click.option(
    "--csv",
    "table",
    metavar="FILE",
    help="Write a CSV table with a row for each parameter of each result.",
)
@click.option("--report", metavar="FILE", help="Write an HTML page with a figure of each series.")
@json_option
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
    """Show the trend of the parameters of axes over RESULTS, and report changes.

    RESULTS are files that `axisid identify --json` or `axisid fit --json` wrote, and folders of
    such files, for instance of `axisid fleet`.

    Results with the same axis and serial number form a series. Each series has a control chart for
    every parameter. The limits of the chart come from the standard errors of the results and from
    the scatter between the results. Results outside the limits, steps and drifts are reported.
    """
    check_targets(
        [
            Target("--csv", table, "trend-table", (".csv",)),
            Target("--report", report, "report", (".html",)),
            Target("--json", json_file, "trend"),
        ],
        results,
        force=force,
    )

    with progress_line("reading results"):
        result = stages.trend(results, by=by, method=method, count_failing=count_failing)
    ways = [(place, lambda file: [result.write(file)]) for place in (table, report)]
    put_result(result, json_file, *ways)
