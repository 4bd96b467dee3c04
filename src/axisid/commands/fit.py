"""``axisid fit``."""

import click

from axisid.commands.options import (
    Command,
    Fitting,
    Reading,
    Sharing,
    Target,
    axis_and_records,
    check_targets,
    complete_axis,
    complete_file,
    force_option,
    json_option,
    leave_out_option,
    put_result,
    stages,
    takes,
    write_page,
)
from axisid.presentation.console import ProgressLine


@click.command(
    cls=Command,
    short_help="Fit a simulated output to the recorded one.",
    epilog="Examples: axisid fit emps2015, or "
    "axisid fit emps DATA_EMPS.mat --prior M=95+-2 --json fit.json, or "
    "axisid fit stage.py empty.csv loaded.csv --local tau0 --bound Fv=0..",
)
@click.argument("axis", shell_complete=complete_axis)
@click.argument("record", nargs=-1, shell_complete=complete_file)
@takes("asked", Fitting)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Of further starts.",
)
@takes("reading", Reading)
@takes("sharing", Sharing)
@click.option(
    "--fix",
    multiple=True,
    metavar="NAME=VALUE[+-SD]",
    help="A parameter that is held, SI, or weighed where it has a standard deviation; again for "
    "each.",
)
@leave_out_option
@json_option("Write the result as JSON; - for standard output.")
@click.option("--report", metavar="FILE", help="Write a page of HTML: verdict, table, figures.")
@force_option
def fit(
    axis: str,
    record: tuple[str, ...],
    asked: Fitting,
    seed: int,
    reading: Reading,
    sharing: Sharing,
    fix: tuple[str, ...],
    left_out: tuple[str, ...],
    json_file: str | None,
    report: str | None,
    force: bool,
) -> None:
    """Fit AXIS to one RECORD or several (or to its twin) by output error, without a filter.

    The closed loop is simulated from the reference, as the record starts, until its control (or
    its position) is the recorded one as nearly as the model allows. Noise of the encoder biases
    nothing; the control law must be the drive's, which is checked.
    """
    targets = [Target("--json", json_file, "fit"), Target("--report", report, "report")]
    check_targets(targets, (*record, axis), force=force)
    inputs = axis_and_records(
        axis,
        record,
        reading,
        fixed=fix,
        left_out=left_out,
        skip_bad=sharing.skip_bad,
    )
    shared = sharing.of(inputs, len(record))
    inputs.say_set_aside()

    with ProgressLine(f"fitting {inputs.axis.axis.name}") as line:
        result = stages.fit(
            inputs.axis,
            inputs.records,
            progress=line,
            seed=seed,
            **asked.arguments(),
            **shared,
        )
    put_result(result, json_file)
    if report is not None:
        write_page(report, stages.fit_report_html, result)
        click.echo(f"wrote {report}", err=json_file == "-")
