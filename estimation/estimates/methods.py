"""Every method of estimation, by the name that users give."""

from axisid.estimation.regression import DirectForm, InverseForm

from .instrumental import Instruments
from .least_squares import LeastSquares
from .method import Method

#: In the order in which they are run.
METHODS: dict[str, Method] = {
    method.name: method
    for method in (
        LeastSquares(name="idm-ls", form=InverseForm),
        LeastSquares(name="ddm-ls", form=DirectForm),
        Instruments(name="idm-iv", form=InverseForm),
        Instruments(name="ddm-iv", form=DirectForm),
    )
}
