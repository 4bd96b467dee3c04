"""Declare an axis and derive its models. SymPy only: no numerics.

The dynamics are SI and on the load side: ``tau = IDM(q, dq, ddq) theta + known`` and, for constant
inertia, ``ddq = DDM(tau, q, dq) theta_ddm + known``.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
