"""``axisid law``."""

import click

from axisid.commands.options import (
    Command,
    Reading,
    Target,
    axis_and_records,
    check_targets,
    complete_axis,
    complete_file,
    force_option,
    json_option,
    put_result,
    stages,
    takes,
)
from axisid.presentation.console import ProgressLine


@click.command(
    cls=Command,
    short_help="Find the control law of a record.",
    epilog="Examples: axisid law emps2015, or axisid law emps DATA_EMPS.mat --json law.json",
)
@click.argument("axis", shell_complete=complete_axis)
@click.argument("record", required=False, shell_complete=complete_file)
@takes("reading", Reading)
@json_option("Write the result as JSON; - for stdout.")
@force_option
def law(
    axis: str,
    record: str | None,
    reading: Reading,
    json_file: str | None,
    force: bool,
) -> None:
    """Find which of the ready laws explains the control of a RECORD of AXIS, or of its twin.

    Of each the gains and the delay are found from half of the rows, and it is judged by what it
    leaves of the others. The law that AXIS declares, if it does, plays no part.
    """
    logs = () if record is None else (record,)
    check_targets([Target("--json", json_file, "law")], (*logs, axis), force=force)
    inputs = axis_and_records(axis, logs, reading)

    generated, data = inputs.axis, inputs.records[0]
    with ProgressLine(f"finding the law of {generated.axis.name}") as line:
        result = stages.find_law(generated, data, progress=line)
    put_result(result, json_file)
