"""``axisid study``: test the identification on many twins."""

from pathlib import Path

import click

from axisid.commands.options import (
    Command,
    Filtering,
    Target,
    bootstrap_option,
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
    progress_line,
    put_result,
    reading,
    stages,
    takes,
    write_page,
)
from axisid.estimation.choices import fit_names, fitted_output, method_names

from .twin_options import anywhere_option, given_noise, noise_options, truth_option


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
    help="Method of `axisid identify`, or fit:OUTPUT for `axisid fit` with this --output. Can be "
    "repeated.  [default: idm-iv]",
)
@click.option(
    "--twin",
    metavar="AXIS",
    shell_complete=complete_axis,
    help="Simulate the twins with this axis, to test the identification with a wrong model.  "
    "[default: AXIS]",
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
    help="Run all checks for the first N twins and report how often each check fails. The checks "
    "take several times as long as the estimates.",
)
@takes("filtering", Filtering)
@leave_out_option(has_fix=False)
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
    help="Number of processes. The results do not depend on this number.",
)
@click.option(
    "--output",
    metavar="FILE",
    help="Write the numbers of every run into a .npz or .parquet file.",
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
    """Identify many simulated records (twins) of AXIS and compare estimates and true values.

    Each twin is simulated with a new random draw of the noise. The study reports the bias and the
    scatter of every estimate, and how often the intervals of the estimate contain the true value.
    With --checks, the study also reports how often each check fails. The twins are simulated with
    AXIS, or with another axis (--twin).
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
        # The simulated axis keeps the parameters that are not identified.
        simulated = identified
        if twin is not None or left_out:
            simulated = stages.build(whole if twin is None else stages.load_axis(twin))

    def keep(partial: stages.MonteCarlo) -> None:
        """Write the finished runs of a study that ends early, and print their number."""
        done = f"{len(partial)} of {partial.plan.runs} runs were finished"
        if output is None:
            kept = "and are lost. Add --output FILE to keep finished runs"
        else:
            stages.write_runs(partial, output)
            kept = f"and are kept in {output}"
        click.echo(f"axisid: {done} {kept}", err=True)

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
