"""Every method as it is run, from the rows of `axisid.estimation.choices`."""

from pkgutil import resolve_name

from axisid.estimation.choices import METHOD_ROWS, MethodRow

from .method import Method


def method_of(row: MethodRow) -> Method:
    """Return the method that a row names."""
    made: Method = resolve_name(row.method)(name=row.name, form=resolve_name(row.form))
    return made


#: In the order in which they are run.
METHODS: dict[str, Method] = {row.name: method_of(row) for row in METHOD_ROWS}
