# %% [markdown]
# # Which estimator when
#
# | method | needs | removes bias from | does not remove bias from |
# |---|---|---|---|
# | IDM-LS | position, force or control | | noise in the motion that passes the filter |
# | DDM-LS | the same; constant inertia | | noise in force and motion |
# | IDM-IV | also the reference and the control law | correlation of noise with the regressor | a wrong delay, friction law or control law |
# | DDM-IV | the same; constant inertia | the same | the same: its equations are those of IDM-IV |
# | DIDIM | as IDM-IV | noise in the motion, the filter | a wrong control law |
#
# - **Begin with all**, which is the default. Methods that axis or record do not allow are left out with
#   the reason.
# - **IDM-LS and IDM-IV agree within chance**: noise does not bias least squares (LS) noticeably. Use either; IDM-LS needs
#   fewer assumptions than instrumental variables (IV).
# - **IDM-LS and IDM-IV disagree because of noise**: LS is biased. Lower the cut-off until they agree (`axisid sweep`), or
#   use IV, *if* the control law passes its check and the instruments are strong.
# - **IDM-IV and DDM-IV always agree**, to rounding: they solve the same equations with the same
#   instruments. This is a self-test, not an independent check.
# - **IDM-IV and DIDIM** agree within chance, or the check *method* names likely causes. It says which of the two is
#   reported, and why: DIDIM if the recorded control follows the declared law. With a coarse encoder or a high cut-off,
#   DIDIM scatters less and is not biased. With a wrong control law, use IV.
#   [Effect of the encoder](../encoder.md), on 1400 twins.
# - **No control law, or an open loop**: use IDM-LS with a low cut-off. `--validate` with a second record
#   is then the best evidence.
#
# ## Example on a twin
#
# The mass of the paper's axis, 100.2 kg, with both filters of the paper:

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
            print(f"    {check.status}: {check.meaning}.")

# %% [markdown]
# ## Which model
#
# `axisid compare` fits a ladder of friction laws, or your own candidates, to the same rows. It recommends the simplest
# candidate that explains held-out rows as well as the best one:

# %%
print(axisid.compare(axisid.friction_ladder(axis.declared), record))
