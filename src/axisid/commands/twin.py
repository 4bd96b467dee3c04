"""``axisid twin``, and the options of what twins are: their true values and their noise."""

import shlex
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import click

from axisid.commands.options import (
    Command,
    Target,
    check_folder,
    check_needed,
    check_targets,
    complete_axis,
    force_option,
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
truth_option = click.option(
    "--truth",
    multiple=True,
    metavar="NAME=VALUE",
    help="A true value of the twins, SI, in place of the experiment's; again for each.",
)
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


def truth_of(texts: tuple[str, ...]) -> dict[str, float]:
    """True values by name."""
    return _pairs(texts, "--truth", "NAME=VALUE, SI, as in M=110")


def _shares(texts: tuple[str, ...], option: str) -> dict[str, float]:
    """Shares of true values by name; that of all of them has the name ``""``."""
    named = tuple(text if "=" in text else f"={text}" for text in texts)
    return _pairs(named, option, "NAME=SHARE, as in Fc=5% or Fc=0.05", percent=True)


def _pairs(
    texts: tuple[str, ...], option: str, form: str, *, percent: bool = False
) -> dict[str, float]:
    found = {}
    for text in texts:
        name, _, value = text.partition("=")
        number = value.strip().removesuffix("%") if percent else value
        try:
            found[name.strip()] = float(number) / (100 if percent and "%" in value else 1)
        except ValueError as error:
            raise click.BadParameter(
                f"{text.removeprefix('=')!r}: write {form}", param_hint=option
            ) from error
    return found


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
    help="Relative deviation of a true value between machines, or of all: 2% or Fc=0.05; again for "
    "each.",
)
@click.option(
    "--drift",
    multiple=True,
    metavar="NAME=SHARE",
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
@click.option("--seconds", type=float, metavar="S", help="Of each of its moves.  [default: 1]")
@click.option("--repeat", type=int, metavar="N", help="How often it is made.  [default: 1]")
@click.option("--dwell", type=float, metavar="S", help="Rest after each of its moves.")
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
    scatter: tuple[str, ...],
    drift: tuple[str, ...],
    truth: tuple[str, ...],
    speeds: tuple[float, ...],
    acceleration: float | None,
    seconds: float | None,
    repeat: int | None,
    dwell: float | None,
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
    scatters, drifts = _shares(scatter, "--scatter"), _shares(drift, "--drift")
    values, moves = truth_of(truth), None
    if speeds:
        if acceleration is None:
            raise click.UsageError("--speed says nothing without --acceleration; add that too.")
        moves = stages.back_and_forth(
            speeds=speeds,
            acceleration=acceleration,
            seconds=1.0 if seconds is None else seconds,
            repeat=1 if repeat is None else repeat,
            dwell=dwell or 0.0,
        )
    with ProgressLine(f"deriving {axis}"):
        built = stages.build(stages.load_axis(axis))
        made = stages.twin_of(built, values, moves)
        alike = stages.TwinMachines(
            axis=made,
            count=count or 1,
            days=days or 1,
            drift=drifts,
            noise=given_noise(made, noise),
            seed=seed,
            sample_period=sample_period,
        )
        of_all = scatters.pop("", 0.0)
        each = {name: of_all for name, value in alike.true_values.items() if value and of_all}
        machines = replace(alike, scatter={**each, **scatters})
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
    ending = f".{form}"
    check_folder(output, "--output", stages.twin_files(machines, ending), force=force)
    with ProgressLine(f"simulating {axis}") as line:
        manifest = stages.write_twins(machines, output, axis=axis, ending=ending, progress=line)
    logs = machines.count * machines.days
    click.echo(f"wrote {logs} {'log' if logs == 1 else 'logs'} and {manifest}")
    click.echo("next: " + shlex.join(["axisid", "fleet", str(manifest)]))
