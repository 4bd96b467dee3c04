"""Options of ``axisid twin`` and ``axisid study``: the noise and true values of twins."""

from collections.abc import Callable, Mapping
from typing import Any

import click

from axisid.commands.options import VALUE, by_names, reading, stages

#: Options of the noise of twins: the argument of `declared_chain`, and the help, by option.
NOISE = {
    "--position-noise": (
        "position",
        "Standard deviation of the noise of the measured position, SI. The simulated "
        "loop feeds the noisy position back.",
    ),
    "--resolution": (
        "resolution",
        "Resolution of the encoder in the loop and in the record, SI. 0 for no quantisation.",
    ),
    "--velocity-noise": (
        "velocity",
        "Record a measured velocity with noise of this standard deviation, SI. The loop does not "
        "use this velocity.  [default: no measured velocity]",
    ),
    "--acceleration-noise": (
        "acceleration",
        "Record a measured acceleration with noise of this standard deviation, SI. The loop does "
        "not use this acceleration.  [default: no measured acceleration]",
    ),
    "--control-noise": (
        "control",
        "Standard deviation of the noise of the recorded control, in the unit of the control (V, "
        "A, ...).  [default: 0]",
    ),
    "--disturbance": (
        "disturbance",
        "Standard deviation of a disturbance that acts in addition to the control and is not "
        "recorded, in the unit of the control (V, A, ...).  [default: 0]",
    ),
    "--correlation-time": (
        "correlation_time",
        "Correlation time of --control-noise and --disturbance, s. 0 for white noise.  [default: "
        "0]",
    ),
}
anywhere_option = click.option(
    "--anywhere",
    "noise_anywhere",
    is_flag=True,
    help="Begin each motion at a random position within an encoder count, as on a real machine.",
)


def noise_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of `NOISE`; a command takes each as ``noise_`` plus the argument's name."""
    for name, (argument, text) in reversed(NOISE.items()):
        is_declared = argument in ("position", "resolution")
        default = (
            "  [default: the value that the axis declares in its experiment]" if is_declared else ""
        )
        add = click.option(name, f"noise_{argument}", type=float, metavar="X", help=text + default)
        command = add(command)
    return command


def given_noise(axis: "stages.GeneratedAxis", noise: Mapping[str, float | None]) -> "stages.Chain":
    """Return the noise of an axis's twins.

    `noise` has the values of the options of `NOISE` and of ``--anywhere``, as a command takes them.
    For None, which is an option that is not given, the noise of the axis's experiment is used.
    """
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
    help="True value of a parameter of the twins, SI, instead of the value that the axis declares "
    "in its experiment. Can be repeated.",
)
