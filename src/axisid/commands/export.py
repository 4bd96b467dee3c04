"""``axisid export``: write an identified axis as code or as a table."""

import click

from axisid.commands.options import (
    Command,
    Target,
    check_targets,
    complete_axis,
    complete_file,
    force_option,
    stages,
    write_output,
)
from axisid.estimation.choices import method_names
from axisid.export_targets import TARGETS

_NAMES = tuple(target.name for target in TARGETS)


_LANGUAGES = [target.language for target in TARGETS if target.language]
_CODE = [target.name for target in TARGETS if target.language]
_FILES = [target.name for target in TARGETS if not target.language]


@click.command(
    cls=Command,
    short_help="Export an identified axis as code or as a table.",
    epilog="Example: axisid identify emps2015 --json result.json && "
    "axisid export result.json --axis emps2015 --to c -o emps2015.c",
)
@click.argument("result", shell_complete=complete_file)
@click.option(
    "--axis",
    required=True,
    metavar="AXIS",
    help="The identified axis: its name in the library, or its file.",
    shell_complete=complete_axis,
)
@click.option(
    "--to",
    type=click.Choice(_NAMES),
    required=True,
    help=f"Format. {', '.join(_CODE)}: feed-forward functions in {', '.join(_LANGUAGES[:-1])} or "
    f"{_LANGUAGES[-1]}. {', '.join(_FILES)}: table of the parameters.",
)
@click.option(
    "--method",
    type=click.Choice(method_names()),
    help="Method whose estimate is exported.  [default: the method that the verdict judges]",
)
@click.option(
    "--record",
    "number",
    type=click.IntRange(min=1),
    metavar="N",
    help="Export the --local parameters and --known values of the Nth record, if the result is "
    "from several records.",
)
@click.option(
    "--dead-zone",
    type=float,
    default=0.0,
    metavar="SPEED",
    help="At or below this speed, in m/s or rad/s, the exported functions use the friction "
    "direction 0 (no Coulomb friction).  [default: 0, the direction is 0 at standstill only]",
)
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    help="Write to this file.  [default: standard output]",
    shell_complete=complete_file,
)
@force_option
def export(
    result: str,
    axis: str,
    to: str,
    method: str | None,
    number: int | None,
    dead_zone: float,
    output: str | None,
    force: bool,
) -> None:
    """Export an identified axis as code or as a table of parameters.

    RESULT is a file that `axisid identify --json` wrote. Code has two functions that begin with the
    name of the axis. NAME_feedforward computes the force from position, velocity and acceleration
    of the reference. NAME_control computes the control for this force. The functions need no
    libraries beyond the language itself.

    JSON, CSV and LaTeX contain the estimates of all methods unless --method names one method.
    """
    check_targets([Target("--output", output, "export")], (result, axis), force=force)

    write_output(
        output,
        stages.export(result, to, axis=axis, method=method, dead_zone=dead_zone, record=number),
    )
