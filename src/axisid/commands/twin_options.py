"""Options of ``axisid twin`` and ``axisid study``: the noise and true values of twins."""

from collections.abc import Callable, Mapping
from typing import Any

import click

from axisid.commands.options import VALUE, by_names, reading, stages

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
