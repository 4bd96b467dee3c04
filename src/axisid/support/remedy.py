"""What to do about an error or a note, as data: sentences with the settings that they speak of.

A setting is an option of the command line, or a key of a run.toml, and an argument in Python. Which
is which stands in `ARGUMENTS` alone; whoever shows a sentence chooses how it is worded.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from types import MappingProxyType

from .number_text import plain_numbers

_ANY = "..."  # a value that is left to the user
_FILE, _PYTHON = "run.toml", "Python"
_PLAIN = re.compile(r"[-+\d.e]*|[A-Z]+")  # a number or a placeholder, which TOML has without quotes


@dataclass(frozen=True, slots=True)
class Setting:
    """Something that can be set for a run.

    Attributes
    ----------
    name : str
        Of `ARGUMENTS`: that of the option, without its dashes; behind that of its command, as
        ``fit output``, where another command runs.
    value : str
        As the command line takes it, or a placeholder such as ``NAME``; empty for a switch, and
        where the value is left to the user.
    given : bool
        False where it is to be left out.
    """

    name: str
    value: str = ""
    given: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Argument:
    """What a setting is in Python.

    Attributes
    ----------
    of : str
        The callable that takes it, by its name in `axisid`.
    name : str
        Of the argument; empty where it has none, or where the call is all there is to set.
    call : str
        How the callable is written around its arguments; ``{}`` for the one that is called anyway.
    written : callable
        Takes the name and the values, and gives the text of all of them.
    place : str
        Where it is set beside Python: ``run.toml``, by a key of this name; empty for an option, and
        ``Python`` where nothing else sets it.
    """

    of: str
    name: str = ""
    call: str = "{}"
    written: Callable[[str, Sequence[str]], str]
    place: str = ""


#: Gives the words for settings that stand together.
Wording = Callable[[Sequence[Setting]], str]


def as_options(settings: Sequence[Setting]) -> str:
    """As on the command line: ``--gaps split``; or ``mask = "clipped" in run.toml``."""
    by_place: dict[str, list[Setting]] = {}
    for setting in settings:
        by_place.setdefault(ARGUMENTS[setting.name].place, []).append(setting)
    return " and ".join(_at(place, each) for place, each in by_place.items())


def _at(place: str, settings: Sequence[Setting]) -> str:
    if not place:
        return " ".join(map(_option, settings))
    said = as_arguments(settings) if place == _PYTHON else ", ".join(map(_key, settings))
    return f"{said} in {place}"


def _option(setting: Setting) -> str:
    command, _, name = setting.name.rpartition(" ")
    option = f"axisid {command} " * bool(command) + f"--{name} {setting.value}".rstrip()
    return option if setting.given else f"leave {option} out"


def _key(setting: Setting) -> str:
    """As TOML has it; a table is a dotted key."""
    argument = ARGUMENTS[setting.name]
    if not setting.given:
        return f"leave {argument.name} out"
    by_role = argument.written is _mapping
    role, _, amount = setting.value.partition("=") if by_role else ("", "", setting.value)
    text = amount or _ANY if _PLAIN.fullmatch(amount) else _quoted(amount)
    return f"{argument.name}{f'.{role}' if by_role else ''} = {text}"


def as_arguments(settings: Sequence[Setting]) -> str:
    """As in Python: ``repairs=Repairs(resample="auto", gaps="split")``."""
    calls: dict[str, dict[str, list[str]]] = {}
    for setting in settings:
        if setting.given:
            values = calls.setdefault(ARGUMENTS[setting.name].call, {})
            values.setdefault(setting.name, []).append(setting.value)
    written = [
        call.format(", ".join(_argument(name, each) for name, each in values.items()))
        for call, values in calls.items()
    ]
    without = [f"leave {ARGUMENTS[each.name].name} out" for each in settings if not each.given]
    return ", ".join(written + without)


def _argument(setting: str, values: Sequence[str]) -> str:
    argument = ARGUMENTS[setting]
    return argument.written(argument.name, values)


def _text(name: str, values: Sequence[str]) -> str:
    """An argument that is a text."""
    return f"{name}={_quoted(values[-1]) if values[-1] else _ANY}"


def _number(name: str, values: Sequence[str]) -> str:
    """An argument that is a number, in the unit of the option."""
    return f"{name}={values[-1] or _ANY}"


def _mapping(name: str, values: Sequence[str]) -> str:
    """An argument that is a mapping, whose option lists ``KEY=VALUE``."""
    pairs = (pair.partition("=") for value in values for pair in value.split(","))
    return f"{name}={{{', '.join(f'{_quoted(k)}: {_quoted(v)}' for k, _, v in pairs)}}}"


def _windows(name: str, values: Sequence[str]) -> str:
    """A list of pairs of times, of options ``FROM..TO``."""
    ends = (value.partition("..")[::2] for value in values)
    return f"{name}=[{', '.join(f'({a or None}, {b or None})' for a, b in ends)}]"


def _names(name: str, values: Sequence[str]) -> str:
    """An argument that is a list of names."""
    return f"{name}=[{_each_quoted('', ','.join(values).split(','))}]"


def _by_record(name: str, values: Sequence[str]) -> str:
    """An argument that is a mapping to a list, whose option is ``KEY=V1,V2``."""
    pairs = (value.partition("=") for value in values)
    listed = ", ".join(
        f"{_quoted(k)}: [{', '.join(map(_with_deviation, v.split(',')))}]" for k, _, v in pairs
    )
    return f"{name}={{{listed}}}"


def _true(name: str, _: Sequence[str]) -> str:
    """A switch."""
    return f"{name}=True"


def _nothing(_: str, values: Sequence[str]) -> str:
    """A call without arguments of its own."""
    return "".join(values)


def _assigned(_: str, values: Sequence[str]) -> str:
    """Arguments by name, of options ``NAME=VALUE+-SD``."""
    pairs = (value.partition("=") for value in values)
    return ", ".join(f"{name}={_with_deviation(value)}" for name, _, value in pairs)


def _with_deviation(value: str) -> str:
    """A value, or with its standard deviation a pair of them, of ``VALUE+-SD``."""
    told, _, sd = value.partition("+-")
    return f"({told}, {sd})" if sd else told


def _each_quoted(_: str, values: Sequence[str]) -> str:
    return ", ".join(map(_quoted, values))


def _quoted(value: str) -> str:
    return f'"{value}"'


_REPAIRS = "repairs=Repairs({})"
_PREFILTER = "Prefilter({})"

#: What each setting is in Python, by its name on the command line.
ARGUMENTS: Mapping[str, Argument] = MappingProxyType(
    {
        "columns": Argument(of="read_record", name="columns", written=_mapping),
        "injected-at": Argument(of="read_record", name="injected_at", written=_text, place=_FILE),
        "sample-period": Argument(
            of="read_record", name="sample_period", written=_number, place=_FILE
        ),
        "window": Argument(of="read_record", name="windows", written=_windows),
        "max-memory": Argument(of="read_record", name="max_memory", written=_number, place=_FILE),
        "mask": Argument(
            of="estimation.Repairs", name="mask", call=_REPAIRS, written=_text, place=_FILE
        ),
        "resample": Argument(
            of="estimation.Repairs", name="resample", call=_REPAIRS, written=_text
        ),
        "gaps": Argument(of="estimation.Repairs", name="gaps", call=_REPAIRS, written=_text),
        "wrap": Argument(
            of="estimation.Repairs", name="wrap", call=_REPAIRS, written=_text, place=_FILE
        ),
        "tail": Argument(
            of="estimation.Repairs", name="tail", call=_REPAIRS, written=_text, place=_FILE
        ),
        "shift": Argument(
            of="estimation.Repairs", name="shift", call=_REPAIRS, written=_mapping, place=_FILE
        ),
        "between": Argument(
            of="estimation.Repairs", name="between", call=_REPAIRS, written=_mapping, place=_FILE
        ),
        "decimate": Argument(of="Prefilter", name="decimate", call=_PREFILTER, written=_number),
        "hold": Argument(of="Prefilter", name="hold", call=_PREFILTER, written=_text),
        "reversals": Argument(of="Prefilter", name="reversals", call=_PREFILTER, written=_text),
        "all": Argument(
            of="Identification.summary",
            name="every",
            call="summary({})",
            written=_true,
        ),
        "method": Argument(of="compare", name="method", written=_text),
        "skip-bad": Argument(of="identify", name="skip_bad", written=_true),
        "validate-like": Argument(of="validate", name="like", written=_number),
        "local": Argument(of="identify", name="local", written=_names),
        "known": Argument(of="identify", name="known", written=_by_record),
        "start": Argument(of="identify", name="start", written=_text, place=_PYTHON),
        "loss": Argument(of="identify", name="loss", written=_text),
        "bounded": Argument(of="identify", name="bounded", written=_true),
        "horizon": Argument(of="fit", name="horizon", written=_number),
        "fit output": Argument(
            of="fit",
            name="output",
            call="fit(axis, record, {})",
            written=_each_quoted,
        ),
        "free": Argument(of="fit", name="free", written=_text),
        "fix": Argument(of="fix", call="fix(axis, {})", written=_assigned),
        "leave-out": Argument(of="leave_out", call="leave_out(axis, {})", written=_each_quoted),
        "ladder": Argument(of="friction_ladder", call="friction_ladder(axis)", written=_nothing),
        "record": Argument(of="export", name="record", written=_number),
        "axis": Argument(of="load_result", name="axis", written=_text),
        "json": Argument(of="Identification.to_dict", call="to_dict() as JSON", written=_nothing),
        "output": Argument(of="codegen.artefacts.write_files", name="folder", written=_text),
    }
)


@dataclass(frozen=True, slots=True)
class Remedy:
    """What to do, in words and settings.

    Attributes
    ----------
    parts : tuple of str or Setting
        In their order; settings that follow one another are worded together.
    """

    parts: tuple[str | Setting, ...]

    def __post_init__(self) -> None:
        plain = (plain_numbers(part) if isinstance(part, str) else part for part in self.parts)
        object.__setattr__(self, "parts", tuple(plain))

    @classmethod
    def of(cls, *parts: "str | Setting | Remedy | None") -> "Remedy":
        """A remedy of texts, settings and remedies in their order; what is empty is passed over."""
        flat: list[str | Setting] = []
        for part in parts:
            flat += part.parts if isinstance(part, Remedy) else (part,) if part else ()
        return cls(tuple(flat))

    @property
    def settings(self) -> tuple[Setting, ...]:
        """What it speaks of."""
        return tuple(part for part in self.parts if isinstance(part, Setting))

    def worded(self, wording: Wording) -> str:
        """As a text, with the settings as options or as arguments."""
        pieces = []
        for _, group in groupby(self.parts, lambda part: isinstance(part, str)):
            each = [*group]
            together = [part for part in each if isinstance(part, Setting)]
            pieces.append(wording(together) if together else "".join(map(str, each)))
        return "".join(pieces)

    def __str__(self) -> str:
        return self.worded(as_arguments)


@dataclass(frozen=True, slots=True)
class Note:
    """Something to tell the user: what there is, and what to do about it.

    Attributes
    ----------
    text : str
        Up to the remedy, with the blank before it.
    remedy : Remedy or None
        How it goes on.
    """

    text: str
    remedy: Remedy | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "text", plain_numbers(self.text))

    @classmethod
    def of(cls, *parts: "str | Note | Remedy | None") -> "Note":
        """One note of texts, notes and remedies in their order; nothing is said of None."""
        text, remedy = "", Remedy.of()
        for part in parts:
            note = part if isinstance(part, Note) else _alone(part)
            if remedy.parts:
                remedy = Remedy.of(remedy, note.text, note.remedy)
            else:
                text, remedy = text + note.text, note.remedy or remedy
        return cls(text, remedy if remedy.parts else None)

    @classmethod
    def joined(cls, between: str, notes: "Iterable[Note]") -> "Note":
        """One note of several, each once, with a text between them."""
        parts = [part for note in dict.fromkeys(notes) for part in (between, note)]
        return cls.of(*parts[1:])

    def worded(self, wording: Wording) -> str:
        """As a text, with the settings as options or as arguments."""
        return self.text + ("" if self.remedy is None else self.remedy.worded(wording))

    def __str__(self) -> str:
        return self.worded(as_arguments)


def _alone(part: str | Remedy | None) -> Note:
    """A note of a text or of a remedy alone."""
    return Note("", part) if isinstance(part, Remedy) else Note(part or "")


def worded(said: str | Note, wording: Wording) -> str:
    """What is said, as a text; a plain text speaks of no settings."""
    return said if isinstance(said, str) else said.worded(wording)
