from .declaration import Move as Move
from .derivation import AxisModel as AxisModel
from .library import LIBRARY as LIBRARY
from .wording import describe_determined as describe_determined
from .wording import describe_unidentifiable as describe_unidentifiable
