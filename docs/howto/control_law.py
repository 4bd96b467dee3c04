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
# | `cascade_pd(kp, kv, period)` | `kv*(kp*(reference - position) - velocity)`, ideal velocity |
# | `cascade_pd_difference`, `cascade_pd_averaged` | the same, velocity from differences of encoder positions, plain or averaged |
# | `cascade_p_pi(kp, kv, tn, period)` | position loop over a velocity loop with an integral; feed-forward, speed limit, velocity filters, anti-windup: ODrive, SimpleFOC, most drives |
# | `pid(kp, ki, kd, period)`, `pid_ideal(k, ti, td, period)` | the two forms of a PID, with a filtered derivative and anti-windup |
# | `impedance(kp, kd, period)` | a virtual spring and damper: moteus, the MIT mode of T-Motor |
# | `state_feedback(k_position, k_velocity, period)` | with a gain of the reference and an integral |
# | `dynamixel_position(p, i, d, ff1, ff2, period)` | by the registers of a Dynamixel X, a PWM out |
#
# All are in `axisid.control`; [each says](../api/modelling.md) its equation, its units and by which factors the
# gains of makers become those. In TOML:
#
# ```toml
# [control]
# law = "cascade_p_pi"
# kp = 60.0
# kv = 243.0
# tn = 0.03
# period = 1e-3
# velocity = "averaged"
# velocity_feed_forward = 1.0
# anti_windup = "clamping"
# ```
#
# A feed-forward may be of the reference's differences or of recorded columns: `reference_velocity=Signal("speed", "m/s")`,
# `feed_forward=...`, in TOML the name of a signal or an expression of signals and `[constants]`. Which of the ready
# laws a drive runs, and with which gains, a log may tell: `axisid law AXIS LOG`
# ([how](#which-law-does-the-drive-run)).
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
# Filters and limits are blocks, each a value and the memories that it keeps: `low_pass`, `notch`, `pll_velocity`,
# `rate_limit`, `difference`, `reference_velocity`, `reference_acceleration`. An `integral` takes its anti-windup along:
# it compares `UNLIMITED_OUTPUT`, the law's own output, with `LIMITED_OUTPUT`, this output within the drive's limit. Memories
# of your own may read both. Use these symbols and do not repeat the output's expression: repeated, it differs by rounding.
#
# ```python
# speed = pll_velocity(bandwidth=800.0)
# torque = notch(gain("kd") * (gain("w") - speed.value), frequency=180.0, quality=2.0)
# ControlLaw(..., output=torque.value, memory=(*speed.memory, *torque.memory))
# ```
#
# ```toml
# [control]
# output = "torque"
# [control.blocks]
# speed = { block = "pll_velocity", bandwidth = 800.0 }
# torque = { block = "notch", signal = "kd*(w - speed)", frequency = 180.0, quality = 2.0 }
# ```
#
# How a memory starts is said for an axis at rest: `MEASURED_POSITION`, `REFERENCE`, a number, or `BALANCED`,
# the value with which the law's output holds the axis there (an integral that carries a load). It is how a
# twin starts. The loop of a record starts with what the record's first controls show of the memory, and with
# its own velocity, so nothing about a record stands in the declaration.
#
# `period` is that of the law, which need not be the log's: a velocity loop at 16 kHz under a log at 1 kHz, or a log
# faster than the loop. The loop is then simulated at the law's period and sampled as the log is. Since a wrong time
# column looks the same, it is to be confirmed, by `sample_period = 1e-3` in its `run.toml` beside the log's own times, or in the
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
print(axisid.estimation.law_agreement(axisid.build(axis), record).sentence)

# %% [markdown]
# The wrong law, with another gain, is told apart, and the factors say in what:

# %%
wrong = replace(axis.control, gains={"p": 39000.0, "i": 50.0, "d": 300.0})
check = axisid.estimation.law_agreement(axisid.build(replace(axis, control=wrong)), record)
print(check.sentence)

# %% [markdown]
# The law is run along the record with each gain a little off, and what is told is the least change of gains that explains
# the control: a law with an integral, a filter or a limit is no sum of products of its gains.
#
# ## Which law does the drive run?
#
# Where the manual is silent, a log tells. `axisid law AXIS LOG`, or `find_law`, starts each form of the ready laws by a
# regression at delays of 0 to 4 samples, finds its gains by runs along half of the rows, in blocks, and ranks them by
# what they leave of the other half. Of laws that leave as little, the one with the fewest gains comes first; a law is
# told once, and not again with more gains or an anti-windup that explain nothing more:

# %%
drive = replace(
    axis,
    control=axisid.control.cascade_p_pi(kp=60.0, kv=243.0, tn=0.03, period=1e-3),
    experiment=replace(axis.experiment, position_noise=1e-7),
)
found = axisid.estimation.find_law(axis, axisid.twin_record(drive))
print(found.best.toml)

# %% [markdown]
# What is found is what the log shows. Laws that give the same control are named beside it (`found.best.same`); a gain that
# the record does not show has no deviation. The law runs at the log's period, and reads the recorded reference and
# position alone: feed-forward columns, sensors of its own and faster inner loops are not tried. Where the drive is at its
# limit, what an integral is after each time there is left open at the start, and clamping and back-calculation, with a time
# of its own or the integral's, are tried: with a third of the samples at the limit the gains of a twin are found exactly. On
# the EMPS record it finds
# the averaged cascade with kp 160.182 and kv 243.395, which leaves 0.234 % of held-out rows; the drive has 160.18
# and 243.45.
#
# The check is part of every result with a law and a reference. If it fails, believe no instruments before
# it is mended; see [Read the diagnostics](reading_the_diagnostics.py).
