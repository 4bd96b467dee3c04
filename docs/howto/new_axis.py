# %% [markdown]
# # Declare a new axis
#
# An axis is one coordinate, parameters with units, an equation of motion, and a drive; for instruments
# also the control law. `axisid new NAME` starts a file with comments (`--toml` or `--python`, `--newton` or
# `--lagrange`). TOML is read, never run; Python can do whatever SymPy can. Both serve alike.
#
# Conventions: SI, on the load side. `tau = inertia * ddq + resistances`, so that a positive friction
# parameter opposes a positive velocity, and `tau = gain * control`.
#
# ## By Newton
#
# A vertical ball-screw stage, with gravity on what the counterbalance leaves, and viscous friction that
# differs by direction. Elements are added up; each has its formula, units and a reference in its
# docstring (`help(axisid.elements.asymmetric_viscous)`).

# %%
from textwrap import fill

import axisid
from axisid import Coordinate, Parameter, elements, newton

z = Coordinate("z", unit="m")
m = Parameter("m", "kg", nominal=20.0, lower=0.0)
up, down = Parameter("up", "N/(m/s)"), Parameter("down", "N/(m/s)")
fc = Parameter("fc", "N")
w = Parameter("w", "N", description="weight less counterbalance")

vertical = newton(
    "vertical",
    coordinate=z,
    parameters=(m, up, down, fc, w),
    inertia=m,
    resistance=(
        elements.asymmetric_viscous(up, down, z),
        elements.coulomb(fc, z),
        elements.offset(w),
    ),
    drive=elements.Drive(gain=120.0, unit="A", limit=10.0),
)
print(vertical.force)

# %% [markdown]
# Units are checked term by term. A mistake is named with both units:

# %%
try:
    newton(
        "wrong",
        coordinate=z,
        parameters=(m, fc),
        inertia=m,
        resistance=(elements.coulomb(fc, z), m * z.velocity),
        drive=elements.Drive(gain=120.0, unit="A"),
    )
except axisid.ModelError as error:
    print(error)

# %% [markdown]
# A plain number such as `9.81` has no unit; where the term does not fit without one it passes, and
# `axis.unchecked_terms` lists it. `axisid.elements.G`, or `Constant(0.25, "m", "arm")`, is checked.
#
# What no motion can tell apart is said before anything is measured. Coulomb friction of its own in each
# direction, and a weight beside it:

# %%
left, right = Parameter("left", "N"), Parameter("right", "N")
doubtful = newton(
    "doubtful",
    coordinate=z,
    parameters=(m, left, right, w),
    inertia=m,
    resistance=(elements.asymmetric_coulomb(left, right, z), elements.offset(w)),
    drive=elements.Drive(gain=120.0, unit="A", limit=10.0),
)
for sentence in axisid.modeling.describe_unidentifiable(axisid.derive(doubtful).base):
    print(fill(sentence, 88))

# %% [markdown]
# ## By Lagrange
#
# A pendulum that is a rod with a mass on it. The energies are enough; `potential` holds gravity and
# springs, `dissipation` half the viscous and all of the Coulomb power.

# %%
import sympy

from axisid import lagrange
from axisid.elements import Drive, G

q = Coordinate("q", unit="rad")
J = Parameter("J", "kg m^2", nominal=0.02)
mass = Parameter("mass", "kg", nominal=0.5)
length = Parameter("length", "m", nominal=0.4)
tc = Parameter("tc", "N m")

rod = lagrange(
    "rod",
    coordinate=q,
    parameters=(J, mass, length, tc),
    kinetic=(J + mass * length**2) * q.velocity**2 / 2,
    potential=-mass * G * length * sympy.cos(q.symbol),
    dissipation=tc * sympy.Abs(q.velocity),
    drive=Drive(gain=0.5, unit="A"),
)
model = axisid.derive(rod)
for base, expression in model.base.combined:
    print(f"{base.name} = {expression}  [{base.unit}]")

# %% [markdown]
# The parameters enter as products and sums. A record shows only these *base parameters*; `axisid show`
# says which physical ones follow. What is known apart from the record makes the others follow, with its
# uncertainty:

# %%
known = axisid.fix(rod, mass=(0.512, 0.001), J=0.021)
print(axisid.modeling.describe_determined(axisid.derive(known).base))

# %% [markdown]
# ## What enters nonlinearly
#
# A Stribeck velocity or an exponent cannot be a linear parameter. It is accepted all the same: such
# parameters are searched for from their nominal value, within their bounds, around the linear rest
# (variable projection), and by instruments from there. The direct model is not linear then, so there is
# no DDM estimate, and the program says so.

# %%
x = Coordinate("x", unit="m")
M = Parameter("M", "kg", nominal=10.0)
b, c, s = Parameter("b", "N/(m/s)"), Parameter("c", "N"), Parameter("s", "N")
vs = Parameter("vs", "m/s", nominal=0.01, lower=1e-3, upper=0.1)

stribeck = newton(
    "stribeck_stage",
    coordinate=x,
    parameters=(M, b, c, s, vs),
    inertia=M,
    resistance=(
        elements.viscous(b, x),
        elements.coulomb(c, x),
        elements.stribeck(s, x, velocity=vs),
    ),
    drive=Drive(gain=18.0, unit="A", limit=12.0),
)
print(axisid.derive(stribeck).ddm)

# %% [markdown]
# An inertia that depends on the configuration (a crank) is declared the same way: just write it. The
# inverse model stays linear in the parameters; the direct one does not.
#
# ## Try it before you have a log
#
# With an *experiment* an axis has a twin: a simulated record with known parameters and noise. Whether the
# motion shows every parameter is known before it is run on the machine.

# %%
from dataclasses import replace

experiment = axisid.modeling.Experiment(
    moves=axisid.modeling.back_and_forth(
        speeds=(0.1, 0.3), acceleration=4.0, seconds=0.5, repeat=3
    ),
    truth={"m": 21.0, "up": 60.0, "down": 45.0, "fc": 14.0, "w": 25.0},
    position_noise=2e-6,
)
law = axisid.control.cascade_pd(kp=50.0, kv=20.0, period=1e-3)
twin = replace(vertical, control=law, experiment=experiment)
result = axisid.identify(twin, axisid.twin_record(twin), methods=["idm-ls", "idm-iv"])
print(result)

# %% [markdown]
# ## Keep the generated code
#
# `axisid generate my_axis.py --output my_code` writes its CasADi functions, its C, its equations and a
# manifest. Keep them under version control: `axisid generate my_axis.py --output my_code --check` says whether they are current.
