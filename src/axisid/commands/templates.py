"""The declaration that `axisid new` starts: complete, commented, and identified at once."""

import contextlib
from importlib.util import find_spec
from pathlib import Path

from axisid.modeling.library import LIBRARY
from axisid.modeling.quantities import check_name
from axisid.support.errors import ModelError, UsageError


def write_scaffold(name: str, *, newton: bool = True, toml: bool = True) -> Path:
    """Write ``NAME.toml`` or ``NAME.py`` into the current folder; return it.

    Raises
    ------
    UsageError
        The name cannot be an axis's or a module's, the file is there already, or the place cannot
        be written to.
    """
    _check(name, toml=toml)
    file = Path(f"{name}.toml" if toml else f"{name}.py")
    try:
        with file.open("x", encoding="utf-8") as stream:
            try:
                stream.write(scaffold(name, newton=newton, toml=toml))
                stream.flush()
            except OSError:
                with contextlib.suppress(OSError):
                    file.unlink()
                raise
    except FileExistsError as error:
        raise UsageError(f"{file} is there already; choose another name or move it.") from error
    except OSError as error:
        raise UsageError(f"{file} cannot be written: {error.strerror}.") from error
    return file


def scaffold(name: str, *, newton: bool, toml: bool) -> str:
    """The text of a declaration."""
    if toml:
        return _TOML[newton].replace("NAME", name)
    return _PYTHON[newton].replace("NAME", name)


def _check(name: str, *, toml: bool) -> None:
    try:
        check_name(name, "the axis")
    except ModelError as error:
        raise UsageError(str(error)) from error
    if name in LIBRARY:
        raise UsageError(f"{name!r} is an axis of the library; choose another name.")
    if not toml and find_spec(name) is not None and not Path(f"{name}.py").exists():
        raise UsageError(f"{name}.py would hide the Python module {name}; choose another name.")


_TOML_NEWTON = """\
# An axis for axisid. It is data: nothing in it is run. Values are SI, on the load side.
#   axisid show NAME.toml               its equation of motion and models
#   axisid identify NAME.toml           its twin: the experiment at the end
#   axisid identify NAME.toml log.csv   your record

name = "NAME"
title = "linear stage"

[coordinate] # its velocity is dx, its acceleration ddx
name = "x"
unit = "m" # or "rad"

[parameters] # what is identified, in this order
# nominal is where instrumental variables start: the inertia needs a fair guess.
m = { unit = "kg", nominal = 5.0, lower = 0.0, description = "moving mass" }
b = { unit = "N/(m/s)", lower = 0.0, description = "viscous friction" }
c = { unit = "N", lower = 0.0, description = "Coulomb friction" }

[newton] # inertia * ddx = tau - sum of resistances; linear in the parameters
inertia = "m"
resistance = [
    "b*dx",
    "c*sign(dx)",
    # others: an offset "tau0", a spring "k*(x - 0.02)", a cogging "a*sin(400*x)"
]
"""

_TOML_LAGRANGE = """\
# An axis for axisid. It is data: nothing in it is run. Values are SI, on the load side.
#   axisid show NAME.toml               its equation of motion and models
#   axisid identify NAME.toml           its twin: the experiment at the end
#   axisid identify NAME.toml log.csv   your record

name = "NAME"
title = "pendulum"

[coordinate] # its velocity is dtheta, its acceleration ddtheta; 0 hangs down
name = "theta"
unit = "rad" # or "m"

[parameters] # what is identified, in this order
# nominal is where instrumental variables start: the inertia needs a fair guess.
J = { unit = "kg m^2", nominal = 0.1, lower = 0.0, description = "inertia about the pivot" }
mgl = { unit = "N m", description = "weight times distance; products are one parameter" }
fv = { unit = "N m/(rad/s)", lower = 0.0, description = "viscous friction" }
fc = { unit = "N m", lower = 0.0, description = "Coulomb friction" }

[lagrange] # d/dt(dT/d dtheta) - dT/dtheta + dV/dtheta + dD/d dtheta = tau + generalised_force
kinetic = "J*dtheta**2/2"
potential = "-mgl*cos(theta)"
dissipation = "fv*dtheta**2/2 + fc*abs(dtheta)"
# generalised_force = "0"
"""

