"""Where a record comes from, what was assumed of it, and how it was repaired."""

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True, kw_only=True)
class Repair:
    """One repair of a record.

    Attributes
    ----------
    kind : str
        ``tail``, ``wrap``, ``clipped``, ``empty``, ``resample`` or ``gaps``.
    count : int
        How often it was made: lines left out, jumps undone, samples masked, rows made, gaps.
    text : str
        The same for the user, with the method.
    """

    kind: str
    count: int
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Where a record comes from.

    Attributes
    ----------
    source : str
        File name, or how the record was made.
    sha256 : str
        Of the file, or of the files of a folder in the order of their names: of the very bytes that
        were used. Empty if there is none.
    given, path : str
        The file as it was named, and absolute; empty if there is none.
    columns : dict of str to str
        Column name by role.
    truth : dict of str to float
        Parameters of a simulated record, SI; empty for a measured one.
    assumed : tuple of str
        What was taken of the file: separator, encoding, units and their conversion.
    repairs : tuple of Repair
        What was done to the data, in this order; only on request.
    """

    source: str = "arrays"
    sha256: str = ""
    given: str = ""
    path: str = ""
    columns: dict[str, str] = field(default_factory=dict)
    truth: dict[str, float] = field(default_factory=dict)
    assumed: tuple[str, ...] = ()
    repairs: tuple[Repair, ...] = ()
