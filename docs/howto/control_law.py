# %% [markdown]
# # Declare the control law
#
# Instruments come from the simulated closed loop, so they need the drive's control law. Least squares
# does without. A law is a difference equation, evaluated once a period; its output is held. What counts
# is *how the drive forms its velocity*: on the EMPS machine a plain backward difference of the encoder
# misses the recorded control by 3.3 %, the mean of two neighbouring samples by 0.24 %.
#
# ## A law that ships
#
# | | |
# |---|---|
# | `axisid.control.cascade_pd(kp, kv, period)` | `kv*(kp*(reference - position) - velocity)`, ideal velocity |
# | `axisid.control.cascade_pd_difference(kp, kv, period)` | the same, velocity from the difference of two encoder positions |
# | `axisid.control.cascade_pd_averaged(kp, kv, period)` | the same, velocity from averaged encoder differences |
#
# In TOML: `control = { law = "cascade_pd", kp = 50.0, kv = 60.0, period = 1e-3 }`.
#
# ## A law of your own
#
# The output may use `REFERENCE`, `MEASURED_POSITION`, `MEASURED_VELOCITY` (an ideal sensor), `PERIOD`, the
# gains and its memory. Each memory says what it is at the next sample, and how it starts. A PID with an
# integrator, and a velocity from encoder differences:

# %%
from dataclasses import replace

import axisid
from axisid.control import MEASURED_POSITION, PERIOD, REFERENCE, ControlLaw, Memory, gain

last = Memory("last", following=MEASURED_POSITION, start=MEASURED_POSITION)
total = Memory("total", following=gain("total") + REFERENCE - MEASURED_POSITION, start=0)
pid = ControlLaw(
    name="PID",
    period=1e-3,
    gains={"p": 3000.0, "i": 20.0, "d": 60.0},
    output=gain("p") * (REFERENCE - MEASURED_POSITION)
    + gain("i") * total.symbol
    - gain("d") * (MEASURED_POSITION - last.symbol) / PERIOD,
    memory=(last, total),
)

# %% [markdown]
# How a memory starts is said for an axis at rest: `MEASURED_POSITION`, `REFERENCE`, a number, or `BALANCED`,
# the value with which the law's output holds the axis there (an integral that carries a load). It is how a
# twin starts. The loop of a record starts with what the record's first controls show of the memory, and with
# its own velocity, so nothing about a record stands in the declaration.
#
# `period` is that of the law, which need not be the log's: a velocity loop at 16 kHz under a log at 1 kHz, or a log
# faster than the loop. The loop is then simulated at the law's period and sampled as the log is. Since a wrong time
# column looks the same, it is to be confirmed, by `--sample-period 1e-3` beside the log's own times, or in the
# declaration: `reference_between="spline"`, `"linear"` or `"held"` says that the law has a clock of its own, and how the
# reference runs between the samples of a slower log (without it, as a spline). Of a held reference the control is a sawtooth of which
# the log shows one edge; the law itself then tells its mean, which moves the axis. A continuous law takes any log.
#
# `delay=2` applies each control two samples late; `continuous=True` evaluates the law inside the plant's
# derivative (it has no memory then). The drive's `limit` clips the control.
#
# ## Check it against a record
#
# No need to trust a data sheet: the law's own terms, computed from the recorded reference and position,
# must add up to the recorded control. A twin stands for the record here, made with the law above, on a
# stage of the tutorial:

# %%
axis = axisid.load_axis("emps2015")
axis = replace(
    axis,
    control=replace(pid, gains={"p": 39000.0, "i": 50.0, "d": 243.0}),
    experiment=replace(axis.experiment, position_noise=1e-7),
)
record = axisid.twin_record(axis)
print(axisid.estimation.check_law(axisid.build(axis), record).note)

# %% [markdown]
# The wrong law, with another gain, is told apart, and the factors say in what:

# %%
wrong = replace(axis.control, gains={"p": 39000.0, "i": 50.0, "d": 300.0})
check = axisid.estimation.check_law(axisid.build(replace(axis, control=wrong)), record)
print(check.note)

# %% [markdown]
# The check is part of every result with a law and a reference. If it fails, believe no instruments before
# it is mended; see [Read the diagnostics](reading_the_diagnostics).
