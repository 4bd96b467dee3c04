"""``axisid fleet``: identify many logs separately."""

import os
from pathlib import Path

import click

from axisid.commands.options import (
    Command,
    Filtering,
    Reading,
    bounded_option,
    check_folder,
    complete_axis,
    complete_file,
    fix_option,
    force_option,
    leave_out_option,
    loss_option,
    method_option,
    print_result,
    progress_line,
    stages,
    takes,
)
from axisid.support.errors import EstimationError


@click.command(
    cls=Command,
    short_help="Identify many logs separately.",
    epilog="Example: axisid fleet logs/*.csv --axis stage.toml --jobs 8 --resume, or "
    "axisid fleet manifest.csv --output results --time-limit 60",
)
@click.argument("logs", nargs=-1, required=True, shell_complete=complete_file)
@click.option(
    "--axis",
    shell_complete=complete_axis,
    metavar="AXIS",
    help="Axis of every log whose axis is not given in a manifest: a name in the library, or a "
    "file.",
)
@click.option(
    "--output",
    metavar="DIR",
    default="results",
    show_default=True,
    help="Folder for the results.",
)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    metavar="N",
    help="Number of processes.  [default: the number of processor cores]",
)
@click.option(
    "--time-limit",
    type=click.FloatRange(0.0, min_open=True),
    metavar="S",
    help="Time limit for one log, s. A log that takes longer fails. The fleet continues with the "
    "next log.  [default: none]",
)
@click.option(
    "--resume",
    is_flag=True,
    help="Keep existing results of the same log, axis and options. Identify only logs that have no "
    "such result.",
)
@takes("filtering", Filtering)
@takes("reading", Reading)
@method_option
@loss_option
@bounded_option
@fix_option(
    "Known value of a parameter in all logs, SI. Add +-SD, the standard deviation, to an uncertain "
    "value. Can be repeated."
)
@leave_out_option(has_fix=True)
@force_option
def fleet(
    logs: tuple[str, ...],
    axis: str | None,
    output: str,
    jobs: int | None,
    time_limit: float | None,
    resume: bool,
    filtering: Filtering,
    reading: Reading,
    methods: tuple[str, ...],
    loss: str,
    bounded: bool,
    fix: tuple[str, ...],
    left_out: tuple[str, ...],
    force: bool,
) -> None:
    """Identify an axis from each of many LOGS separately, and report outliers among the logs.

    LOGS are files (a log, or a run.toml that describes a log), folders, quoted patterns such as
    'logs/**/*.csv', and manifests. Subfolders of a folder are included.

    A manifest is a CSV or Parquet table with one row for each log. The column `log` names the log.
    The columns `axis`, `serial` and `columns` are optional. All further columns are conditions,
    which are copied into the table of the fleet. A manifest can also lie in one of the folders.

    Each log gets a result NAME.json, in the format of `axisid identify --json`, and a line in
    fleet.jsonl. The table of all logs is fleet.parquet (fleet.csv without pyarrow). A log that
    cannot be used, takes too long or crashes its process is reported with the reason. The fleet
    then continues with the next log.
    """
    prefilter = filtering.prefilter()  # refused before anything is read

    items = stages.gather_items(logs, Path(output))
    check_folder(output, "--output", stages.written_files(items), force=force)
    affinity = getattr(os, "sched_getaffinity", None)  # not on macOS and Windows
    cores = len(affinity(0)) if affinity is not None else os.cpu_count() or 1
    try:
        with progress_line(f"identifying {len(items)} logs") as line:
            result = stages.fleet(
                items,
                axis,
                output,
                jobs=jobs or cores,
                time_limit=time_limit,
                resume=resume,
                prefilter=prefilter,
                fixed=stages.read_fixed(fix),
                left_out=left_out,
                reading=reading.settings(),
                progress=line,
                methods=None if "all" in methods else methods,
                bounded=bounded,
                loss=loss,
            )
    except KeyboardInterrupt:
        if Path(output).exists():
            click.echo(
                f"axisid: the results of the finished logs are in {output}. Run the command again "
                "with --resume to identify the other logs.",
                err=True,
            )
        raise
    print_result(result)
    click.echo(f"wrote {result.write()}")
    if result.failed:
        count = len(result.failed)
        raise EstimationError(
            f"{count} of {len(result)} logs {'has' if count == 1 else 'have'} no result. The "
            "reasons are above and in fleet.jsonl.",
            code="fleet",
        )
