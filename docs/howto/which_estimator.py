# %% [markdown]
# # Which estimator when
#
# | | needs | removes | does not remove |
# |---|---|---|---|
# | IDM-LS | position, force or control | | noise in the motion, where the filter lets it through |
# | DDM-LS | the same; constant inertia | | noise in force and motion |
# | IDM-IV | also the reference and the control law | correlation of noise with the regressor | a wrong delay, friction law or control law |
# | DDM-IV | the same; constant inertia | the same | the same: it is IDM-IV, written twice |
# | DIDIM | as IDM-IV | noise in the motion, the filter's own error | a wrong control law, which it rests on |
#
# - **Begin with all**, which is the default. Methods that axis or record do not allow are left out with
#   the reason.
# - **LS and IV agree within the deviations**: noise did no harm. Take either; IDM-LS needs fewer
#   assumptions.
# - **They differ**: noise biases least squares. Lower the cut-off until they agree (`axisid sweep`), or
#   believe the instruments, *if* the control law passes its check and the instruments are strong.
# - **IDM-IV and DDM-IV agree always**, to rounding: they solve the same equations with the same
#   instruments. That is a self-test, and no second opinion.
# - **IDM-IV and DIDIM** are one estimate but for chance, or the check *method* says which to
#   believe, of which the verdict is then. With a coarse encoder, or a cut-off that lets much through, DIDIM scatters less and is not biased;
#   with a control law that is not the drive's, believe the instruments. [How coarse](../encoder.md), on 1400 twins.
# - **No control law, or an open loop**: IDM-LS, at a cut-off low enough. `--validate` with a second record
#   is then the best evidence.
#
# ## Seen on a twin
#
# The mass of the paper's axis, 100.2 kg, under both of the paper's filters:

# %%
import axisid

axis = axisid.build(axisid.load_axis("emps2015"))
record = axisid.twin_record(axis)
for cutoff, decimate in ((60.0, 10), (180.0, 3)):
    result = axisid.identify(axis, record, axisid.Prefilter(cutoff=cutoff, decimate=decimate))
    masses = ", ".join(
        f"{name} {e.parameters['M'].value:.1f} +- {e.parameters['M'].sd_hac:.1f}"
        for name, e in result.estimates.items()
    )
    print(f"{cutoff:g} Hz, 1 of {decimate}: {masses}")
    for check in result.verdict:
        if check.name == "method":
            print(f"    {check.status}: {check.meaning}")

# %% [markdown]
# ## Which model
#
# `axisid compare` fits a ladder of friction laws, or your own candidates, to the same rows, and recommends
# the simplest that explains rows held out as well as the best does:

# %%
print(axisid.compare(axisid.friction_ladder(axis.declared), record))
