"""``axisid law``: find the control law of a record."""

import click

from axisid.commands.options import (
    Command,
    Reading,
    Sharing,
    Target,
    axis_and_records,
    check_targets,
    complete_axis,
    complete_file,
    force_option,
    json_option,
    progress_line,
    put_result,
    stages,
    takes,
)


@click.command(
    cls=Command,
    short_help="Find the control law of a record.",
    epilog="Examples: axisid law emps2015, or axisid law emps DATA_EMPS.mat --json law.json",
)
@click.argument("axis", shell_complete=complete_axis)
@click.argument("record", required=False, shell_complete=complete_file)
@takes("reading", Reading)
@json_option
@force_option
def law(
    axis: str,
    record: str | None,
    reading: Reading,
    json_file: str | None,
    force: bool,
) -> None:
    """Find the built-in control law that explains a RECORD of AXIS.

    Without a RECORD, a simulated record of the axis (its twin) is used.

    The gains and the delay of each built-in law are estimated from half of the rows. The laws are
    compared by their residual on the other half of the rows. A control law that AXIS declares is
    ignored.
    """
    logs = () if record is None else (record,)
    check_targets([Target("--json", json_file, "law")], (*logs, axis), force=force)
    inputs = axis_and_records(axis, logs, reading, Sharing(local=(), known={}))
    with progress_line(f"finding the law of {inputs.axis.axis.name}") as line:
        result = stages.find_law(inputs.axis, inputs.records[0], progress=line)
    put_result(result, json_file)
