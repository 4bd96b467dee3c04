"""Results in JSON, whole and with anything in them changed, lost or cut off."""

import json
from collections.abc import Iterator
from copy import deepcopy
from typing import Any

import numpy as np

from tests.fuzz.cases import one_of

#: What is put in the place of a value.
_VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1e308, -1e308, 5e-324, 10**400, 1e-300, "", "1", "x", "é", "\x00"),
    *(
        "\ud800",
        "a" * 3000,
        "\n",
        "*)",
        "*/",
        "\\",
        '"',
        [],
        [[]],
        {},
        {"a": 1},
        [None],
        [1e308] * 2,
    ),
    *("nan", "inf", "kg m^2", "%", "\u202e", "../..", "idm-ls", "axisid.stream/1", 2**63, 0.1),
)
#: Text that is put in as it is, JSON or not.
_TEXTS = ("NaN", "Infinity", "-Infinity", "1e400", "1E5", "0x10", "[" * 2000, "{", "}", ",", "\x00")

_ALIKE_NUMBERS = (None, 0, -1, 1, 2, 7, 0.5, 1e5, 1e308, -1e308, 1e200, 1e-300, 5e-324, 2**63)
_ALIKE_TEXTS = ("", "x", "%", "kg m^2", "é", "idm-ls", "hac", "iid", "position")


def changed_result(whole: Any, rng: np.random.Generator) -> str:
    """Draw the text of a result with something in it changed."""
    tree = deepcopy(whole)
    for _ in range(int(rng.choice([1, 1, 1, 2, 4]))):
        _change(tree, rng)
    text = json.dumps(tree)
    kind = rng.random()
    if kind < 0.1:
        return text[: int(rng.integers(len(text)))]
    if kind < 0.2:
        at = int(rng.integers(len(text)))
        return text[:at] + one_of(rng, _TEXTS) + text[at + int(rng.integers(3)) :]
    return text


def _change(tree: Any, rng: np.random.Generator) -> None:
    places = list(_places(tree))
    # What is near the root is as likely as the thousand numbers in its leaves.
    depth = int(rng.integers(1, max(level for level, *_ in places) + 1))
    near = [place for place in places if place[0] == depth]
    _, holder, key = one_of(rng, near)
    kind = int(rng.integers(4))
    if kind == 0:
        del holder[key]
    elif kind == 1 and isinstance(holder, dict):
        holder[f"{key}x"] = holder.pop(key)
    elif kind == 2:
        _, other, place = one_of(rng, places)
        holder[key] = deepcopy(other[place])
    else:
        holder[key] = deepcopy(one_of(rng, _VALUES))


def _places(value: Any, level: int = 1) -> Iterator[tuple[int, Any, Any]]:
    """Every place of a tree that holds something: how deep, in what, and under which key."""
    keys = list(value) if isinstance(value, dict) else range(len(value))
    for key in keys:
        yield level, value, key
        if isinstance(value[key], (dict, list)):
            yield from _places(value[key], level + 1)


def altered_result(whole: Any, rng: np.random.Generator) -> str:
    """Draw the text of a result whose members keep their kinds, as an editor would leave them."""
    tree = deepcopy(whole)
    for _ in range(int(rng.choice([1, 1, 2]))):
        places = list(_places(tree))
        depth = int(rng.integers(1, max(level for level, *_ in places) + 1))
        _, holder, key = one_of(rng, [place for place in places if place[0] == depth])
        holder[key] = _alike(holder[key], rng)
    return json.dumps(tree)


def _alike(value: Any, rng: np.random.Generator) -> Any:
    """Another value of the same kind; of a list or an object one that lost or won a member."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        return one_of(rng, _ALIKE_TEXTS)
    if not isinstance(value, (dict, list)):
        return one_of(rng, _ALIKE_NUMBERS)
    members = list(value.items()) if isinstance(value, dict) else list(value)
    if not members or rng.random() < 0.2:
        return type(value)()
    one = one_of(rng, members)
    if rng.random() < 0.5:
        members.remove(one)
    else:
        members.append(("another", one[1]) if isinstance(value, dict) else one)
    return type(value)(members)


def smaller_results(text: str) -> Iterator[str]:
    """The result without one of the things in it, if it is JSON; else without its end."""
    try:
        tree = json.loads(text)
    except (ValueError, RecursionError):
        yield from (text[: len(text) // 2], text[:-1])
        return
    if not isinstance(tree, (dict, list)):
        return
    places = sorted(_places(tree), key=lambda place: place[0])
    for k in range(min(len(places), 300)):
        fewer = deepcopy(tree)
        _, holder, key = sorted(_places(fewer), key=lambda place: place[0])[k]
        del holder[key]
        yield json.dumps(fewer)
