"""A TOML declaration is the Python one as data; all its mistakes are told at once."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy
from hypothesis import given, strategies as st

import axisid.elements
from axisid import Coordinate, ModelError, Parameter, build, derive, fix, load_axis, newton
from axisid.codegen.generated_axes.texts import axis_artefacts
from axisid.elements import State
from axisid.modeling.declaration import ELEMENTS, Move
from axisid.modeling.declaration.axis import Axis
from axisid.support.errors import DeclarationError
from tests.bounded import within
from tests.files import text_file
from tests.refusals import refuses

EMPS2015 = """
name = "emps2015"
title = "EMPS as in the paper of 2015"
coordinate = { name = "q", unit = "m" }

[parameters]
M = { unit = "kg", nominal = 100, lower = 0, description = "mass" }
Fv = { unit = "N/(m/s)", lower = 0, description = "viscous friction" }
Fc = { unit = "N", lower = 0, description = "Coulomb friction" }

[newton]
inertia = "M"
resistance = ["Fv*dq", "Fc*sign(dq)"]

[drive]
gain = 35.15
unit = "V"
limit = 10.0

[control]
law = "cascade_pd"
kp = 160.18
kv = 243.45
period = 1e-3

[experiment]
back_and_forth = { speeds = [0.05, 0.1, 0.15], acceleration = 0.75, seconds = 0.3, repeat = 3 }
truth = { M = 100.2, Fv = 236.9, Fc = 24.8 }
position_noise = 3.8e-6
seed = 2015
"""

PENDULUM = """
name = "swing"
title = "pendulum with Coulomb friction"

[coordinate]
name = "theta"
unit = "rad"

[parameters.J]
unit = "kg m^2"
nominal = 0.1
lower = 0.0
description = "inertia about the pivot"

[parameters]
mgl = { unit = "N m", description = "weight times distance to the centre of gravity" }
fv = { unit = "N m/(rad/s)", lower = 0.0 }
fc = { unit = "N m", lower = 0.0 }

[lagrange]
kinetic = "J*dtheta**2/2"
potential = "-mgl*cos(theta)"
dissipation = '''
  fv*dtheta**2/2
  + fc*abs(dtheta)
'''

[drive]
gain = 0.5
unit = "A"
limit = 20

[control]
name = "PD on encoder differences"
period = 1e-3
gains = { p = 40.0, d = 4.0 }
output = "p*(reference - measured_position) - d*(measured_position - last)/period"
memory = { last = { following = "measured_position", start = "measured_position" } }

