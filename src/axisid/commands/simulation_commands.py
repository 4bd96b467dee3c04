"""``axisid twin``, ``axisid study`` and ``axisid paper``: logs of twins, and what comes of many."""

import shlex
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import click

from axisid.commands.options import (
    VALUE,
    Command,
    Filtering,
    Target,
    bootstrap_option,
    by_names,
    check_folder,
    check_idle,
    check_needed,
    check_targets,
    complete_axis,
    force_option,
    json_option,
    leave_out_option,
    loss_option,
    one_or_all,
    print_document,
    progress_line,
    put_out,
    put_result,
    reading,
    stages,
    takes,
    write_page,
)
from axisid.estimation.choices import fit_names, fitted_output, method_names

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
    motion. identify reads its log without further options. Noise is drawn as in study: the twin
    that identify makes where no log is given has other noise, whatever the seed. Of a folder the
    manifest, which fleet takes, has the true values of every machine.
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
        raise click.BadParameter(
            f"{output!r}: one log is a file whose name ends in .csv or .parquet, and those of "
            "--count and --days are in a folder, whose name does not; name the other, or "
            f"{'leave these out' if folder else 'add one of these'}",
            param_hint="--output",
        )
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
    with progress_line(f"simulating {axis}") as line:
        manifest = stages.write_twins(machines, output, axis=axis, ending=f".{form}", progress=line)
    logs = machines.count * machines.days
    click.echo(f"wrote {logs} {'log' if logs == 1 else 'logs'} and {manifest}")
    click.echo("next: " + shlex.join(["axisid", "fleet", str(manifest)]))


@click.command(
    cls=Command,
    short_help="Identify many twins: bias, intervals, checks.",
    epilog="Examples: axisid study emps2015 --runs 20 --method idm-ls --method idm-iv, or "
    "axisid study emps2015 --truth Fc=30 --runs 20 --report study.html",
)
@click.argument("axis", shell_complete=complete_axis)
@click.option("--runs", type=click.IntRange(min=1), default=200, show_default=True, help="Twins.")
@click.option(
    "--method",
    "methods",
    type=click.Choice([*method_names(), "all", *fit_names()]),
    multiple=True,
    default=("idm-iv",),
    callback=reading(one_or_all),
    show_default="idm-iv",
    help="As in identify, or fit:OUTPUT as in fit; again for each.",
)
@click.option(
    "--twin",
    metavar="AXIS",
    shell_complete=complete_axis,
    help="The axis that is simulated, where the model is to be wrong.  [default: AXIS]",
)
@truth_option
@noise_options
@anywhere_option
@click.option(
    "--checks",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    metavar="N",
    help="Judge the first N runs too: how often each check fails. A verdict costs several times an "
    "estimate.",
)
@takes("filtering", Filtering)
@leave_out_option
@loss_option
@bootstrap_option
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Of all.")
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    metavar="N",
    help="Processes; the numbers are the same for any.",
)
@click.option("--output", metavar="FILE", help="Write the numbers of every run: .npz or .parquet.")
@json_option
@click.option("--report", metavar="FILE", help="Write a page of HTML: tables and figures.")
@click.option("--figures", metavar="DIR", help="Write the figures into a folder.")
@force_option
def study(
    axis: str,
    runs: int,
    methods: tuple[str, ...],
    twin: str | None,
    truth: dict[str, float],
    checks: int,
    filtering: Filtering,
    left_out: tuple[str, ...],
    loss: str,
    seed: int,
    bootstrap: int,
    jobs: int,
    output: str | None,
    json_file: str | None,
    report: str | None,
    figures: str | None,
    force: bool,
    **noise: float | None,
) -> None:
    """Identify many twins of AXIS, each with noise of its own, and tell how far to believe it.

    Bias and scatter of every estimate, how often its intervals hold the truth, and how often each
    check fails: on twins of the axis itself, or of another one (--twin).
    """
    regressions = tuple(method for method in methods if not fitted_output(method))
    for option in () if regressions else ("--loss", "--bootstrap", *Filtering.names().values()):
        check_idle(option, f"is of identify, which --method {' and '.join(methods)} does without")
    check_needed((("--correlation-time",), ("--control-noise", "--disturbance")))
    check_targets(
        [
            Target("--output", output, "study-runs"),
            Target("--json", json_file, "study"),
            Target("--report", report, "report"),
        ],
        (axis, twin),
        force=force,
    )
    if output is not None:
        stages.check_output(Path(output))
    drawn = {f"{name}.pdf": "figure" for name in stages.PLOTS}
    check_folder(figures, "--figures", drawn, force=force)
    with progress_line(f"deriving {axis}"):
        whole = stages.load_axis(axis)
        identified = stages.build(stages.leave_out(whole, *left_out))
        # What is simulated has every term, as an axis has.
        simulated = identified
        if twin is not None or left_out:
            simulated = stages.build(whole if twin is None else stages.load_axis(twin))

    def keep(partial: stages.MonteCarlo) -> None:
        """Keep what is done of a study that ends early, and say so."""
        done = f"{len(partial)} of {partial.plan.runs} runs are done"
        if output is not None:
            stages.write_runs(partial, output)
        kept = (
            "; --output FILE would have kept them" if output is None else f" and kept in {output}"
        )
        click.echo(f"axisid: {done}{kept}", err=True)

    with progress_line("twins") as line:
        result = stages.monte_carlo(
            identified,
            runs,
            methods,
            prefilter=filtering.prefilter(),
            noise=given_noise(simulated, noise),
            twin=simulated,
            truth=truth,
            checks=checks,
            seed=seed,
            bootstrap=bootstrap,
            loss=loss,
            jobs=jobs,
            progress=line,
            keep=keep,
        )

    put_result(
        result,
        json_file,
        (output, lambda file: [stages.write_runs(result, file)]),
        (report, lambda file: write_page(file, stages.monte_carlo_page, result)),
        (
            figures,
            lambda folder: stages.write_figures(
                stages.monte_carlo_plots(result).values(), Path(folder), "pdf"
            ),
        ),
    )


