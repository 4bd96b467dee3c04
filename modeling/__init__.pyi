from .declaration import Move as Move
from .derivation import AxisModel as AxisModel
from .library import LIBRARY as LIBRARY
from .wording import describe_hidden as describe_hidden
from .wording import describe_settled as describe_settled
