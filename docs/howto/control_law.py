# %% [markdown]
# # Declare the control law
#
# Instrumental variables (IV) come from the simulated closed loop, so they need the control law of the drive. Least
# squares does not. A law is a difference equation, evaluated once per period; its output is held. The essential detail
# is *how the drive computes its velocity*. On the EMPS machine, a plain backward difference of the encoder differs from
# the recorded control by 3.3 %, the mean of two neighbouring samples by 0.24 %.
#
# ## A built-in law
#
# | law | equation or use |
# |---|---|
# | `cascade_pd(kp, kv, period)` | `kv*(kp*(reference - position) - velocity)`, ideal velocity |
# | `cascade_pd_difference`, `cascade_pd_averaged` | the same, velocity from differences of encoder positions, plain or averaged |
# | `cascade_p_pi(kp, kv, tn, period)` | position loop over a velocity loop with an integral; feed-forward, speed limit, velocity filters, anti-windup: ODrive, SimpleFOC, most drives |
# | `pid(kp, ki, kd, period)`, `pid_ideal(k, ti, td, period)` | the two forms of a PID, with a filtered derivative and anti-windup |
# | `impedance(kp, kd, period)` | a virtual spring and damper: moteus, the MIT mode of T-Motor |
# | `state_feedback(k_position, k_velocity, period)` | with a gain of the reference and an integral |
# | `dynamixel_position(p, i, d, ff1, ff2, period)` | gains from the registers of a Dynamixel X; the output is a PWM |
#
# All are in `axisid.control`. The [docstring](../api/modelling.md) of each has its equation, its units and the factors
# that convert the gains of drive makers. In TOML:
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
# A feed-forward may use differences of the reference or recorded columns: `reference_velocity=Signal("speed", "m/s")`,
# `feed_forward=...`. In TOML it is the name of a signal, or an expression of signals and `[constants]`.
# `axisid law AXIS LOG` finds the built-in law and its gains from a log ([how](#which-law-does-the-drive-run)).
#
# ## A law of your own
#
# The output may use `REFERENCE`, `MEASURED_POSITION`, `MEASURED_VELOCITY` (an ideal sensor), `PERIOD`, the
# gains and memories. Each memory has an expression for its next sample (`following`) and a start value. Example:
# a PID with an integrator and a velocity from encoder differences.

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
# Filters and limits are blocks. Each has a value and its memories: `low_pass`, `notch`, `pll_velocity`, `rate_limit`,
# `difference`, `reference_velocity`, `reference_acceleration`. The anti-windup of an `integral`
# compares `UNLIMITED_OUTPUT`, the law's own output, with `LIMITED_OUTPUT`, this output within the drive's limit. Your own
# memories may use both. Do not repeat the expression of the output instead: it would differ by rounding.
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
# The start value of a memory is declared for an axis at rest: `MEASURED_POSITION`, `REFERENCE`, a number, or `BALANCED`.
# With `BALANCED` the output of the law holds the axis at rest (an integral that carries a load). A twin starts with this
# value. The simulated loop of a record starts with the memory that the first recorded controls show, and with the
# recorded velocity. So the declaration contains nothing about a record.
#
# `period` is the period of the law. The log may have another one: a velocity loop at 16 kHz and a log at 1 kHz, or a log
# faster than the loop. The loop is then simulated at the law's period and sampled at that of the log. A wrong
# time column looks the same, so confirm the difference by one of these:
#
# - `sample_period = 1e-3` in the `run.toml`, in addition to the log's own times;
# - `reference_between="spline"`, `"linear"` or `"held"` in the declaration: the law has its own clock,
#   and the reference is interpolated this way between the samples of a slower log (default: a spline).
#
# With a held reference, the control is a sawtooth, of which the log shows one edge. The mean, which moves the
# axis, is then computed from the law. A continuous law accepts any log.
#
# `delay=2` applies each control two samples late. `continuous=True` evaluates the law inside the plant's
# derivative, without memory. The drive's `limit` clips the control.
#
# ## Check it with a record
#
# You need no data sheet. The terms of the law, computed from the recorded reference and position,
# must add up to the recorded control. Here a twin with the law above is the record:

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
# A law with a wrong gain fails, and the factors show which gain is wrong:

# %%
wrong = replace(axis.control, gains={"p": 39000.0, "i": 50.0, "d": 300.0})
check = axisid.estimation.law_agreement(axisid.build(replace(axis, control=wrong)), record)
print(check.sentence)

# %% [markdown]
# A law with an integral, a filter or a limit is not a sum of products of its gains. Therefore the law is evaluated along
# the record with each gain changed a little, and the smallest change of gains that explains the control is reported.
#
# ## Which law does the drive run?
#
# If the manual does not say it, use a log. `axisid law AXIS LOG`, or `find_law`, starts each form of the built-in laws by a
# regression at delays of 0 to 4 samples. It fits the gains by evaluations along half of the rows, in blocks, and ranks the
# laws by their residual on the other half. Of laws with equal residuals, the one with the fewest gains is first. A law
# is reported once, not again with more gains or an anti-windup that explain nothing more:

# %%
drive = replace(
    axis,
    control=axisid.control.cascade_p_pi(kp=60.0, kv=243.0, tn=0.03, period=1e-3),
    experiment=replace(axis.experiment, position_noise=1e-7),
)
found = axisid.estimation.find_law(axis, axisid.twin_record(drive))
print(found.best.toml)

# %% [markdown]
# The search finds only what the log shows. Laws that give the same control are listed (`found.best.same`). A gain that
# the record does not show has no standard error. The law is evaluated at the log's period, and uses only the recorded
# reference and position. Feed-forward columns, sensors of the law's own and faster inner loops are not tried.
#
# If the drive reaches its limit, the value of an integral after each saturation is free at first. Then clamping and
# back-calculation (with its own time or the integral's) are tried. With a third of the samples at the limit, the
# gains of a twin are found exactly. On the EMPS record, the search finds the averaged cascade with kp 160.182 and kv
# 243.395 and a residual of 0.234 % on held-out rows; the drive has 160.18 and 243.45.
#
# The law check is part of every result with a law and a reference. If it fails, correct the law before you use IV
# estimates; see [Read the diagnostics](reading_the_diagnostics.py).
