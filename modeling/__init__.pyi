from .declaration import (
    Column as Column,
    Experiment as Experiment,
    Move as Move,
    back_and_forth as back_and_forth,
)
from .derivation import (
    AxisModel as AxisModel,
    describe_determined as describe_determined,
    describe_unidentifiable as describe_unidentifiable,
)
from .library import LIBRARY as LIBRARY
