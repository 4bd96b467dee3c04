"""A parameter of a TOML declaration."""

from typing import Any

from axisid.modeling.quantities import Parameter, check_symbol

from .toml_table import Table, checked_name


def read_parameter(root: Table, name: str, unit: str = "") -> Parameter | None:
    """A parameter from its table, of a unit that is given in it or goes without saying."""
    checked = checked_name(root, name, name, "a parameter", check_symbol)
    table = root.table(name)
    table.only("unit", "nominal", "lower", "upper", "description", "known", "known_sd")
    table.needs(*([] if unit else ["unit"]))
    fields: dict[str, Any] = {"description": table.text("description")}
    fields |= {"unit": unit} if unit else {}
    fields |= {"unit": table.values["unit"]} if "unit" in table.values else {}
    fields |= {
        key: table.number(key, finite=key not in ("lower", "upper"))
        for key in ("nominal", "lower", "upper", "known", "known_sd")
        if key in table.values
    }
    neutral = {"name": checked or "p", "unit": "1"}
    parameter = table.made(Parameter, fields, neutral, apart=("unit",))
    return parameter if checked else None
