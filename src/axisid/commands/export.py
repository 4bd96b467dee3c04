"""``axisid export``."""

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
from axisid.exports.targets import TARGETS

_NAMES = tuple(target.name for target in TARGETS)
_LANGUAGES = [target.language for target in TARGETS if target.language]


@click.command(
    cls=Command,
    epilog="Example: axisid identify emps2015 --json result.json && "
    "axisid export result.json --axis emps2015 --to c -o emps2015.c",
)
@click.argument("result", shell_complete=complete_file)
@click.option(
    "--axis",
    required=True,
    help="The axis that was identified: of the library, or its file.",
    shell_complete=complete_axis,
)
@click.option(
    "--to",
    type=click.Choice(_NAMES),
    required=True,
    help=f"Feed-forward functions in {', '.join(_LANGUAGES[:-1])} or {_LANGUAGES[-1]}; "
    "or the parameters.",
)
@click.option(
    "--method",
    type=click.Choice(method_names()),
    help="Estimator.  [default: the judged one]",
)
@click.option(
    "--record",
    "number",
    type=click.IntRange(min=1),
    metavar="N",
    help="One of several records, whose parameters (by --local and --known) are wanted.",
)
@click.option(
    "--dead-zone",
    type=float,
    default=0.0,
    metavar="SPEED",
    help="Speed up to which the friction direction is 0, in m/s or rad/s.  [default: 0]",
)
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    help="In place of standard output.",
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
    """Write an identified axis for use elsewhere.

    RESULT is what `axisid identify --json` wrote. The functions NAME_feedforward and NAME_control
    take position, velocity and acceleration of the reference and give force and control; they need
    nothing but the language. JSON, CSV and LaTeX hold all methods unless one is named.
    """
    check_targets([Target("--output", output, "export")], (result, axis), force=force)

    write_output(
        output,
        stages.export(result, to, axis=axis, method=method, dead_zone=dead_zone, record=number),
    )
