"""Parameters of several records: shared parameters, and local parameters of each record.

A record's base parameters are sums of products of the declared parameters. With the known values of
the record inserted, they are linear in the products of the others: ``beta_r = C_r mu + c_r``. The
reduced row echelon form of all stacked C_r gives the smallest set of parameters of all records,
which may be more than a single record identifies: two angles of an axis separate its weight from an
offset, two payloads its length from its mass.

If the records have a known force, the drive gain g is identifiable. The force ``g0 u`` of a control
by the declared gain g0 is ``g0/g`` times the true force. So with ``kappa = g0/g``

    g0 u = X mu' + kappa known,    mu = mu' / kappa,    g = g0 / kappa,

which is linear. A loop simulated with ``mu'``, ``kappa known`` and the declared gain is the loop
with ``mu``, ``known`` and g.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, Quantity, build
from axisid.estimation.regression import Form, InverseForm
from axisid.modeling.declaration import leave_out
from axisid.modeling.derivation import CommonParameter, common_parameters
from axisid.modeling.quantities import Parameter, fresh_name
from axisid.support.arrays import Array, BoolArray, Exact, column_sizes
from axisid.support.checks import refuse
from axisid.support.errors import ModelError, UsageError
from axisid.support.settings import setting

from .known_values import KnownValues

#: The drive gain among the parameters of several records.
GAIN = "drive_gain"

_SAME = 1e-9  # of a column
# A product of declared parameters: their names with powers, and the number of the record if one of
# them is local to a record; None for a product of all records.
_Product = tuple[tuple[tuple[str, int], ...], int | None]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Member(Exact):
    """Map from the joint parameters mu to one record's base parameters, ``into mu + offset``.

    Attributes
    ----------
    axis : GeneratedAxis
        The axis with the known law gains of the record, and with known values in place of
        parameters that enter nonlinearly.
    into : (b, P) array
        Derivatives of the b base parameters by the P joint parameters, without the drive gain.
    offset : (b,) array
        Part of the base parameters that is due to known values.
    """

    axis: GeneratedAxis
    into: Array
    offset: Array


@dataclass(frozen=True, slots=True, eq=False)
class JointForm(Exact, InverseForm):
    """Inverse model of several records in joint parameters, with the drive gain if identifiable.

    Attributes
    ----------
    parameters : tuple of Parameter
        Shared parameters, local parameters, and last the drive gain if it is identified.
    expressions : tuple of str
        Expression of each parameter in the declared parameters; empty for a declared parameter.
    members : tuple of Member
        Map to the parameters of each record.
    local : mapping of str to tuple of str
        For every local declared parameter, its names among `parameters` by record, alone or as the
        first term of a sum; empty for a record where it occurs in products only.
    known : KnownValues
        Known values of each record by name.
    gain : float or None
        The declared drive gain if a known force identifies the gain; None if the declared gain is
        used.
    """

    parameters: tuple[Parameter, ...] = field(kw_only=True)
    expressions: tuple[str, ...] = field(kw_only=True)
    members: tuple[Member, ...] = field(kw_only=True)
    local: Mapping[str, tuple[str, ...]] = field(kw_only=True)
    known: KnownValues = field(kw_only=True)
    gain: float | None = field(kw_only=True)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Parameters of the regression: the joint parameters.

        If the drive gain is identified, they are multiplied by kappa, and the last one is kappa.
        """
        return tuple(
            Quantity(name=p.name, unit=p.unit, expression=expression)
            for p, expression in zip(self.parameters, self.expressions, strict=True)
        )

    physical_quantities = quantities

    @property
    def declared(self) -> tuple[Parameter, ...]:
        """Joint parameters with their bounds."""
        return self.parameters

    @property
    def is_linear(self) -> bool:
        """True: `joint_form_of` refuses nonlinear models."""
        return True

    def physical(self, theta: Array) -> tuple[Array, Array]:
        """Return joint parameters (P,) for those of the regression (P,), and the Jacobian (P, P).

        If the drive gain is identified, the last parameter of the regression is kappa, the declared
        gain divided by the true one. The others are divided by kappa, and the last is replaced by
        the identified gain, which is the declared gain divided by kappa.
        """
        if self.gain is None:
            return theta, np.eye(len(theta))
        scaled, kappa = np.append(theta[:-1], self.gain), theta[-1]
        jacobian = np.eye(len(theta)) / kappa
        jacobian[:, -1] = -scaled / kappa**2
        return scaled / kappa, jacobian

    def regressed(self, physical: Array) -> Array:
        """Return the regression's parameters (P,) for joint parameters (P,).

        They are the same unless the drive gain is identified. They are then multiplied by kappa,
        and kappa takes the place of the gain, which is the last.
        """
        if self.gain is None:
            return physical
        kappa = self.gain / physical[-1]
        return np.append(physical[:-1] * kappa, kappa)

    def have_inertia(self, physical: Array) -> BoolArray:
        """Return True for each set of joint parameters, (B, P), with a positive inertia.

        The inertia has to be positive for every record.
        """
        found = [
            self.of_record(i).have_inertia(np.array([self.own(each, i) for each in physical]))
            for i in range(len(self.members))
        ]
        return np.asarray(np.all(found, axis=0))

    def of_record(self, record: int) -> Form:
        """Return the inverse model of one record, in the parameters of that record's axis."""
        return InverseForm(self.members[record].axis)

    def own(self, physical: Array, record: int) -> Array:
        """Return the parameters of one record's axis, (b,), for joint parameters (P,).

        They are ``into mu + offset``, see `Member`. If the drive gain is identified, both terms are
        multiplied by kappa, and the offset is the last column of `record_jacobian`. The result then
        belongs to the declared gain, with which the record's force is computed.
        """
        offset = self.members[record].offset if self.gain is None else 0.0
        return np.asarray(
            self.record_jacobian(record) @ self.regressed(physical) + offset, dtype=float
        )

    def record_jacobian(self, record: int) -> Array:
        """Return the derivatives of a record's parameters by those of the regression, (b, P)."""
        member = self.members[record]
        if self.gain is None:
            return member.into
        return np.column_stack([member.into, member.offset])

    def placed(self, record: int, intercept: Array, regressor: Array) -> tuple[Array, Array]:
        """Return a record's intercept (n,) and regressor (n, P) in the regression's parameters.

        If the drive gain is identified, the known force of the record is the column of kappa, and
        the intercept is 0.

        Parameters
        ----------
        record : int
            Index of the record.
        intercept, regressor : (n,) and (n, b) array
            Intercept and regressor in the parameters of the record's axis.
        """
        member = self.members[record]
        columns, force = regressor @ member.into, intercept + regressor @ member.offset
        if self.gain is None:
            return force, columns
        return np.zeros(len(force)), np.column_stack([columns, force])


