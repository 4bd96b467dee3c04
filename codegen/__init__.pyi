from .artefacts import GeneratedAxis as GeneratedAxis
from .artefacts import Quantity as Quantity
