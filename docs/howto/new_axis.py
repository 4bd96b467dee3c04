# %% [markdown]
# # Declare a new axis
#
# An axis has one coordinate, parameters with units, an equation of motion and a drive. Instrumental variables (IV) also
# need the control law. `axisid new NAME` writes a commented file (`--toml` or `--python`, `--newton` or `--lagrange`).
# TOML is read, never run. Python can use all of SymPy. Both declare the same axes.
#
# Conventions: SI, on the load side. `tau = inertia * ddq + resistances`: a positive friction parameter opposes a
# positive velocity. `tau = gain * control`.
#
# ## By Newton
#
# The example is a vertical ball-screw stage. Gravity acts on its weight minus the counterbalance. Viscous friction
# differs between directions. Elements are added up. The docstring of each has its formula, units and a
# reference (`help(axisid.elements.asymmetric_viscous)`).

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
# Units are checked term by term. An error names both units:

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
# A plain number such as `9.81` has no unit. A term that does not fit for this reason is accepted, and
# `axis.unchecked_terms` lists it. `axisid.elements.G`, or `Constant(0.25, "m", "arm")`, is checked.
#
# Parameters that no motion can separate are reported before you measure. An example is separate Coulomb friction for
# each direction, together with a weight:

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
# The example is a pendulum: a rod with a mass on it. Declare the energies. `potential` contains gravity and
# springs, `dissipation` half of the viscous and all of the Coulomb power.

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
# says which physical parameters follow. If some values are known independently, others follow from them, with
# their uncertainty:

# %%
known = axisid.fix(rod, mass=(0.512, 0.001), J=0.021)
print(axisid.modeling.describe_determined(axisid.derive(known).base))

# %% [markdown]
# ## Nonlinear parameters
#
# A Stribeck velocity or an exponent is not a linear parameter, but you can declare it. A search finds such
# parameters from their nominal values, within their bounds; the linear parameters are solved at each step (variable
# projection). IV starts from the result. The direct model is then not linear, so there is no DDM estimate, and the
# program says so.

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
# An inertia that depends on the position (a crank) is declared as an expression too. The inverse model stays
# linear in the parameters; the direct model does not.
#
# ## Try it before you have a log
#
# With an *experiment* an axis has a twin: a simulated record with known parameters and noise. It shows whether the
# motion identifies every parameter, before you run it on the machine.

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
# manifest. Keep them under version control. `axisid generate my_axis.py --output my_code --check` checks that they are current.