def joint_form_of(
    axis: GeneratedAxis,
    records: int,
    known: KnownValues,
    local: Iterable[str],
    *,
    commanded: bool,
) -> JointForm:
    """Return the joint form of several records of an axis.

    Parameters
    ----------
    axis : GeneratedAxis
    records : int
        Number of records.
    known : KnownValues
        Known values of each record by name.
    local : iterable of str
        Names of parameters that each record has its own value of, see `declared_names`.
    commanded : bool
        True if the force of all records is computed from the control. The drive gain is then
        identified if known forces allow it.

    Raises
    ------
    UsageError
        A name is no declared parameter and no gain of the control law, or is given twice.
    ModelError
        A parameter without known values enters nonlinearly.
    """
    # Base parameters of each record as sums of products of unknown parameters.
    names = declared_names(axis, local)
    _check(axis, records, known, names)
    axes = _axes(axis, records, known)
    terms = [_terms(own, i, known, names) for i, own in enumerate(axes)]
    products = [*dict.fromkeys(p for of_one in terms for row in of_one for p in row if p[0])]
    # Local products lead a sum, so that each record has its own parameter.
    products.sort(key=lambda p: (p[1] is None, _place(axis, p)))
    # Exact matrices from the products to the base parameters, and known parts of these.
    tables = [[[row.get(p, Fraction(0)) for p in products] for row in of_one] for of_one in terms]
    offsets = [[row.get(((), None), Fraction(0)) for row in of_one] for of_one in terms]
    every = [row for table in tables for row in table]
    found, local_names = _common(axis, products, every, names, records)
    members = tuple(
        Member(
            axis=own,
            into=np.array([[float(row[j]) for j, *_ in found] for row in table]),
            offset=np.array([float(x) for x in offset]),
        )
        for own, table, offset in zip(axes, tables, offsets, strict=True)
    )
    # The drive gain is the last parameter, if it is identifiable.
    drive = axis.drive
    gain: float | None = None
    parameters = [parameter for _, parameter, _ in found]
    expressions = [expression for *_, expression in found]
    if commanded and drive.is_gain and _is_gain_identifiable(members):
        gain = drive.gain
        parameters.append(drive_gain_of(axis))
        expressions.append("")
    return JointForm(
        axis,
        parameters=tuple(parameters),
        expressions=tuple(expressions),
        members=members,
        local=local_names,
        known=known,
        gain=gain,
    )


