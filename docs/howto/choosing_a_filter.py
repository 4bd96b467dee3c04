# %% [markdown]
# # Choose the filter
#
# One setting decides more than the estimator: the cut-off of the low-pass on the position. Too low, and it
# rounds the motion, most where friction reverses. Too high, and noise reaches velocity and acceleration,
# where it biases least squares.
#
# **Rule of thumb**: 3 to 10 times the bandwidth of the position loop. Of the rows, one in N is kept such
# that the decimation's edge, 0.4 times the sampling frequency over N, is at or below the cut-off; then
# force and motion are filtered alike. Left open, N is 10, or more where that asks for it.
#
# ## Let the record decide
#
# `axisid sweep` identifies at many cut-offs, the decimation following along. Least squares drifts from
# where noise begins to bias it; instruments stay.

# %%
from textwrap import fill

import axisid
from axisid.estimation import default_cutoffs

axis = axisid.build(axisid.load_axis("emps2015"))
record = axisid.twin_record(axis)
swept = axisid.sweep(axis, record, default_cutoffs(1 / record.period, points=8))
print(fill(swept.recommendation, 88))
swept.plot()

# %% [markdown]
# Where there is little noise, many cut-offs do: their intervals overlap, and the rule of thumb is as good as the
# recommendation. On a terminal: `axisid sweep AXIS LOG --figure sweep.png`. A report contains it.
#
# ## What filter and noise do
#
# The loop simulated with the estimate, with the noise of the record, is a twin of the record. What the same filter and estimator make
# of many twins should be the estimate; the difference is the bias of filter and noise, which no standard deviation counts. It
# is with each value, and `corrected` is free of it:

# %%
kept = axisid.Prefilter(cutoff=60.0, decimate=10, reversals="keep")
result = axisid.identify(axis, record, kept)
for name, value in result["idm-iv"].parameters.items():
    print(f"{name}: {value.value:.4g} +- {value.deviation:.2g}, bias {value.filter_bias:+.2g}")

# %% [markdown]
# Most of it is rounding where friction reverses. Without those samples, as by default, little is left:

# %%
result = axisid.identify(axis, record, axisid.Prefilter(cutoff=60.0, decimate=10))
for name, value in result["idm-iv"].parameters.items():
    print(f"{name}: {value.value:.4g} +- {value.deviation:.2g}, bias {value.filter_bias:+.2g}")

# %% [markdown]
# ## The other settings
#
# | setting | |
# |---|---|
# | `hold` | `zoh` pairs each acceleration with the mean of the forces that the drive held before and after the sample; `raw` with the force after it, half a sample late. The default is zoh for a control that is held, raw for a measured force or a continuous law. |
# | `drop` | Samples left out at both ends. By default the whole record is filtered, and the ends, as long as the low-pass takes to settle, have no weight in any row. Ends that are named are cut before the decimation, as the published recipe of EMPS has it: the decimation then continues the record from the last sample kept, which gives that sample much weight. |
# | `reversals` | Samples near a reversal or a rest have no weight: there the low-pass rounds what friction does at once, and at rest noise decides its sign. `keep` keeps them, as the published recipes do; so does the default where a parameter would otherwise lose more than a third of its information, as an inertia does where the axis accelerates only as it turns, or Coulomb friction at a low cut-off. How long the axis rests does not matter. |
# | `decimation` | `matlab` aligns the rows to the end of the record, `scipy` to its start. |
# | `order` | Of the Butterworth low-pass, applied forward and backward. 4 does. |
#
# ## Sharp terms
#
# A narrow cogging or a stop changes faster than the low-pass follows, whenever the axis passes it. Such
# terms come out biased by every method. Move slowly there, or raise the cut-off and keep the decimation.
# A Stribeck peak is passed at reversals, which are left out.