@click.command(
    cls=Command,
    short_help="Reproduce the paper's tables on a twin.",
    epilog="Example: axisid paper --output results",
)
@click.option(
    "--output",
    metavar="DIR",
    help="Also write the tables, the figures and the results as JSON into this folder.",
)
@click.option(
    "--runs",
    type=click.IntRange(min=2),
    help="Add how the estimates of so many twins are distributed under both filters.",
)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    metavar="N",
    help="Processes for those twins; the numbers are the same for any.",
)
@force_option
def paper(output: str | None, runs: int | None, jobs: int, force: bool) -> None:
    """Identify the twin of the paper's axis by all four methods under both filters.

    Prints the tables of Brunot et al. (SYSID 2015) beside the twin's, and draws figures 3 and 4.
    """
    check_needed((("--jobs",), ("--runs",)))
    if output is not None:
        import axisid.presentation.matplotlib  # noqa: F401 - refused before anything is computed

    files = {**stages.STUDY_FILES, **(stages.DISTRIBUTION_FILES if runs else {})}
    check_folder(output, "--output", files, force=force)

    def put(made: Any, document: "stages.Document", write: Callable[[Any, Path], Any]) -> None:
        put_out(
            None,
            dict,
            lambda: print_document(document),
            (output, lambda folder: write(made, Path(folder))),
        )

    with progress_line("the paper's study") as line:
        study = stages.run_study(line)
    put(study, stages.study_document(study), stages.write_study)
    if runs:
        with progress_line("twins of the paper's axis") as line:
            found = stages.run_distributions(runs, jobs=jobs, progress=line)
        click.echo()
        put(found, stages.distributions_document(found), stages.write_distributions)
