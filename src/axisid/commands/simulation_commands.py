"""``axisid twin``, ``axisid study`` and ``axisid paper``: logs of twins, and studies of many."""

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

#: The noise of the twins, by option: its name in Python and its help.
NOISE = {
    "--position-noise": (
        "position",
        "Standard deviation of the noise of the measured position, which the loop feeds back, SI.",
    ),
    "--resolution": (
        "resolution",
        "Resolution of the encoder, in the loop and in the record, SI; 0 for no quantisation.",
    ),
    "--velocity-noise": (
        "velocity",
        "Record a measured velocity with noise of this standard deviation, SI. The loop does not "
        "use it.",
    ),
    "--acceleration-noise": (
        "acceleration",
        "Record a measured acceleration with noise of this standard deviation, SI. The loop does "
        "not use it.",
    ),
    "--control-noise": (
        "control",
        "Standard deviation of the noise of the recorded control, in the drive's unit.",
    ),
    "--disturbance": (
        "disturbance",
        "Standard deviation of a disturbance that acts in addition to the control and is not "
        "recorded, in the drive's unit.",
    ),
    "--correlation-time": (
        "correlation_time",
        "Correlation time of --control-noise and --disturbance, s; 0 for white noise.",
    ),
}
anywhere_option = click.option(
    "--anywhere",
    "noise_anywhere",
    is_flag=True,
    help="Begin each motion at a random position within an encoder count, as on a real machine.",
)
_MOTION = ("--acceleration", "--seconds", "--repeat", "--dwell")


def noise_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of the noise; the command takes each as ``noise_`` plus its name."""
    for name, (parameter, said) in reversed(NOISE.items()):
        default = "  [default: the experiment's]" * (parameter in ("position", "resolution"))
        own = f"noise_{parameter}"
        command = click.option(name, own, type=float, metavar="X", help=said + default)(command)
    return command


def given_noise(axis: "stages.GeneratedAxis", noise: Mapping[str, float | None]) -> "stages.Chain":
    """Return the noise of an axis's twins, by default the noise of its experiment."""
    given: dict[str, Any] = {name.removeprefix("noise_"): each for name, each in noise.items()}
    return stages.declared_chain(stages.Chain.of_experiment(axis.axis), **given)


#: Reads shares of true values by name; the share of all others has the name ``""``.
_shares = by_names(
    VALUE,
    "is not a share. Write NAME=SHARE, as in Fc=5% or Fc=0.05.",
    lambda share, percent: float(share) / (100 if percent else 1),
)
truth_option = click.option(
    "--truth",
    multiple=True,
    metavar="NAME=VALUE",
    callback=reading(
        by_names(
            VALUE,
            "is not a true value. Write NAME=VALUE in SI units, as in M=110.",
            lambda value, _: float(value),
        )
    ),
    help="True value of a parameter of the twins, SI, instead of the experiment's value. Can be "
    "repeated.",
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
    help="File of one log, .csv or .parquet; with --count or --days a folder for all logs.",
)
@click.option(
    "--count",
    type=click.IntRange(min=1),
    metavar="N",
    help="Number of machines, each simulated as a twin.",
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
    help="Relative standard deviation of a true value between machines; without NAME of all true "
    "values. Write 2% or Fc=0.05. Can be repeated.",
)
@click.option(
    "--drift",
    multiple=True,
    metavar="NAME=SHARE",
    callback=reading(_shares),
    help="Relative change of a true value per day. Can be repeated.",
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
    help="Move back and forth at this speed, in coordinate units per second, instead of the "
    "experiment's motion. Can be repeated.",
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
    show_default="1",
    metavar="S",
    help="Duration of each move of the --speed motion, s.",
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
    help="Standstill after each move of the --speed motion, s.",
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
    help="File format of the logs in a folder.",
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
    """Write the log of a twin of AXIS, or the logs of many twins.

    A twin is simulated with known true values, and with the axis's own experiment or another
    motion. identify reads its log without further options. Noise is drawn as in study. The twin
    that identify simulates if no log is given has other noise, whatever the seed. With --count or
    --days the folder also gets a manifest for fleet, with the true values of every machine.
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
        expected = "--count and --days write a folder. Name a folder, or omit these options."
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


@click.command(
    cls=Command,
    short_help="Test the identification on many twins.",
    epilog="Examples: axisid study emps2015 --runs 20 --method idm-ls --method idm-iv, or "
    "axisid study emps2015 --truth Fc=30 --runs 20 --report study.html",
)
@click.argument("axis", shell_complete=complete_axis)
@click.option(
    "--runs", type=click.IntRange(min=1), default=200, show_default=True, help="Number of twins."
)
@click.option(
    "--method",
    "methods",
    type=click.Choice([*method_names(), "all", *fit_names()]),
    multiple=True,
    default=("idm-iv",),
    callback=reading(one_or_all),
    show_default="idm-iv",
    help="Method of identify, or fit:OUTPUT for a fit. Can be repeated.",
)
@click.option(
    "--twin",
    metavar="AXIS",
    shell_complete=complete_axis,
    help="Simulate this axis instead, to test a wrong model.  [default: AXIS]",
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
    help="Also run all checks for the first N twins and report how often each check fails. Checks "
    "take several times as long as an estimate.",
)
@takes("filtering", Filtering)
@leave_out_option
@loss_option
@bootstrap_option
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=1,
    show_default=True,
    help="Seed of all random numbers.",
)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    metavar="N",
    help="Number of processes. The results do not depend on it.",
)
@click.option(
    "--output", metavar="FILE", help="Write the figures of every run into a .npz or .parquet file."
)
@json_option
@click.option("--report", metavar="FILE", help="Write an HTML page with tables and figures.")
@click.option("--figures", metavar="DIR", help="Write the figures into a folder, as PDF.")
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
    """Identify many twins of AXIS, each with its own noise, and compare with their true values.

    The study reports the bias and scatter of every estimate, how often its intervals contain the
    true value, and how often each check fails. The twins are of the axis itself, or of another axis
    (--twin).
    """
    regressions = tuple(method for method in methods if not fitted_output(method))
    for option in () if regressions else ("--loss", "--bootstrap", *Filtering.names().values()):
        check_idle(option, f"has no effect on --method {' and '.join(methods)}")
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
        # The simulated axis has every term.
        simulated = identified
        if twin is not None or left_out:
            simulated = stages.build(whole if twin is None else stages.load_axis(twin))

    def keep(partial: stages.MonteCarlo) -> None:
        """Keep the finished runs of a study that ends early, and print their number."""
        done = f"{len(partial)} of {partial.plan.runs} runs were finished"
        if output is not None:
            stages.write_runs(partial, output)
        kept = (
            " and are lost; --output FILE keeps them"
            if output is None
            else f" and are kept in {output}"
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
    metavar="N",
    help="Also show the distribution of the estimates of N twins with both filters.",
)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    metavar="N",
    help="Number of processes for these twins. The results do not depend on it.",
)
@force_option
def paper(output: str | None, runs: int | None, jobs: int, force: bool) -> None:
    """Identify the twin of the paper's axis with all four methods and both filters.

    Prints the tables of Brunot et al. (SYSID 2015) next to the twin's, and draws figures 3 and 4.
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
