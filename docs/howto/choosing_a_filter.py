# %% [markdown]
# # Choose the filter
#
# One setting matters more than the estimator: the cut-off of the low-pass on the position. If the cut-off is too
# low, the filter rounds the motion, most at friction reversals. If it is too high, noise reaches velocity and
# acceleration, and biases least squares.
#
# **Rule of thumb**: choose 3 to 10 times the bandwidth of the position loop. Decimation keeps one row in N. Its edge,
# 0.4 times the sampling frequency over N, should be at or below the cut-off; then force and motion are filtered
# equally. By default N is 10, or more if the cut-off needs it.
#
# ## Let the record decide
#
# `axisid sweep` identifies at many cut-offs, with the decimation adjusted. Least squares drifts when noise begins to
# bias it; instrumental variables (IV) do not.

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
# With little noise, many cut-offs are suitable: their intervals overlap, and the rule of thumb is as good as the
# recommendation. On a terminal: `axisid sweep AXIS LOG --figure sweep.png`. A report contains this figure.
#
# ## Bias of filter and noise
#
# A simulated replica of the record is the closed loop simulated with the estimate and the noise of the record. The same
# filter and estimator, applied to many replicas, should give the estimate again. The difference is the bias of filter and
# noise, which no standard error contains. Each value has this bias; `corrected` is the value without it:

# %%
kept = axisid.Prefilter(cutoff=60.0, decimate=10, reversals="keep")
result = axisid.identify(axis, record, kept)
for name, value in result["idm-iv"].parameters.items():
    print(f"{name}: {value.value:.4g} +- {value.deviation:.2g}, bias {value.filter_bias:+.2g}")

# %% [markdown]
# Most of the bias is rounding at friction reversals. Without those samples (the default) it is small:

# %%
result = axisid.identify(axis, record, axisid.Prefilter(cutoff=60.0, decimate=10))
for name, value in result["idm-iv"].parameters.items():
    print(f"{name}: {value.value:.4g} +- {value.deviation:.2g}, bias {value.filter_bias:+.2g}")

# %% [markdown]
# ## The other settings
#
# | setting | effect |
# |---|---|
# | `hold` | `zoh` pairs each acceleration with the mean of the forces held before and after the sample; `raw` pairs it with the force after the sample, half a sample late. The default is `zoh` for a held control, `raw` for a measured force or a continuous law. |
# | `drop` | Samples left out at both ends. By default the whole record is filtered, and the ends, as long as the settling time of the low-pass, have no weight in any row. Explicit ends are cut before the decimation, as in the published recipe of EMPS. The decimation then continues the record from the last kept sample, which gives that sample much weight. |
# | `reversals` | Samples near a reversal or a standstill have no weight: there the low-pass rounds sudden changes of friction, and at standstill noise decides its sign. `keep` keeps them, as in published recipes. So does the default if a parameter would otherwise lose more than a third of its information: an inertia if the axis accelerates only at reversals, or Coulomb friction at a low cut-off. The duration of a standstill does not matter. |
# | `decimation` | `matlab` aligns the rows to the end of the record, `scipy` to its start. |
# | `order` | Order of the Butterworth low-pass, applied forward and backward. 4 is enough. |
#
# ## Sharp terms
#
# A narrow cogging or a stop changes faster than the low-pass can follow. Every method estimates such terms with a bias.
# Move slowly there, or raise the cut-off and keep the decimation. The axis passes a Stribeck peak at reversals, which
# are left out.