def declared_names(axis: GeneratedAxis, names: Iterable[str]) -> tuple[str, ...]:
    """Return names of declared parameters for given names, each once.

    The name of a base parameter, which is a sum, is replaced by that of the first declared
    parameter in the sum.
    """
    declared, base = axis.declared.parameters, axis.base
    leads = {
        q.name: next(
            p.name
            for weight, powers in zip(weights, base.exponents, strict=True)
            for p, power in zip(declared, powers, strict=True)
            if weight and power
        )
        for q, weights in zip(base.axis.parameters, base.weights, strict=True)
    }
    return tuple(dict.fromkeys(leads.get(name, name) for name in names))


def perturbed_joint_forms(axis: GeneratedAxis, joint: JointForm | None) -> Iterator[JointForm]:
    """Yield joint forms, in each of which one known value is changed by its standard error.

    There is one form for each uncertain known value. The value is increased, or decreased if the
    increased value is out of bounds: only the square of the resulting change is used. Nothing is
    yielded if `joint` is None.
    """
    if joint is None:
        return
    records, commanded = len(joint.members), joint.gain is not None
    declared = {p.name: p for p in axis.declared.parameters}
    for name, values in joint.known.items():
        # Equal values with equal standard deviations are one measurement with one error in all
        # records.
        for measured in dict.fromkeys(pair for pair in values if pair[1] > 0):
            change = measured[1]
            if name in declared and not declared[name].allows(sum(measured)):
                change = -change
            changed = tuple((v + change * ((v, sd) == measured), sd) for v, sd in values)
            known = {**joint.known, name: changed}
            yield joint_form_of(axis, records, known, joint.local, commanded=commanded)