[experiment]
back_and_forth = { speeds = [1, 2, 4], acceleration = 40, seconds = 0.6, repeat = 3 }
truth = { J = 0.0626, mgl = 1.0, fv = 0.02, fc = 0.09 }
position_noise = 1e-5
"""

Loader = Callable[..., Axis]


@pytest.fixture
def load(tmp_path: Path) -> Loader:
    def loaded(text: str | bytes, *changes: tuple[str, str]) -> Axis:
        for old, new in changes:
            assert isinstance(text, str)
            assert old in text
            text = text.replace(old, new)
        file = tmp_path / "axis.toml"
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        return load_axis(file)

    return loaded


def mistakes(load: Loader, text: str | bytes, *changes: tuple[str, str]) -> list[str]:
    with pytest.raises(DeclarationError) as refusal:
        load(text, *changes)
    assert refusal.value.exit_code == 4
    assert all(
        mistake in str(refusal.value).replace("\n  ", "\n") for mistake in refusal.value.mistakes
    )
    return list(refusal.value.mistakes)


@pytest.mark.parametrize(("text", "other"), [(EMPS2015, "emps2015"), (PENDULUM, "pendulum")])
def test_toml_and_python_are_the_same_axis_and_generate_the_same_text(
    load: Loader, root: Path, text: str, other: str
) -> None:
    file = root / "examples" / f"{other}.py"
    python = load_axis(file if file.is_file() else other)
    toml = load(text)
    assert toml == python
    assert axis_artefacts(derive(toml)) == axis_artefacts(derive(python))


def test_what_is_known_of_a_parameter_is_declared_as_fix_does(load: Loader) -> None:
    known = ("nominal = 100,", "nominal = 100, known = 98.5, known_sd = 0.2,")
    assert load(EMPS2015, known) == fix(load(EMPS2015), M=(98.5, 0.2))
    assert load(EMPS2015, ("nominal = 100,", "nominal = 100, known = 98,")) == fix(
        load(EMPS2015), M=98.0
    )
    told = mistakes(load, EMPS2015, ("nominal = 100,", "nominal = 100, known_sd = 0.2,"))
    assert any("parameters.M.known_sd: " in each and "with a known value" in each for each in told)
    told = mistakes(load, EMPS2015, ("nominal = 100,", "nominal = 100, known = inf,"))
    assert any(
        "parameters.M.known: the known value of parameter 'M' is inf" in each for each in told
    )


def test_every_feature_of_a_law_and_an_experiment_is_reachable(load: Loader) -> None:
    axis = load(
        EMPS2015,
        ("limit = 10.0", "limit = inf\nrelative_sd = 0.005"),
        (
            'law = "cascade_pd"\nkp = 160.18\nkv = 243.45',
            'name = "p"\noutput = "P*total"\ndelay = 2',
        ),
        (
            "period = 1e-3",
            "period = 1e-3\n[control.gains]\nP = 3\n[control.memory]\n"
            'total = { following = "total + reference", start = 0.5 }\n'
            'old = { following = "total", start = "2*measured_position" }\n'
            '[columns]\ntime = "t"\nforce = "F"',
        ),
        (
            "back_and_forth = { speeds = [0.05, 0.1, 0.15], acceleration = 0.75, seconds = 0.3, "
            "repeat = 3 }",
            "moves = [{ distance = 1, speed = 2, acceleration = 3, dwell = 0.5 }]",
        ),
    )
    law, experiment = axis.control, axis.experiment
    assert (law.name, law.delay, dict(law.gains), law.period) == ("p", 2, {"P": 3.0}, 1e-3)
    assert [(m.name, str(m.following), str(m.start)) for m in law.memory] == [
        ("total", "reference + total", "0.500000000000000"),
        ("old", "total", "2*measured_position"),
    ]
    assert experiment.moves == (Move(1, 2, 3, dwell=0.5),)
    assert dict(axis.columns) == {"time": "t", "force": "F"}
    assert (axis.drive.relative_sd, axis.drive.limit) == (0.005, float("inf"))
    continuous = load(EMPS2015, ("period = 1e-3", "period = 1e-3\ncontinuous = true")).control
    assert continuous.continuous
    averaged = load(EMPS2015, ('"cascade_pd"', '"cascade_pd_averaged"')).control
    emps = load_axis("emps").control
    assert averaged == replace(emps, gains={"kp": 160.18, "kv": 243.45})


def test_an_axis_needs_no_law_no_columns_and_no_experiment(load: Loader) -> None:
    axis = load(EMPS2015.partition("[control]")[0])
    assert (axis.control, axis.experiment, dict(axis.columns)) == (None, None, {})


def test_all_mistakes_are_told_at_once_each_with_its_place(load: Loader) -> None:
    told = mistakes(
        load,
        EMPS2015,
        ("title =", "titel ="),
        ('unit = "m" }', 'unit = "mm" }'),
        ("nominal = 100", 'nominal = "100"'),
        ("N/(m/s)", "N/(mm/s)"),
        ('"Fv*dq"', '"Fv*dqq"'),
        ("Fc*sign(dq)", "Fc*__import__('os').system('x')"),
        ("gain = 35.15", "gain = 0"),
        ("limit = 10.0", "limit = -10.0"),
        ("kp = 160.18\n", ""),
        ("period = 1e-3", "period = -1e-3"),
        ("[experiment]", '[columns]\nspeed = "v"\n[experiment]'),
        ("0.75", "-0.75"),
        ("repeat = 3", "repeat = 1000000000"),
        ("Fv = 236.9", "Fw = 236.9"),
        ("seed = 2015", "seed = 1.5"),
        ("3.8e-6", "-1"),
    )
    for pattern in (
        "titel: the key is unknown. Known keys are name, title, .* Did you mean 'title'",
        "coordinate.unit: .*'mm'",
        "parameters.M.nominal: the value is '100'. Give a number",
        "parameters.Fv.unit: the unit 'N/.mm/s.' cannot be read at 'mm'",
        r"newton.resistance\[1\]: column 4: the name dqq is not known.* Did you mean 'dq'",
        r"newton.resistance\[2\]: column 15: .*cannot be used",
        "drive.gain: ",
        "drive.limit: ",
        "control.kp: the key is missing",
        "control.period: .*not positive",
        "columns.speed: the key is unknown. Known keys are time, position",
        "experiment.back_and_forth.acceleration: ",
        "experiment.back_and_forth.repeat: ",
        "experiment.truth.Fw: the key is unknown. Known keys are M, Fv, Fc",
        "experiment.seed: the value is 1.5. Give a whole number",
        "experiment.position_noise: ",
    ):
        assert any(re.match(pattern, mistake) for mistake in told), pattern
    assert len(told) == 16


@pytest.mark.parametrize(
    ("changes", "mistake"),
    [
        ([("[newton]", "[lagrange]\nkinetic = 0\n[newton]")], "2 of the tables newton and"),
        ([('"M"', '"M*q"')], "the inertia M\\*q depends on q"),
        ([('"Fc*sign(dq)"', "0")], "the parameters Fc are declared but do not appear"),
        ([('"Fc*sign(dq)"', "true")], r"newton.resistance\[2\]: the value is True. Give a number"),
        ([('"Fc*sign(dq)"', "{}")], r"newton.resistance\[2\]: the value is {}. Give an expression"),
        ([("M = {", "double = {")], "parameters.double: .*keyword of C"),
        ([("M = {", "m = 5\nM = {")], "parameters.m: the value is 5. Give a table"),
        ([('"emps2015"', '"a b"')], "name: the axis is named 'a b'"),
        ([("as in", r"\u001b[31m")], "title: .*one line of text"),
        ([('"cascade_pd"', '"cascade"')], "control.law: there is no law 'cascade'.*cascade_pd"),
        ([('"cascade_pd"', "[1]")], "control.law: there is no law"),
        (
            [("back_and_forth", "moves = []\nback_and_forth")],
            "experiment: the table has 2 of the keys moves and",
        ),
        ([("kp = 160.18", "kp = nan")], "control.kp: the value is nan. Give a number"),
        ([("kp = 160.18", "kp = 1979-05-27")], "control.kp: .*Give a number"),
        ([("gain = 35.15", "gain = [1]")], r"drive.gain: the value is \[1\]. Give a number"),
        ([('unit = "kg"', 'unit = "' + "(" * 2000 + '"')], "at most 60 characters"),
        ([('unit = "kg"', "unit = 3")], "parameters.M.unit: the value is 3. Give one line of text"),
        ([("2015\n", "true\n")], "experiment.seed: the value is True"),
        ([("[0.05, 0.1, 0.15]", "[]")], "experiment.back_and_forth: the experiment has no moves"),
        ([("[0.05", '["slow"')], r"experiment.back_and_forth.speeds\[1\]: the value is 'slow'"),
        (
            [('unit = "V"', 'kind = "voltage_drive"\nresistance = {}')],
            "drive.resistance: the value is {}",
        ),
    ],
)
def test_one_mistake_is_told_with_its_place(
    load: Loader, changes: list[tuple[str, str]], mistake: str
) -> None:
    assert re.search(mistake, "\n".join(mistakes(load, EMPS2015, *changes)))


@pytest.mark.parametrize(
    ("content", "code", "says"),
    [
        (b"", "declaration", "5 mistakes"),
        (
            b"inertia = m\n",
            "declaration",
            r"not valid TOML: Invalid value \(at line 1, column 11\).*quotes",
        ),
        (b"a = { b = 1 c = 2 }", "declaration", "not valid TOML: .*line 1, column 13"),
        (b"a = 1\na = 2", "declaration", "not valid TOML"),
        (
            b"drive.gain = " + b"9" * 2400,
            "declaration",
            "drive.gain: the value is a whole number of 2400 digits",
        ),
        (b"name = '\xe9'", "declaration", "not valid TOML: .*utf-8.* byte 0xe9"),
        (b"\x00\xff" * 50, "declaration", ""),
        (b"\x7fELF\x01", "declaration", "not valid TOML"),
        (b"#" * 10_000_000, "toml", ""),
        (
            b"a = " + b"\n".join([b"[" * 2000] * 20),
            "declaration",
            "nested too deeply|Invalid|Unclosed",
        ),
        (b"a." * 1200 + b"a = 1", "declaration", "nested too deeply"),
    ],
)
def test_files_that_are_no_declaration_are_refused_at_once(
    load: Loader, content: bytes, code: str, says: str
) -> None:
    with within(100_000), refuses(code, says):
        load(content)


def test_a_byte_order_mark_and_windows_lines_are_read(load: Loader) -> None:
    text = b"\xef\xbb\xbf" + EMPS2015.replace("\n", "\r\n").encode()
    assert load(text) == load(EMPS2015)


def test_folders_and_missing_files_are_refused(tmp_path: Path) -> None:
    for name in (tmp_path, tmp_path / "no.toml"):
        with pytest.raises(ModelError, match="there is no axis"):
            load_axis(name)
    (tmp_path / "folder.toml").mkdir()
    with refuses("axis-file", says="no axis file"):
        load_axis(tmp_path / "folder.toml")


@pytest.mark.slow
@given(
    st.sampled_from([EMPS2015, PENDULUM]),
    st.integers(0, 1400),
    st.integers(0, 12),
    st.one_of(st.text(max_size=6), st.sampled_from(["[x]", "= 1", '"', "-1", "[[", "{", "true"])),
)
def test_any_change_of_a_declaration_is_an_axis_or_a_model_error(
    tmp_path_factory: pytest.TempPathFactory, text: str, at: int, removed: int, added: str
) -> None:
    file = tmp_path_factory.getbasetemp() / "mutated.toml"
    changed = text[:at] + added + text[at + removed :]
    file.write_bytes(changed.encode("utf-8", "surrogatepass"))
    try:
        axis = load_axis(file)
    except ModelError as error:
        assert "mutated.toml" in str(error)
    else:
        assert isinstance(axis, Axis)


MOTOR = """
name = "linear_motor"
coordinate = { name = "q", unit = "m" }
drive = { gain = 58.0, unit = "A", limit = 12.0, profile = "1 + 0.03*cos(pi*q/pitch)" }

