from .artefacts import GeneratedAxis as GeneratedAxis, Quantity as Quantity