def _check(axis: GeneratedAxis, records: int, known: KnownValues, local: tuple[str, ...]) -> None:
    """Refuse known values and names of local parameters that do not suit the axis.

    The arguments are those of `joint_form_of`, with local names from `declared_names`.
    """
    declared, law = {p.name: p for p in axis.declared.parameters}, axis.declared.control
    gains = [*law.gains] if law is not None else []
    bounded = [(declared[name], each) for name, each in known.items() if name in declared]
    fixed = axis.base.known
    values = [f"{p.known}+-{p.known_sd}" if p.known_sd else f"{p.known}" for p in fixed]
    settings = [
        setting("known", {p.name: (value,) * records})
        for p, value in zip(fixed, values, strict=True)
    ]
    refuse(
        UsageError,
        *(
            (
                name not in (*declared, *gains),
                f"known values are given for {name!r}, which is neither a parameter nor a gain of "
                f"axis {axis.name!r}. Choose from {', '.join((*declared, *gains))}",
            )
            for name in known
        ),
        *(
            (
                not all(p.lower <= value <= p.upper for value, _ in each),
                f"the known values of {p.name!r} are "
                + ", ".join(f"{value:g}" + f" +- {sd:g}" * (sd > 0) for value, sd in each)
                + f", but its bounds are {p.lower:g} and {p.upper:g}. Give values within the "
                "bounds",
            )
            for p, each in bounded
        ),
        *(
            (
                name not in declared,
                f"there is no parameter {name!r} to estimate separately for each record. Axis "
                f"{axis.name!r} has {', '.join(declared)}",
            )
            for name in local
        ),
        *(
            (
                name in known,
                f"{name!r} is local, so that it is estimated for each record, but it also has "
                "known values. Give only one of the two",
            )
            for name in local
        ),
        (
            fixed,
            f"{' and '.join(p.name for p in fixed)} {'is' if len(fixed) == 1 else 'are'} fixed, "
            "which is only possible if the records share all parameters. Give the value for each "
            f"record instead: {' and '.join(settings)}",
        ),
        (
            {*known} >= {*declared},
            "every parameter has known values. Leave at least one parameter to identify",
        ),
        code="parameters",
    )


def _axes(axis: GeneratedAxis, records: int, known: KnownValues) -> list[GeneratedAxis]:
    """Return the axis of each record; records with equal known values share one axis.

    Raises
    ------
    ModelError
        A parameter without known values enters nonlinearly.
    """
    law = axis.declared.control
    gains = {*law.gains} if law is not None else set[str]()
    nonlinear = {
        p.name
        for p, is_nonlinear in zip(axis.axis_parameters, axis.nonlinear, strict=True)
        if is_nonlinear
    }
    unknown = sorted(nonlinear - {*known})
    if unknown:
        enter, their, them = "enters", "its value", unknown[0]
        if len(unknown) > 1:
            enter, their, them = "enter", "their values", "these parameters"
        raise ModelError(
            f"{', '.join(unknown)} of axis {axis.name!r} {enter} nonlinearly. Known or local "
            "values of each record are only possible if all other parameters enter linearly. Give "
            f"{their} for each record, or leave {them} out of the model.",
            code="parameters",
        )
    # Known values that change the functions of the axis; linear parameters change `Member.offset`.
    inserted = {name: each for name, each in known.items() if name in nonlinear or name in gains}
    own = [tuple((name, each[i][0]) for name, each in inserted.items()) for i in range(records)]
    variants = {values: _variant(axis, dict(values), gains) for values in dict.fromkeys(own)}
    return [variants[values] for values in own]


def _variant(axis: GeneratedAxis, own: Mapping[str, float], gains: set[str]) -> GeneratedAxis:
    """Return the axis with a record's known values in place of parameters and law gains."""
    declared = axis.declared
    values = {name: value for name, value in own.items() if name not in gains}
    if values:
        axis = build(leave_out(declared, **values), native=axis.native.enabled)
    changed = {name: own[name] for name in gains if name in own}
    if changed and axis.loop is not None:
        return axis.with_gains(changed)
    if changed and declared.control is not None:  # a continuous law has its gains compiled in
        law = replace(declared.control, gains={**declared.control.gains, **changed})
        return build(replace(axis.declared, control=law), native=axis.native.enabled)
    return axis