_TOML_DRIVE = """
[drive] # tau = gain * control
gain = GAIN
unit = "A" # of the control
limit = LIMIT # of its size; leave it out for none
# relative_sd = 0.005 # how well the gain is known: 0.5 %
"""

_TOML_CASCADE = """
[control] # evaluated every period and held; instruments come from it, least squares do without
law = "cascade_pd" # kv*(kp*(reference - x) - dx); dx from encoder steps: "cascade_pd_difference"
# (of two samples), "cascade_pd_averaged" (of means). A wrong one is told, with the one that fits.
kp = 50.0 # 1/s
kv = 60.0 # A/(m/s)
period = 1e-3 # s
# A law of your own has no `law` but a name, gains = { ... }, memory = { ... } and an output; see
# axisid new --lagrange.
"""

_TOML_LAW = """
[control] # evaluated every period and held; instruments come from it, least squares do without
# Or one that ships: law = "cascade_pd", kp, kv, period.
name = "PD on encoder differences"
period = 1e-3 # s
gains = { p = 40.0, d = 4.0 }
# What is kept from a sample to the next, and what it is at the first.
memory = { last = { following = "measured_position", start = "measured_position" } }
# Of reference, measured_position, measured_velocity, period, gains and memory.
output = "p*(reference - measured_position) - d*(measured_position - last)/period"
# delay = 1 # whole samples until it is applied
# continuous = true # evaluated all the time; then without memory and delay
"""

_TOML_END = """
[columns] # of your record, by role; without them they are named after their roles
# time = "t"
# position = "pos"
# reference = "ref"
# control = "cmd"

[experiment] # of the twin, a simulated record with known parameters
back_and_forth = { MOVES, repeat = 3 }
# or one by one: moves = [{ distance = 0.1, speed = 0.2, acceleration = 4.0 }, ...]
truth = { TRUTH }
position_noise = NOISE # standard deviation
seed = 1
"""

_STAGE = {
    "GAIN": "18.0",
    "LIMIT": "12.0",
    "MOVES": "speeds = [0.1, 0.3, 0.5], acceleration = 4.0, seconds = 0.5",
    "TRUTH": "m = 6.2, b = 14.0, c = 7.5",
    "NOISE": "1e-6",
}
_PENDULUM = {
    "GAIN": "0.5",
    "LIMIT": "20.0",
    "MOVES": "speeds = [1.0, 2.0, 4.0], acceleration = 40.0, seconds = 0.6",
    "TRUTH": "J = 0.0626, mgl = 1.0, fv = 0.02, fc = 0.09",
    "NOISE": "1e-5",
}


def _filled(text: str, values: dict[str, str]) -> str:
    for name, value in values.items():
        text = text.replace(name, value)
    return text


_TOML = {
    True: _TOML_NEWTON + _filled(_TOML_DRIVE + _TOML_CASCADE + _TOML_END, _STAGE),
    False: _TOML_LAGRANGE + _filled(_TOML_DRIVE + _TOML_LAW + _TOML_END, _PENDULUM),
}