[parameters]
M = { unit = "kg", nominal = 10.0 }
Fv = { unit = "N/(m/s)" }
Fc = { unit = "N" }
Fa = { unit = "N" }
Fb = { unit = "N" }

[constants]
pitch = { value = 0.016, unit = "m" }

[newton]
inertia = "M"
resistance = ["Fv*dq", "Fc*sign(dq)", "Fa*cos(2*pi*q/pitch)", "Fb*sin(2*pi*q/pitch)"]
"""


def test_constants_and_profile_are_those_of_python(load: Loader, rng: np.random.Generator) -> None:
    ours, library = build(load(MOTOR)), build(load_axis("linear_motor"))
    motion = (*rng.normal(size=(3, 20)), np.sign(rng.normal(size=20)), rng.normal(size=5))
    (one,), (other,) = (axis.evaluate("inverse_dynamics", *motion) for axis in (ours, library))
    assert one == pytest.approx(other, rel=1e-12)
    assert load(MOTOR).unchecked_terms == ()


def test_gravity_is_known_and_may_be_another_one(load: Loader) -> None:
    weight = ("resistance = [", 'resistance = ["M*G", ')
    assert "9.80665" in str(derive(load(MOTOR, weight)).force)
    own = ("[constants]", '[constants]\nG = { value = 1.62, unit = "m/s^2" }')
    assert "1.62" in str(derive(load(MOTOR, weight, own)).force)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'pitch = { value = 0.016, unit = "m" }',
            "pitch = { value = 0.016 }",
            "unit: the key is missing",
        ),
        ("value = 0.016", 'value = "wide"', "constants.pitch.value"),
        (
            "[constants]",
            '[constants]\nM = { value = 1.0, unit = "kg" }',
            "constants.M: the constant has the name of a parameter",
        ),
        ("[constants]", '[constants]\nq = { value = 1.0, unit = "m" }', "a symbol of the motion"),
        (
            "[constants]",
            '[constants]\npi = { value = 3.0, unit = "1" }',
            "constants.pi: pi is the number pi",
        ),
        (
            "[constants]",
            '[constants]\nG = { value = 8e10, unit = "N/m^2" }',
            "constants.G",
        ),
        ("Fa = {", 'pi = { unit = "N" }\nFa = {', "parameters.pi: .*is the number pi in every"),
        (
            "Fa = {",
            'G = { unit = "N" }\nFa = {',
            "parameters.G: .*acceleration of gravity in every",
        ),
        ('name = "q", unit', 'name = "G", unit', "coordinate.name: .*acceleration of gravity"),
        ('unit = "m" }\n\n[newton]', 'unit = "s" }\n\n[newton]', "takes a number, not"),
        ("0.03*cos(pi*q/pitch)", "0.03*cos(pi*speed/pitch)", "drive.profile"),
    ],
)
def test_wrong_constants_and_profiles_are_told(
    load: Loader, old: str, new: str, message: str
) -> None:
    with pytest.raises(ModelError, match=message):
        load(MOTOR, (old, new))


#: Every element as text gives it: the call, and the units of its parameters.
CALLS = {
    "viscous(a, q)": {"a": "N/(m/s)"},
    "asymmetric_viscous(a, b, q)": {"a": "N/(m/s)", "b": "N/(m/s)"},
    "coulomb(a, q)": {"a": "N"},
    "coulomb(a*q**2, q)": {"a": "N/m^2"},
    "asymmetric_coulomb(a, b, q)": {"a": "N", "b": "N"},
    "quadratic(a, q)": {"a": "N/(m/s)^2"},
    "stribeck(a, q, velocity=0.01)": {"a": "N"},
    "stribeck(a, q, velocity=0.01, exponent=1)": {"a": "N"},
    "stribeck(excess=a, coordinate=q, velocity=2e-2/2, exponent=1.5)": {"a": "N"},
    "load_dependent(a, 30, q)": {"a": "1"},
    "dahl(a, q, coulomb=b)": {"a": "N/m", "b": "N"},
    "lugre(a, b, q, coulomb=20, static=30, velocity=0.01)": {"a": "N/m", "b": "N/(m/s)"},
    "maxwell_slip(a, b, q) + maxwell_slip(2e3, 5, q)": {"a": "N/m", "b": "N"},
    "periodic_coulomb(a, b, q, period=0.01)": {"a": "N", "b": "N"},
    "cogging(a, b, q, period=0.01, harmonic=2)": {"a": "N", "b": "N"},
    "2*cogging(0, b, q, period=0.01) + offset(a)": {"a": "N", "b": "N"},
    "back_emf(a, q, kt=0.05, resistance=2, ratio=300)": {"a": "V/(rad/s)"},
    "gravity(a)": {"a": "kg"},
    "spring(a, q, 0.02)": {"a": "N/m"},
    "spring(a, q, rest=0.02)": {"a": "N/m"},
    "cubic_spring(a, q)": {"a": "N/m^3"},
    "offset(a) + end_stop(q, lower=-0.1, upper=0.1, stiffness=1e5)": {"a": "N"},
}


def _with_element(folder: Path, call: str, units: dict[str, str], unit: str = "m") -> Axis:
    listed = "".join(f'{name} = {{ unit = "{each}" }}\n' for name, each in units.items())
    file = text_file(
        folder / "axis.toml",
        f'name = "made"\ncoordinate = {{ name = "q", unit = "{unit}" }}\n'
        f'drive = {{ gain = 1.0 }}\n[parameters]\nM = {{ unit = "kg" }}\n{listed}'
        f'[newton]\ninertia = "M"\nresistance = ["{call}"]\n',
    )
    return load_axis(file)


@pytest.mark.parametrize("call", CALLS)
def test_elements_are_those_of_python(tmp_path: Path, call: str) -> None:
    q = Coordinate("q", unit="m")
    mass, *others = (Parameter(n, u) for n, u in {"M": "kg", **CALLS[call]}.items())
    known = {"q": q, **{p.name: p for p in others}}
    made = {name: getattr(axisid.elements, name) for name in ELEMENTS}
    term = eval(call, {"__builtins__": {}}, {**made, **known})  # noqa: S307  # text of this file
    expected = newton(
        "made",
        coordinate=q,
        parameters=(mass, *others),
        inertia=mass,
        resistance=(term,),
        drive=axisid.elements.Drive(gain=1.0),
    )
    ours = _with_element(tmp_path, call, CALLS[call])
    assert ours.force == expected.force


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            "stribeck(a, q)",
            r"stribeck\(excess, coordinate, \*, velocity",
        ),
        ("stribeck(a, q, velocity=0.01, width=2)", r"stribeck\("),
        ("stribeck(a, dq, velocity=0.01)", r"coordinate of stribeck\(...\) is dq"),
        ("stribeck(a, q, velocity=-0.01)", "positive number"),
        ("stribeck(a, q, velocity=0.01, exponent=500)", "power -?500"),
        ("cogging(a, a, q, period=0.01, harmonic=1.5)", "whole number"),
        ("a*sign(dq=1)", r"sign\(...\) has 1 arguments"),
        ("a = 2", "column 3: an operator, a number or a name is missing"),
        ("viscous(a, q==0)", "cannot be used"),
        ("viscous(a, q, **q)", "cannot be used"),
        ("viscus(a, q)", "the function viscus is not known"),
        (
            "viscous(viscous(viscous(viscous(viscous(viscous(viscous(a,q),q),q),q),q),q),q)",
            "nested more than 6 deep",
        ),
    ],
)
def test_wrong_elements_are_told(tmp_path: Path, call: str, message: str) -> None:
    with pytest.raises(DeclarationError, match=message):
        _with_element(tmp_path, call, {"a": "N"})


def test_a_parameter_may_have_the_name_of_an_element(tmp_path: Path) -> None:
    assert str(_with_element(tmp_path, "offset", {"offset": "N"}).force).endswith("+ offset")
    with pytest.raises(DeclarationError, match="offset is not a function"):
        _with_element(tmp_path, "offset(2)", {"offset": "N"})


BRISTLE = """
name = "bristle"
coordinate = { name = "x", unit = "m" }

