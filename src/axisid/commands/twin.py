"""``axisid twin``, and the options of what twins are: their true values and their noise."""

import shlex
from collections.abc import Callable, Mapping
from typing import Any

import click

from axisid.commands.options import (
    VALUE,
    Command,
    Target,
    by_names,
    check_folder,
    check_needed,
    check_targets,
    complete_axis,
    force_option,
    reading,
    stages,
)
from axisid.presentation.console import ProgressLine

#: The noise of the twins, by option: what it is called in Python, its unit, and its help.
NOISE = {
    "--position-noise": ("position", "Deviation of the measured position's noise, in the loop."),
    "--resolution": ("resolution", "Of the encoder, in the loop and in the record; 0 for none."),
    "--velocity-noise": ("velocity", "Of a velocity that is measured beside the loop."),
    "--acceleration-noise": ("acceleration", "Of an acceleration that is measured likewise."),
    "--control-noise": ("control", "Of what the record adds to the control, in the drive's unit."),
    "--disturbance": ("disturbance", "Of what acts beside the control and is not recorded."),
    "--correlation-time": ("correlation_time", "Of the last two, s; 0 for white noise."),
}
anywhere_option = click.option(
    "--anywhere",
    "noise_anywhere",
    is_flag=True,
    help="Begin each motion elsewhere in a count of the encoder, as on a machine.",
)
_MOTION = ("--acceleration", "--seconds", "--repeat", "--dwell")