_PYTHON_NEWTON = '''\
"""An axis for axisid; values are SI, on the load side.

axisid show NAME.py                          its equation of motion and models
axisid identify NAME.py           its twin: the experiment at the end
axisid identify NAME.py log.csv   your record
"""

from axisid import Coordinate, Drive, Experiment, Parameter, back_and_forth, newton
from axisid.control import cascade_pd
from axisid.elements import coulomb, viscous

x = Coordinate("x", unit="m")  # or "rad"; x.velocity and x.acceleration are its own
# What is identified. Instrumental variables start from nominal: the inertia needs a fair guess.
m = Parameter("m", "kg", nominal=5.0, lower=0.0, description="moving mass")
b = Parameter("b", "N/(m/s)", lower=0.0, description="viscous friction")
c = Parameter("c", "N", lower=0.0, description="Coulomb friction")

axis = newton(  # inertia * acceleration = tau - sum of resistances
    "NAME",
    title="linear stage",
    coordinate=x,
    parameters=(m, b, c),
    inertia=m,
    # Any SymPy expression that is linear in the parameters, such as k * (x - 0.02).
    resistance=(viscous(b, x), coulomb(c, x)),
    drive=Drive(gain=18.0, unit="A", limit=12.0),  # tau = gain * control
    # Instruments come from the law, least squares do without; a law of your own is a ControlLaw.
    control=cascade_pd(kp=50.0, kv=60.0, period=1e-3),
    # columns={"time": "t", "position": "pos", "reference": "ref", "control": "cmd"},
    experiment=Experiment(  # of the twin, a simulated record with known parameters
        moves=back_and_forth(speeds=(0.1, 0.3, 0.5), acceleration=4.0, seconds=0.5, repeat=3),
        truth={"m": 6.2, "b": 14.0, "c": 7.5},
        position_noise=1e-6,
    ),
)
'''

_PYTHON_LAGRANGE = '''\
"""An axis for axisid; values are SI, on the load side.

axisid show NAME.py                          its equation of motion and models
axisid identify NAME.py           its twin: the experiment at the end
axisid identify NAME.py log.csv   your record
"""

import sympy

from axisid import Coordinate, Drive, Experiment, Parameter, back_and_forth, lagrange
from axisid.control import MEASURED_POSITION, PERIOD, REFERENCE, ControlLaw, Memory, gain

theta = Coordinate("theta", unit="rad")  # or "m"; 0 hangs down
# What is identified. Instrumental variables start from nominal: the inertia needs a fair guess.
J = Parameter("J", "kg m^2", nominal=0.1, lower=0.0, description="inertia about the pivot")
mgl = Parameter("mgl", "N m", description="weight times distance; products are one parameter")
fv = Parameter("fv", "N m/(rad/s)", lower=0.0, description="viscous friction")
fc = Parameter("fc", "N m", lower=0.0, description="Coulomb friction")

# What the law keeps from a sample to the next.
last = Memory("last", following=MEASURED_POSITION, start=MEASURED_POSITION)

axis = lagrange(  # the energies and the dissipation function, linear in the parameters
    "NAME",
    title="pendulum",
    coordinate=theta,
    parameters=(J, mgl, fv, fc),
    kinetic=J * theta.velocity**2 / 2,
    potential=-mgl * sympy.cos(theta.symbol),
    dissipation=fv * theta.velocity**2 / 2 + fc * sympy.Abs(theta.velocity),
    drive=Drive(gain=0.5, unit="A", limit=20.0),  # tau = gain * control
    # Instruments come from the law, least squares do without.
    control=ControlLaw(
        name="PD on encoder differences",
        period=1e-3,
        gains={"p": 40.0, "d": 4.0},
        output=gain("p") * (REFERENCE - MEASURED_POSITION)
        - gain("d") * (MEASURED_POSITION - last.symbol) / PERIOD,
        memory=(last,),
    ),
    # columns={"time": "t", "position": "pos", "reference": "ref", "control": "cmd"},
    experiment=Experiment(  # of the twin, a simulated record with known parameters
        moves=back_and_forth(speeds=(1.0, 2.0, 4.0), acceleration=40.0, seconds=0.6, repeat=3),
        truth={"J": 0.0626, "mgl": 1.0, "fv": 0.02, "fc": 0.09},
        position_noise=1e-5,
    ),
)
'''

_PYTHON = {True: _PYTHON_NEWTON, False: _PYTHON_LAGRANGE}