[parameters]
M = { unit = "kg", nominal = 10, lower = 0 }
s0 = { unit = "N/m", nominal = 1e6, lower = 0 }
Fc = { unit = "N", nominal = 20, lower = 0 }
k = { unit = "N/m", nominal = 1e5, lower = 0 }
W = { unit = "N", nominal = 3, lower = 0 }

[states]
z = { unit = "m", following = "dx - s0*abs(dx)*z/Fc" }
y = { unit = "m", following = "dx", limit = "W/k", start = "W/(2*k)" }

[newton]
inertia = "M"
resistance = ["s0*z", "k*y"]

[drive]
gain = 30
"""


def test_friction_that_remembers_is_declared_by_its_states(tmp_path: Path) -> None:
    file = text_file(tmp_path / "bristle.toml", BRISTLE)
    axis = load_axis(str(file))
    x = Coordinate("x")
    M, s0, Fc, k, W = axis.parameters
    z = State("z", "m", lambda z: x.velocity - s0 * sympy.Abs(x.velocity) * z / Fc)
    y = State("y", "m", x.velocity, limit=W / k, start=W / (2 * k))
    assert axis.states == (y, z)
    assert axis.force == M * x.acceleration + s0 * z.symbol + k * y.symbol
    file.write_text(BRISTLE.replace('"s0*z"', '"dahl(s0, x, coulomb=Fc)"'))
    with pytest.raises(DeclarationError, match=r"states\.z"):
        load_axis(str(file))
