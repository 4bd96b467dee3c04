from .generated_axes import GeneratedAxis as GeneratedAxis, Quantity as Quantity
