"""All methods of estimation, from the rows of `axisid.estimation.choices`."""

from pkgutil import resolve_name

from axisid.estimation.choices import METHOD_ROWS

from .method import Method

#: Methods in the order in which they are run.
METHODS: dict[str, Method] = {
    row.name: resolve_name(row.method)(name=row.name, form=resolve_name(row.form))
    for row in METHOD_ROWS
}