def noise_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of the noise; the command takes each as ``noise_`` and its name."""
    for name, (parameter, said) in reversed(NOISE.items()):
        default = "  [default: the experiment's]" * (parameter in ("position", "resolution"))
        own = f"noise_{parameter}"
        command = click.option(name, own, type=float, metavar="X", help=said + default)(command)
    return command


def given_noise(axis: "stages.GeneratedAxis", noise: Mapping[str, float | None]) -> "stages.Chain":
    """The noise of an axis's twins, the experiment's where it is not given."""
    given: dict[str, Any] = {name.removeprefix("noise_"): each for name, each in noise.items()}
    return stages.declared_chain(stages.Chain.of_experiment(axis.axis), **given)


#: Reads shares of true values by name; that of all others has the name ``""``.
_shares = by_names(
    VALUE,
    "is no share; write NAME=SHARE, as in Fc=5% or Fc=0.05",
    lambda share, percent: float(share) / (100 if percent else 1),
)
truth_option = click.option(
    "--truth",
    multiple=True,
    metavar="NAME=VALUE",
    callback=reading(
        by_names(
            VALUE,
            "is no true value; write NAME=VALUE, SI, as in M=110",
            lambda value, _: float(value),
        )
    ),
    help="A true value of the twins, SI, in place of the experiment's; again for each.",
)


@click.command(
    cls=Command,
    short_help="Write logs of twins, to try things on.",
    epilog="Examples: axisid twin emps2015 --output twin.csv, or "
    "axisid twin emps2015 --count 3 --scatter 2% --output twins",
)
@click.argument("axis", shell_complete=complete_axis)
@click.option(
    "--output",
    required=True,
    metavar="PLACE",
    help="A file for one log, .csv or .parquet; a folder for those of --count and --days.",
)
@click.option("--count", type=click.IntRange(min=1), metavar="N", help="Machines, each a twin.")
@click.option(
    "--days",
    type=click.IntRange(min=1),
    metavar="N",
    help="Logs of each machine, one a day from 2026-01-01 on.",
)
@click.option(
    "--scatter",
    multiple=True,
    metavar="[NAME=]SHARE",
    callback=reading(_shares),
    help="Relative deviation of a true value between machines, or of all: 2% or Fc=0.05; again for "
    "each.",
)
@click.option(
    "--drift",
    multiple=True,
    metavar="NAME=SHARE",
    callback=reading(_shares),
    help="What a true value changes by a day, as a share of it; again for each.",
)
@truth_option
@noise_options
@anywhere_option
@click.option(
    "--speed",
    "speeds",
    type=float,
    multiple=True,
    metavar="V",
    help="A motion to and fro at this speed, coordinate unit per second, in place of the "
    "experiment's; again for each.",
)
@click.option("--acceleration", type=float, metavar="A", help="Of that motion, per second squared.")
@click.option(
    "--seconds",
    type=float,
    default=1.0,
    show_default="1",
    metavar="S",
    help="Of each of its moves.",
)
@click.option(
    "--repeat", type=int, default=1, show_default=True, metavar="N", help="How often it is made."
)
@click.option("--dwell", type=float, default=0.0, metavar="S", help="Rest after each of its moves.")
@click.option("--sample-period", type=float, metavar="S", help="Of the logs.  [default: the law's]")
@click.option(
    "--format",
    "form",
    type=click.Choice(["csv", "parquet"]),
    default="csv",
    show_default=True,
    help="Of the logs in a folder.",
)
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Of all.")
@force_option
def twin(
    axis: str,
    output: str,
    count: int | None,
    days: int | None,
    scatter: dict[str, float],
    drift: dict[str, float],
    truth: dict[str, float],
    speeds: tuple[float, ...],
    acceleration: float | None,
    seconds: float,
    repeat: int,
    dwell: float,
    sample_period: float | None,
    form: str,
    seed: int,
    force: bool,
    **noise: float | None,
) -> None:
    """Write the log of a twin of AXIS, or logs of many.

    A twin is simulated with true values that are known: by the axis's own experiment, or another
    motion. identify reads its log without further options. Of a folder the manifest, which fleet
    takes, has the true values of every machine.
    """
    folder = count is not None or days is not None
    check_needed(_MOTION, ("--speed",))
    check_needed(("--speed",), ("--acceleration",))
    check_needed(("--correlation-time",), ("--control-noise", "--disturbance"))
    check_needed(("--scatter", "--format"), ("--count", "--days"))
    check_needed(("--drift",), ("--days",))
    if not folder:
        check_targets([Target("--output", output, "twin")], [axis], force=force)
        if not output.endswith((".csv", ".parquet")):
            raise click.BadParameter(
                f"{output!r}: one log is a file whose name ends in .csv or .parquet; name one, or "
                "add --count or --days, whose logs are in a folder",
                param_hint="--output",
            )
    moves = None
    if acceleration is not None:
        moves = stages.back_and_forth(
            speeds=speeds, acceleration=acceleration, seconds=seconds, repeat=repeat, dwell=dwell
        )
    with ProgressLine(f"deriving {axis}"):
        simulated = stages.twin_of(stages.build(stages.load_axis(axis)), truth, moves)
        machines = stages.TwinMachines(
            axis=simulated,
            count=count or 1,
            days=days or 1,
            scatter=scatter,
            drift=drift,
            noise=given_noise(simulated, noise),
            seed=seed,
            sample_period=sample_period,
        )
    if not folder:
        with ProgressLine(f"simulating {axis}"):
            file = stages.write_twin(machines, output)
        click.echo(f"wrote {file}")
        units = {p.name: p.unit for p in machines.axis.declared.parameters}
        true = machines.truth(0, 0).items()
        click.echo("true: " + ", ".join(f"{name} = {v:.6g} {units[name]}" for name, v in true))
        measured = [
            f"{role}={role}"
            for role in ("velocity", "acceleration")
            if getattr(machines.noise, role) is not None and role not in machines.axis.axis.columns
        ]
        columns = ["--columns", ",".join(measured)] if measured else []
        click.echo("next: " + shlex.join(["axisid", "identify", axis, str(file), *columns]))
        return
    check_folder(output, "--output", stages.twin_files(machines, f".{form}"), force=force)
    with ProgressLine(f"simulating {axis}") as line:
        manifest = stages.write_twins(machines, output, axis=axis, ending=f".{form}", progress=line)
    logs = machines.count * machines.days
    click.echo(f"wrote {logs} {'log' if logs == 1 else 'logs'} and {manifest}")
    click.echo("next: " + shlex.join(["axisid", "fleet", str(manifest)]))
