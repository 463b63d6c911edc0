"""Sticking control valves: models with known truth, the loops around them, and the diagnosis of recorded loops.

Controller output (OP), valve position (VP), S (stick band plus dead band) and J (slip jump) are in percent of
span, times in seconds, the process value (PV) in its own units. Everything is computed by the Rust library of
the same name; the same input gives the same numbers there, here and on the command line.

Examples
--------
>>> import stiction
>>> stiction.valve([50, 52, 54, 55, 53], S=5, J=2)
array([50. , 50. , 52.5, 53.5, 53.5])
"""

from stiction import detection, diagnosis, identification, loops, oscillations, recordings, valves, weighing
from stiction._core import __version__
from stiction.detection import *
from stiction.diagnosis import *
from stiction.identification import *
from stiction.loops import *
from stiction.oscillations import *
from stiction.recordings import *
from stiction.valves import *
from stiction.weighing import *

__all__ = [
    "__version__",
    *detection.__all__,
    *diagnosis.__all__,
    *identification.__all__,
    *loops.__all__,
    *oscillations.__all__,
    *recordings.__all__,
    *valves.__all__,
    *weighing.__all__,
]
