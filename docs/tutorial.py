# %% [markdown]
# # Tutorial: from a log to a report in ten minutes
#
# You have a linear stage with a motor and a position loop, and a log from its drive. At the end you know its mass and
# its friction, you know how far you can trust these numbers, and you have a page to show to others.
#
# This page is a program. Below each cell is its output. A line that begins with `!` is a command for the terminal.
#
# ## Install
#
# You need Python 3.11 or later, in a separate environment:
#
# ```console
# $ git clone ... axisid && cd axisid     # or unpack the source
# $ python3 -m venv ~/axisid-env && . ~/axisid-env/bin/activate
# $ pip install .
# $ axisid --version
# ```
#
# Simulations run as native code if there is a C compiler; `pip install '.[native]'` installs one.
#
# ## Declare the axis
#
# The stage moves a mass `m` against viscous friction `b` and Coulomb friction `c`:
#
# $$m \ddot x = \tau - b \dot x - c \operatorname{sign}(\dot x), \qquad \tau = 18\,\mathrm{N/A} \cdot i$$
#
# The drive's control law is a cascade: a P controller of 50 1/s on the position, and 60 A/(m/s) on the velocity, every
# millisecond. `axisid new stage` writes a first file with comments. This is the completed file:

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

[columns]                                 # names in the log
time = "Zeit"
reference = "Soll"
position = "Ist"
control = "I_q"
""")

# %% [markdown]
# Of the nominal values, only the mass matters, because instrumental variables start from it. It may be rough. `show`
# prints the declaration:

# %%
# !axisid show stage.toml

# %% [markdown]
# axisid derived the regressors from the equation of motion and checked every unit. It also derived the map from the
# parameters `theta` of the direct model to the physical parameters, and the identifiable parameters.
#
# ## The log
#
# This is the beginning of a log from a drive in central Europe: two lines of preamble, semicolons, decimal commas,
# milliseconds and millimetres.

# %% tags=["hide-input"]
# You have your own log. The log of this page comes from a simulated stage.
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
# You need not convert anything: axisid detects separator, decimal comma, preamble and units of the file. Only
# the roles of the columns must be given, in the declaration above or by
# `--columns time=Zeit,reference=Soll,position=Ist,control=I_q`.

# %%
# !axisid identify stage.toml monday.csv --report report.html --json monday.json

# %% [markdown]
# Read it from the top:
#
# - **assumed** says how the file was read. If a unit is wrong there, everything below is wrong.
# - **The table** shows the reported method. This is `DIDIM` if the recorded control follows the declared law. DIDIM is least
#   squares with regressors from the simulated loop, which have no noise. Otherwise it is instrumental variables,
#   which noise in the position does not bias. Values are minus the bias found with simulated replicas of the record.
#   `sd` is the standard error, calibrated with the replicas. The interval contains the true value in 95 of 100
#   records. `IDM-LS` is plain least squares. `--all` prints every method, also those of the direct model: the same
#   physics, solved for the acceleration.
# - **The verdict** says whether to use the numbers, and why not. Then it lists the checks. A failed check says what to do.
#   The printed standard errors allow for notes. Here the control law and the alignment of force and motion pass, which
#   matters most.
#
# The true values, known only because the log is simulated, are m = 6.2 kg, b = 14 N/(m/s), c = 7.5 N.
#
# `report.html` is one self-contained page that you can send to a colleague: verdict, parameters, figures with
# zoom, the equation of motion and the command that reproduces it. It needs no network.

# %%
size = Path("report.html").stat().st_size
print(f"report.html: {size / 1e6:.1f} MB")

# %% [markdown]
# ## Is it valid on another day?
#
# `--validate` compares the frozen estimates with a second log. The errors should not grow.

# %%
# !axisid identify stage.toml monday.csv --validate tuesday.csv --method idm-iv | tail -16

# %% [markdown]
# ## Use it
#
# `export` writes the identified inverse dynamics as a feed-forward function for the drive, in C without dependencies
# (also in Structured Text and Python):

# %%
# !axisid export monday.json --axis stage.toml --to c

# %% [markdown]
# ## The same in a script

# %%
axis = axisid.load_axis("stage.toml")
record = axisid.read_record("monday.csv", axis)
result = axisid.identify(axis, record, axisid.Prefilter(cutoff=60.0, decimate=10))
estimate = result.preferred  # the reported one; result["idm-iv"] is another
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
# - [Declare your drive's control law](howto/control_law.py): instrumental variables need it.
# - [Choose the filter](howto/choosing_a_filter.py): the most important setting.
# - [Read the diagnostics](howto/reading_the_diagnostics.py): what a wrong unit, sign or delay looks like.
# - [Recorded signals in the model](howto/recorded_signals.py).
# - [Which estimator when](howto/which_estimator.py).
