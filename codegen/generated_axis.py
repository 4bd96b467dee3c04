"""The generated axis: what estimation knows of an axis. No SymPy beyond this point."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from axisid.modeling import Axis, AxisModel, derive, describe_direction

from .artefacts import FUNCTIONS, axis_artefacts, signature
from .execute import execute

Array = NDArray[np.float64]

_VECTORS = frozenset({"parameters", "ddm_parameters", "state"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """A named number's label: ``M`` in ``kg``; `expression` says how it is made, if it is."""

    name: str
    unit: str
    expression: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class GeneratedAxis:
    """An axis as named CasADi functions, with the labels its results need.

    Attributes
    ----------
    axis : Axis
        The declaration (names, units, nominal values, drive, law, columns).
    signature : str
        Sha256 of what the functions were generated from.
    parameters : tuple of Quantity
        Physical parameters, length p.
    ddm_parameters : tuple of Quantity
        Of the direct model, length m; empty without a direct regressor.
    ddm_refusal : str
        Why there is no direct regressor, or no way back from it; else empty.
    functions : mapping of str to casadi.Function
        See `axisid.codegen.functions`.
    """

    axis: Axis
    signature: str
    parameters: tuple[Quantity, ...]
    ddm_parameters: tuple[Quantity, ...]
    ddm_refusal: str
    functions: Mapping[str, Any]

    @property
    def nominal(self) -> Array:
        """A-priori parameters, (p,)."""
        return np.array([p.nominal for p in self.axis.parameters])

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the physical parameters."""
        return tuple(p.name for p in self.parameters)

    def describe(self, parameters: Array) -> str:
        """Physical parameters in words: ``M = 95.1 kg, Fv = 203.5 N/(m/s)``."""
        pairs = zip(self.parameters, parameters, strict=True)
        return ", ".join(f"{p.name} = {value:.6g} {p.unit}" for p, value in pairs)

    def rows(self, function: str, *arguments: ArrayLike) -> tuple[Array, ...]:
        """Evaluate a function of scalars at N samples.

        Parameters
        ----------
        function : str
            Its name.
        *arguments : array_like, (N,)
            One per argument, all of one length; the parameter vector, (p,), where one is taken.

        Returns
        -------
        tuple of (N, columns) arrays
            One per output.
        """
        compiled = self.functions[function]
        vectors = [name in _VECTORS for name in compiled.name_in()]
        given = [
            np.reshape(a, (-1, 1) if vector else (1, -1))
            for a, vector in zip(arguments, vectors, strict=True)
        ]
        samples = max(g.shape[1] for g in given)
        return tuple(out.full().reshape(samples, -1) for out in compiled.call(given))

    def mapped(self, function: str, values: ArrayLike) -> tuple[Array, Array]:
        """Apply a parameter map: the mapped vector and its Jacobian.

        Parameters
        ----------
        function : str
            ``ddm_from_physical`` or ``physical_from_ddm``.
        values : array_like
            Length p or m.
        """
        result, jacobian = self.functions[function](np.asarray(values, dtype=float))
        return result.full().ravel(), jacobian.full()


def build(axis: Axis) -> GeneratedAxis:
    """Derive an axis and build its functions from the text that `axisid generate` writes.

    Raises
    ------
    ModelError
        The axis cannot be derived or lowered.
    """
    model = derive(axis)
    mapping = model.parameter_map
    texts = axis_artefacts(model)
    return GeneratedAxis(
        axis=axis,
        signature=signature(model),
        parameters=tuple(Quantity(name=p.name, unit=p.unit) for p in axis.parameters),
        ddm_parameters=()
        if mapping is None
        else tuple(
            Quantity(name=str(symbol), unit=str(unit), expression=str(value))
            for symbol, unit, value in zip(
                mapping.symbols, mapping.units, mapping.forward, strict=True
            )
        ),
        ddm_refusal=_refusal(model),
        functions=execute(texts[FUNCTIONS], axis.name),
    )


def _refusal(model: AxisModel) -> str:
    mapping = model.parameter_map
    if mapping is None:
        return model.ddm_refusal
    if mapping.hidden:
        trades = "; ".join(map(describe_direction, mapping.hidden))
        return (
            f"axis {model.axis.name!r}: the direct model cannot tell its inertial parameters apart "
            f"(no motion shows a change of {trades}); declare their combination as one parameter"
        )
    return ""
