"""``axisid fit``: fit the simulated loop to records."""

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
    progress_line,
    put_result,
    stages,
    takes,
    write_page,
)


@click.command(
    cls=Command,
    short_help="Fit the simulated loop to a record.",
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
    help="Seed of the random start values of --starts.",
)
@takes("reading", Reading)
@takes("sharing", Sharing)
@click.option(
    "--fix",
    multiple=True,
    metavar="NAME=VALUE[+-SD]",
    help="Fix a parameter at this value, SI. With +-SD, the standard deviation of the value, the "
    "option does the same as --prior: the parameter is fitted. Can be repeated.",
)
@leave_out_option(has_fix=True)
@json_option
@click.option(
    "--report", metavar="FILE", help="Write an HTML page with verdict, table and figures."
)
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
    """Fit AXIS to one or several RECORDs by output error, without a filter.

    Without a RECORD, a simulated record of the axis (its twin) is used.

    The closed loop is simulated from the recorded reference and initial state. The search changes
    the parameters until the simulated control (or another --output) is as close to the record as
    possible. Encoder noise causes no bias.

    The declared control law must be exact for the outputs control, position and force. The output
    position is the most sensitive to an error of the law. The output open-loop needs no law. A
    check compares the declared law with the record.

    Ctrl-C ends the search: the best values so far are printed and written, and the exit code is
    130.
    """
    check_targets(
        [Target("--json", json_file, "fit"), Target("--report", report, "report")],
        (*record, axis),
        force=force,
    )
    inputs = axis_and_records(axis, record, reading, sharing, fixed=fix, left_out=left_out)
    inputs.say_set_aside()

    with progress_line(f"fitting {inputs.axis.axis.name}") as line:
        result = stages.fit(
            inputs.axis,
            inputs.records,
            progress=line,
            seed=seed,
            **asked.arguments(),
            **inputs.shared,
        )
    put_result(
        result,
        json_file,
        (report, lambda file: write_page(file, stages.fit_report_html, result)),
    )
    if result.interrupted:
        raise KeyboardInterrupt
