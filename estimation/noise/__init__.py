"""What noise in the regressor does to an estimate.

In: estimates of one record. Out: how far least squares is from instruments, and these from DIDIM,
whether that is more than chance, and how far the two forms of least squares are from each other.
Knows nothing of verdicts.
"""

from .attenuation import NO_ATTENUATION as NO_ATTENUATION
from .attenuation import Attenuation as Attenuation
from .attenuation import attenuation as attenuation
from .bias import NoiseBias as NoiseBias
from .bias import noise_bias as noise_bias
from .bias import noise_biases as noise_biases
from .second_opinion import second_opinion as second_opinion
