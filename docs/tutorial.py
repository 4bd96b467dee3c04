# %% [markdown]
# # Tutorial: from a log to a report in ten minutes
#
# You have a linear stage with a motor, a position loop, and a log as the drive writes it. At the end you
# know its mass and its friction, how far these numbers can be trusted, and have a page to show to others.
#
# This page is a program: what follows each cell is what it printed when the page was built. A line that
# begins with `!` is a command for the terminal.
#
# ## Install
#
# Python 3.11 or later, in an environment of its own:
#
# ```console
# $ git clone ... axisid && cd axisid     # or unpack the source
# $ python3 -m venv ~/axisid-env && . ~/axisid-env/bin/activate
# $ pip install .
# $ axisid --version
# ```
#
# Simulations run as native code where there is a C compiler; `pip install '.[native]'` brings one.
#
# ## Declare the axis
#
# The stage moves a mass `m` against viscous friction `b` and Coulomb friction `c`:
#
# $$m \ddot x = \tau - b \dot x - c \operatorname{sign}(\dot x), \qquad \tau = 18\,\mathrm{N/A} \cdot i$$
#
# The drive's position loop is a cascade: a P controller of 50 1/s on the position, and 60 A/(m/s) on the
# velocity, every millisecond. `axisid new stage` starts such a file with comments; ready, it reads:

# %%
from pathlib import Path

_ = Path("stage.toml").write_text("""\
name = "stage"
title = "linear stage"
coordinate = { name = "x", unit = "m" }   # velocity dx, acceleration ddx
drive = { gain = 18.0, unit = "A", limit = 12.0 }
control = { law = "cascade_pd", kp = 50.0, kv = 60.0, period = 1e-3 }

[parameters]
m = { unit = "kg", nominal = 5.0, lower = 0.0, description = "moving mass" }
b = { unit = "N/(m/s)", lower = 0.0, description = "viscous friction" }
c = { unit = "N", lower = 0.0, description = "Coulomb friction" }

[newton]
inertia = "m"
resistance = ["b*dx", "c*sign(dx)"]

[columns]                                 # what the drive calls them
time = "Zeit"
reference = "Soll"
position = "Ist"
control = "I_q"
""")

# %% [markdown]
# Only the *nominal* mass matters, and it may be rough: instrumental variables start from there. What did
# we declare?

# %%
# !axisid show stage.toml

# %% [markdown]
# Nobody wrote a regressor by hand. Every unit was checked; the map from the direct model's parameters
# `theta` to the physical ones, and what is identifiable at all, follow from the equation of motion.
#
# ## The log
#
# Here is the beginning of a log as a drive in central Europe writes it: two lines of preamble,
# semicolons, decimal commas, milliseconds and millimetres.

# %% tags=["hide-input"]
# You have a log of your own. For this page, one is made from a simulated stage.
from dataclasses import replace

import axisid

TRUTH = {"m": 6.2, "b": 14.0, "c": 7.5}


def write_log(name: str, speeds: tuple[float, ...], seed: int) -> None:
    """Simulate the stage with encoder noise, and write it as a drive would."""
    experiment = axisid.modeling.Experiment(
        moves=axisid.modeling.back_and_forth(
            speeds=speeds, acceleration=4.0, seconds=0.5, repeat=3
        ),
        truth=TRUTH,
        position_noise=2e-6,
        seed=seed,
    )
    r = axisid.twin_record(replace(axisid.load_axis("stage.toml"), experiment=experiment))
    columns = zip(1e3 * r.time, 1e3 * r.reference, 1e3 * r.position, r.control, strict=True)
    rows = [";".join(f"{value:.6f}".replace(".", ",") for value in row) for row in columns]
    head = [
        "Drive 3, trace of 2026-02-03",
        "Trigger: manual",
        "Zeit [ms];Soll [mm];Ist [mm];I_q [A]",
    ]
    Path(name).write_text("\n".join([*head, *rows]) + "\n", encoding="cp1252")


write_log("monday.csv", (0.1, 0.3, 0.5), seed=1)
write_log("tuesday.csv", (0.2, 0.4), seed=2)

# %%
# !head -6 monday.csv

# %% [markdown]
# ## Identify
#
# Nothing needs to be converted: separator, decimal comma, preamble and units are found in the file. Only
# the columns' roles had to be told, in the declaration above or by
# `--columns time=Zeit,reference=Soll,position=Ist,control=I_q`.

# %%
# !axisid identify stage.toml monday.csv --report report.html --json monday.json

# %% [markdown]
# Read it from the top:
#
# - **assumed** says what was taken of the file. If a unit is wrong there, everything below is wrong.
# - **The table** has the method that is judged: `DIDIM` where the control law holds, least squares by the
#   rows of the loop that is simulated with the estimate, where no noise is; else instrumental variables,
#   which noise in the position does not bias. A value is less the bias that twins of the record tell, `sd`
#   is what they scatter, and the interval holds the truth 95 times in 100. `IDM-LS` beside it is plain
#   least squares. `--all` prints every method, also of the direct model: the same physics, regressed the
#   other way round.
# - **The verdict** says whether to believe the numbers, then what was checked. What fails says what to do;
#   a note is allowed for in the deviations that are printed. Here the control law and the alignment of
#   force and motion hold, which matters most.
#
# The truth, known only because the log is simulated, is m = 6.2 kg, b = 14 N/(m/s), c = 7.5 N.
#
# `report.html` is one self-contained page, to be sent to a colleague: verdict, parameters, figures with
# zoom, the equation of motion and the command that reproduces it. It needs no network.

# %%
size = Path("report.html").stat().st_size
print(f"report.html: {size / 1e6:.1f} MB")

# %% [markdown]
# ## Does it hold on another day?
#
# The estimates, frozen, against a second log. What counts is that the errors stay what they were.

# %%
# !axisid identify stage.toml monday.csv --validate tuesday.csv --method idm-iv | tail -9

# %% [markdown]
# ## Use it
#
# The identified inverse dynamics as a feed-forward function for the drive, in C without dependencies
# (also as Structured Text and Python):

# %%
# !axisid export monday.json --axis stage.toml --to c

# %% [markdown]
# ## The same in a script

# %%
axis = axisid.load_axis("stage.toml")
record = axisid.read_record("monday.csv", axis)
result = axisid.identify(axis, record, axisid.Prefilter(cutoff=60.0, decimate=10))
estimate = result.preferred  # the one that the verdict is of; result["idm-iv"] is another
print(estimate.method)
print(estimate.parameters["m"])
print(estimate.derive("m/b"))

# %%
result.plot("force")

# %%
result.plot("friction")

# %% [markdown]
# ## Where to go from here
#
# - [Declare your own axis](howto/new_axis.py): gravity, springs, gears, other friction laws, energies.
# - [Declare your drive's control law](howto/control_law.py), which instruments need.
# - [Choose the filter](howto/choosing_a_filter.py): the one setting that matters.
# - [Read the diagnostics](howto/reading_the_diagnostics.py): what a wrong unit, sign or delay looks like.
# - [Recorded signals in the model](howto/recorded_signals.py).
# - [Which estimator when](howto/which_estimator.py).
