"""Axes drawn at random, as TOML declarations: sound ones, such as a machine builder has.

Inertia, friction, loads, drive, control law and experiment are drawn to fit one another: every term
is a few tenths of the force that accelerates the axis, and the experiment shows each of them. So
the identification of an axis from its own twin has to find the true parameters.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

#: Units of a parameter by what it multiplies, for a linear and for a rotary axis.
_UNITS = {
    "force": ("N", "N m"),
    "speed": ("N/(m/s)", "N m/(rad/s)"),
    "speed squared": ("N/(m/s)^2", "N m/(rad/s)^2"),
    "position": ("N/m", "N m/rad"),
    "position cubed": ("N/m^3", "N m/rad^3"),
    "acceleration": ("kg", "kg m^2"),
}
#: Acceleration, m/s^2, from which a drive holds the weight too; slower ones would sag too far.
_HOLDS = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Term:
    """A part of the force balance.

    Attributes
    ----------
    text : str
        As an expression of a declaration.
    truth : mapping of str to float
        True values of its parameters, SI.
    of : str
        What its parameters multiply, a key of the units.
    constants : mapping of str to float
        Known lengths, in the coordinate's unit.
    speeds : mapping of str to float
        Known speeds.
    everywhere : bool
        Whether it depends on the position, so that the axis has to reverse all over its stroke.
    """

    text: str
    truth: Mapping[str, float] = field(default_factory=dict)
    of: str = "force"
    constants: Mapping[str, float] = field(default_factory=dict)
    speeds: Mapping[str, float] = field(default_factory=dict)
    everywhere: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class RandomAxis:
    """An axis that was drawn; `toml` declares it.

    Attributes
    ----------
    name : str
    rotary : bool
        Its coordinate is an angle.
    inertia : float
        The true one, kg or kg m^2; where it depends on the position, its constant part.
    nominal : float
        Where instruments start.
    terms : tuple of Term
        Resistances; one that multiplies the acceleration is a part of the inertia.
    gain, limit : float
        Of the drive.
    profile : str
        Of the drive's gain over the position; empty for none.
    law : str
    kp, kv, period : float
    experiment : str
        Lines of TOML.
    noise : float
        Of the position, in the coordinate's unit.
    force, stroke, speed : float
        What accelerates it, how far and how fast it goes.
    """

    name: str
    rotary: bool
    inertia: float
    nominal: float
    terms: tuple[Term, ...]
    gain: float
    limit: float
    profile: str
    law: str
    kp: float
    kv: float
    period: float
    experiment: str
    noise: float
    force: float
    stroke: float
    speed: float

    @property
    def truth(self) -> dict[str, float]:
        """True parameters by name, SI."""
        return {"M": self.inertia, **{n: v for term in self.terms for n, v in term.truth.items()}}

    def without(self, index: int) -> "RandomAxis":
        """The axis without one of its terms."""
        kept = (term for k, term in enumerate(self.terms) if k != index)
        return replace(self, terms=tuple(kept))

    @property
    def toml(self) -> str:
        """The declaration."""
        unit = "rad" if self.rotary else "m"
        profile = f', profile = "{self.profile}"' if self.profile else ""
        units = {kind: each[self.rotary] for kind, each in _UNITS.items()}
        lines = [
            f'name = "{self.name}"',
            f'coordinate = {{ name = "q", unit = "{unit}" }}',
            f'drive = {{ gain = {self.gain!r}, unit = "A", limit = {self.limit!r}{profile} }}',
            f'control = {{ law = "{self.law}", kp = {self.kp!r}, kv = {self.kv!r}, '
            f"period = {self.period!r} }}",
            "",
            "[parameters]",
            f'M = {{ unit = "{units["acceleration"]}", nominal = {self.nominal!r}, lower = 0.0 }}',
        ]
        lines += [f'{n} = {{ unit = "{units[t.of]}" }}' for t in self.terms for n in t.truth]
        known = [(n, v, unit) for t in self.terms for n, v in t.constants.items()]
        known += [(n, v, f"{unit}/s") for t in self.terms for n, v in t.speeds.items()]
        lines += ["", "[constants]"] if known else []
        lines += [f'{n} = {{ value = {v!r}, unit = "{u}" }}' for n, v, u in known]
        truth = ", ".join(f"{n} = {v!r}" for n, v in self.truth.items())
        lines += ["", *self._dynamics, "", "[experiment]", self.experiment]
        lines += [f"truth = {{ {truth} }}", f"position_noise = {self.noise!r}", ""]
        return "\n".join(lines)

    @property
    def _dynamics(self) -> list[str]:
        """By Newton, or by Lagrange where the inertia depends on the position."""
        moving = [term.text for term in self.terms if term.of == "acceleration"]
        forces = [term.text for term in self.terms if term.of != "acceleration"]
        if moving:
            resisting = " + ".join(f"({text})" for text in forces) or "0"
            return [
                "[lagrange]",
                f'kinetic = "({" + ".join(["M", *moving])})*dq**2/2"',
                f'generalised_force = "-({resisting})"',
            ]
        listed = ", ".join(f'"{text}"' for text in forces)
        return ["[newton]", 'inertia = "M"', f"resistance = [{listed}]"]


def random_axis(rng: np.random.Generator) -> RandomAxis:
    """Draw an axis."""
    rotary = bool(rng.random() < 0.4)
    inertia = _log(rng, 1e-3, 1.0) if rotary else _log(rng, 0.2, 200.0)
    speed = _log(rng, 2.0, 15.0) if rotary else _log(rng, 0.05, 1.0)
    ramp, cruise = rng.uniform(0.04, 0.12), rng.uniform(0.3, 0.5)
    force, stroke = inertia * speed / ramp, speed * cruise
    terms = _friction(rng, force, speed) + _loads(rng, force, stroke, rotary=rotary)
    if not rotary and force > _HOLDS * inertia and rng.random() < 0.2:
        terms += (Term(text="M*G"),)
    if rotary and rng.random() < 0.3:
        share = _short(inertia * rng.uniform(0.3, 2.0))
        inertia_term = Term(
            text="J1*sin(q)**2", truth={"J1": share}, of="acceleration", everywhere=True
        )
        terms += (inertia_term,)
    profiled = not rotary and rng.random() < 0.15
    profile = f"1 + 0.05*cos(2*pi*q/{stroke * rng.uniform(0.2, 0.5):.6g})" if profiled else ""
    everywhere = profiled or any(term.everywhere for term in terms)
    gain = _log(rng, 0.05, 50.0)
    bandwidth = rng.uniform(60.0, 150.0)  # of the velocity loop, rad/s
    return RandomAxis(
        name="drawn",
        rotary=rotary,
        inertia=inertia,
        nominal=_short(inertia * rng.uniform(0.6, 1.6)),
        terms=terms,
        gain=gain,
        limit=_short(10 * force / gain),
        profile=profile,
        law=str(rng.choice(["cascade_pd", "cascade_pd_averaged", "cascade_pd_difference"])),
        kp=_short(bandwidth / 4),
        kv=_short(inertia * bandwidth / gain),
        period=float(rng.choice([1e-3, 1e-3, 5e-4])),
        experiment=_experiment(rng, speed, speed / ramp, cruise, everywhere=everywhere),
        noise=_short(stroke * 10 ** rng.uniform(-6.5, -4.0)),
        force=_short(force),
        stroke=_short(stroke),
        speed=_short(speed),
    )


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return _short(np.exp(rng.uniform(math.log(low), math.log(high))))


def _short(number: float) -> float:
    """A number as a person writes it."""
    return float(f"{number:.4g}")


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _friction(rng: np.random.Generator, force: float, speed: float) -> tuple[Term, ...]:
    """Viscous and dry friction, in one of their forms, and what may come with them."""

    def part() -> float:
        return _short(force * rng.uniform(0.1, 0.5))

    viscous = (
        Term(text="b*dq", truth={"b": _short(part() / speed)}, of="speed"),
        Term(
            text="bp*(dq + abs(dq))/2 + bm*(dq - abs(dq))/2",
            truth={"bp": _short(part() / speed), "bm": _short(part() / speed)},
            of="speed",
        ),
        Term(text="e*dq*abs(dq)", truth={"e": _short(part() / speed**2)}, of="speed squared"),
    )
    dry = (
        Term(text="c*sign(dq)", truth={"c": part()}),
        Term(text="cp*(1 + sign(dq))/2 - cm*(1 - sign(dq))/2", truth={"cp": part(), "cm": part()}),
    )
    terms = [viscous[rng.choice(3, p=[0.6, 0.2, 0.2])], dry[rng.choice(2, p=[0.7, 0.3])]]
    if terms[1] is dry[0] and rng.random() < 0.3:
        terms.append(Term(text="F0", truth={"F0": _sign(rng) * part()}))
    if rng.random() < 0.15:
        terms.append(
            Term(
                text="s*exp(-(dq/vs)**2)*sign(dq)",
                truth={"s": part()},
                speeds={"vs": _short(speed * rng.uniform(0.2, 0.4))},
            )
        )
    return tuple(terms)


def _loads(
    rng: np.random.Generator, force: float, stroke: float, *, rotary: bool
) -> tuple[Term, ...]:
    """Forces of the position, and weight."""

    def part() -> float:
        return _short(force * rng.uniform(0.1, 0.5))

    terms = []
    if rng.random() < 0.2:
        terms.append(
            Term(text="k*q", truth={"k": _short(part() / stroke)}, of="position", everywhere=True)
        )
    if rng.random() < 0.1:
        terms.append(
            Term(
                text="k3*q**3",
                truth={"k3": _short(part() / stroke**3)},
                of="position cubed",
                everywhere=True,
            )
        )
    if rng.random() < 0.15:
        terms.append(
            Term(
                text="ca*cos(2*pi*q/p) + cb*sin(2*pi*q/p)",
                truth={"ca": part(), "cb": _sign(rng) * part()},
                constants={"p": _short(stroke * rng.uniform(0.3, 0.6))},
                everywhere=True,
            )
        )
    if rotary and rng.random() < 0.4:
        terms.append(
            Term(text="ga*sin(q) + gb*cos(q)", truth={"ga": part(), "gb": part()}, everywhere=True)
        )
    return tuple(terms)


def _experiment(
    rng: np.random.Generator, speed: float, acceleration: float, cruise: float, *, everywhere: bool
) -> str:
    """Moves there and back at several speeds, or reversals all over the stroke."""
    if not everywhere:
        speeds = ", ".join(f"{speed * share:.6g}" for share in (0.25, 0.6, 1.0))
        return (
            f"back_and_forth = {{ speeds = [{speeds}], acceleration = {acceleration:.6g}, "
            f"seconds = {cruise:.3g}, repeat = 2 }}"
        )
    stroke = speed * cruise
    places = stroke * rng.uniform(-1.0, 1.0, size=16)
    places[0::2] = np.abs(places[0::2])
    places[1::2] = -np.abs(places[1::2])
    moves = [
        f"{{ distance = {distance:.6g}, speed = {speed * rng.uniform(0.25, 1.0):.6g}, "
        f"acceleration = {acceleration:.6g} }}"
        for distance in np.diff(places, prepend=0.0)
    ]
    return f"moves = [{', '.join(moves)}]"
