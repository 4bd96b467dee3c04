"""``axisid twin``: write simulated logs of an axis."""

import shlex

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
    progress_line,
    reading,
    stages,
)

from .twin_options import anywhere_option, given_noise, noise_options, truth_option

_MOTION = ("--acceleration", "--seconds", "--repeat", "--dwell")


#: Function that reads shares of true values by parameter; ``""`` stands for all other parameters.
_shares = by_names(
    VALUE,
    "is not a share. Write NAME=SHARE, as in Fc=5% or Fc=0.05.",
    lambda share, percent: float(share) / (100 if percent else 1),
)


@click.command(
    cls=Command,
    short_help="Write simulated logs of an axis.",
    epilog="Examples: axisid twin emps2015 --output twin.csv, or "
    "axisid twin emps2015 --count 3 --scatter 2% --output twins",
)
@click.argument("axis", shell_complete=complete_axis)
@click.option(
    "--output",
    required=True,
    metavar="PLACE",
    help="Write one log into this file, .csv or .parquet. With --count or --days: write all logs "
    "into this folder.",
)
@click.option(
    "--count",
    type=click.IntRange(min=1),
    metavar="N",
    help="Number of machines, each of which is simulated as a twin.",
)
@click.option(
    "--days",
    type=click.IntRange(min=1),
    metavar="N",
    help="Number of logs of each machine, one per day from 2026-01-01.",
)
@click.option(
    "--scatter",
    multiple=True,
    metavar="[NAME=]SHARE",
    callback=reading(_shares),
    help="Relative standard deviation of a true value between machines, as in Fc=0.05. SHARE "
    "without NAME, as in 2%, applies to every true value that has no --scatter NAME=SHARE of its "
    "own. Can be repeated.",
)
@click.option(
    "--drift",
    multiple=True,
    metavar="NAME=SHARE",
    callback=reading(_shares),
    help="Relative change of a true value per day, as in Fc=0.5%. Can be repeated.",
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
    help="Move back and forth at this speed, in coordinate units per second, instead of the motion "
    "that the axis declares as its experiment. Needs --acceleration. Can be repeated.",
)
@click.option(
    "--acceleration",
    type=float,
    metavar="A",
    help="Acceleration of the --speed motion, in coordinate units per second squared.",
)
@click.option(
    "--seconds",
    type=float,
    default=1.0,
    metavar="S",
    help="Duration of each move of the --speed motion, s.  [default: 1]",
)
@click.option(
    "--repeat",
    type=int,
    default=1,
    show_default=True,
    metavar="N",
    help="Number of repetitions of the --speed motion.",
)
@click.option(
    "--dwell",
    type=float,
    default=0.0,
    metavar="S",
    help="Duration of the standstill after each move of the --speed motion, s.  [default: 0]",
)
@click.option(
    "--sample-period",
    type=float,
    metavar="S",
    help="Sampling period of the logs, s.  [default: the period of the control law]",
)
@click.option(
    "--format",
    "form",
    type=click.Choice(["csv", "parquet"]),
    default="csv",
    show_default=True,
    help="File format of the logs that --count or --days writes.",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=1,
    show_default=True,
    help="Seed of all random numbers.",
)
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
    """Write the simulated log of a machine like AXIS (its twin), or the logs of many such machines.

    A twin is simulated with known true values of the parameters, and with the motion that the axis
    declares as its experiment or the motion of --speed. `axisid identify` reads the log of a twin
    without further options. The noise is drawn as by `axisid study`. No seed gives the noise of the
    twin that `axisid identify AXIS` simulates if it gets no log.

    With --count or --days, the folder of --output also gets a manifest: a table of the logs with
    the true values of every machine. `axisid fleet` reads this manifest.
    """
    folder = count is not None or days is not None
    check_needed(
        (_MOTION, ("--speed",)),
        (("--speed",), ("--acceleration",)),
        (("--correlation-time",), ("--control-noise", "--disturbance")),
        (("--scatter", "--format"), ("--count", "--days")),
        (("--drift",), ("--days",)),
    )
    if not folder:
        check_targets([Target("--output", output, "twin")], [axis], force=force)
    if folder == output.endswith((".csv", ".parquet")):
        expected = (
            "with --count or --days the logs are written into a folder. Name a folder, or omit "
            "these options."
        )
        if not folder:
            expected = (
                "one log is written to a file that ends in .csv or .parquet. Name such a file, or "
                "add --count or --days to write a folder."
            )
        raise click.BadParameter(f"{output!r}: {expected}", param_hint="--output")
    moves = (
        None
        if acceleration is None
        else stages.back_and_forth(
            speeds=speeds, acceleration=acceleration, seconds=seconds, repeat=repeat, dwell=dwell
        )
    )
    with progress_line(f"deriving {axis}"):
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
        with progress_line(f"simulating {axis}"):
            file = stages.write_twin(machines, output)
        click.echo(f"wrote {file}")
        units = {p.name: p.unit for p in machines.axis.declared.parameters}
        true = machines.truth(0, 0).items()
        click.echo(
            "true values: " + ", ".join(f"{name} = {v:.6g} {units[name]}" for name, v in true)
        )
        measured = [
            f"{role}={role}"
            for role in ("velocity", "acceleration")
            if getattr(machines.noise, role) is not None and role not in machines.axis.axis.columns
        ]
        columns = ["--columns", ",".join(measured)] if measured else []
        click.echo("next: " + shlex.join(["axisid", "identify", axis, str(file), *columns]))
        return
    check_folder(output, "--output", stages.twin_files(machines, f".{form}"), force=force)
    with progress_line(f"simulating {axis}") as line:
        manifest = stages.write_twins(machines, output, axis=axis, ending=f".{form}", progress=line)
    logs = machines.count * machines.days
    click.echo(f"wrote {logs} {'log' if logs == 1 else 'logs'} and {manifest}")
    click.echo("next: " + shlex.join(["axisid", "fleet", str(manifest)]))