def _terms(
    axis: GeneratedAxis, record: int, known: KnownValues, local: tuple[str, ...]
) -> list[dict[_Product, Fraction]]:
    """Return each base parameter of a record as a sum of products of unknown parameters.

    A sum is a mapping of products to their factors, in which the known values are inserted. A
    product with a local parameter (of the names `local`) belongs to this record alone.
    """
    base, values = axis.base, {n: _exact(each[record][0]) for n, each in known.items()}
    names = [p.name for p in base.declared.parameters]
    # Product of the unknown parameters, and factor of the known values, in each declared product.
    split: list[tuple[_Product, Fraction]] = []
    for powers in base.exponents:
        factors = {name: e for name, e in zip(names, powers, strict=True) if e}
        inserted = (values[name] ** e for name, e in factors.items() if name in values)
        factor = math.prod(inserted, start=Fraction(1))
        unknown = tuple((name, e) for name, e in factors.items() if name not in values)
        is_local = any(name in local for name, _ in unknown)
        split.append(((unknown, record if is_local else None), factor))
    # Sums of these products.
    found = []
    for weights in base.weights:
        row: dict[_Product, Fraction] = {}
        for weight, (product, factor) in zip(weights, split, strict=True):
            if weight and factor:
                row[product] = row.get(product, Fraction(0)) + _exact(weight) * factor
        found.append(row)
    return found


def _exact(value: float) -> Fraction:
    """Return the exact fraction of the decimal representation of a float."""
    return Fraction(repr(float(value)))


def _place(axis: GeneratedAxis, product: _Product) -> tuple[int, int, int]:
    """Return the sort key of a product: index of its first parameter, degree, record."""
    names = [p.name for p in axis.declared.parameters]
    powers, record = product
    return names.index(powers[0][0]), sum(e for _, e in powers), -1 if record is None else record


def _common(
    axis: GeneratedAxis,
    products: Sequence[_Product],
    rows: list[list[Fraction]],
    names: Sequence[str],
    records: int,
) -> tuple[list[CommonParameter], dict[str, tuple[str, ...]]]:
    """Return the joint parameters, and the names of each local parameter by record.

    A joint parameter has the index of its first product, the parameter, and its expression.

    Parameters
    ----------
    axis : GeneratedAxis
    products : sequence of _Product
        Products of declared parameters.
    rows : list of list of Fraction
        Factors of the products in each base parameter of each record.
    names : sequence of str
        Names of the local declared parameters.
    records : int
        Number of records.
    """
    taken = {p.name.lower() for p in axis.declared.parameters} | {GAIN}
    alone = {p.name: p for p in axis.declared.parameters}
    symbols: list[Parameter | None] = []
    for powers, record in products:
        declared = alone[powers[0][0]] if _is_single(powers) else None
        if declared is not None and record is not None:
            name = fresh_name(f"{declared.name}_{record + 1}", taken)
            description = f"{declared.name} of record {record + 1}"
            declared = replace(declared, name=name, description=description)
        symbols.append(declared)
    found = common_parameters(axis.declared, products, symbols, rows, taken)
    found.sort(key=lambda each: _place(axis, products[each[0]]))
    local = {name: [""] * records for name in names}
    for pivot, parameter, _ in found:
        powers, record = products[pivot]
        if record is not None and _is_single(powers):
            local[powers[0][0]][record] = parameter.name
    return found, {name: tuple(of_records) for name, of_records in local.items()}


def _is_single(powers: tuple[tuple[str, int], ...]) -> bool:
    """Return True if a product, given by names and powers, is a single parameter."""
    return len(powers) == 1 and powers[0][1] == 1


def _is_gain_identifiable(members: Sequence[Member]) -> bool:
    """Return True if known values make a force from which the drive gain can be identified.

    This is so if the offsets of all records are linearly independent of the joint parameters'
    columns.
    """
    into = np.concatenate([member.into for member in members])
    offset = np.concatenate([member.offset for member in members])
    columns = into / column_sizes(into)
    remainder = offset - columns @ np.linalg.lstsq(columns, offset, rcond=None)[0]
    return bool(np.linalg.norm(remainder) > _SAME * np.linalg.norm(offset))


def drive_gain_of(axis: GeneratedAxis) -> Parameter:
    """Return the drive gain as a parameter with its declared value as nominal value."""
    drive, q = axis.drive, axis.coordinate
    over = drive.unit if drive.unit.isalpha() else f"({drive.unit})"
    unit = f"{q.force_unit}/{over}"
    return Parameter(GAIN, unit, nominal=drive.gain, description="force per control")
