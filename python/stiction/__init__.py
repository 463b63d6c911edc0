"""Sticking control valves: models with known truth, the loops around them, and the diagnosis of recorded loops.

Controller output (OP), valve position (VP), S (stick band plus dead band) and J (slip jump) are in percent of span. Times are
in seconds, and the process value (PV) is in its own units. The Rust library of the same name does all computations. The same input
gives the same numbers there, here and on the command line.

Examples
--------
>>> import stiction
>>> stiction.valve([50, 52, 54, 55, 53], S=5, J=2)
array([50. , 50. , 52.5, 53.5, 53.5])
"""

import warnings as _warnings

from stiction import (
    bench,
    closed_loop,
    compensation,
    cycles,
    datasets,
    detection,
    diagnosis,
    fitting,
    fmu,
    fusion,
    identification,
    oscillations,
    own,
    populations,
    recordings,
    series,
    stem,
    valve_test,
    valves,
    whatif,
)
from stiction._core import __version__

# With `diagnosis` alone, mypy would not recognise these as types.
from stiction._document import *
from stiction.closed_loop import *
from stiction.compensation import *
from stiction.cycles import *
from stiction.detection import *
from stiction.diagnosis import *
from stiction.fitting import *
from stiction.fusion import *
from stiction.identification import *
from stiction.oscillations import *
from stiction.own import *
from stiction.populations import *
from stiction.recordings import *
from stiction.series import *
from stiction.stem import *
from stiction.valves import *
from stiction.whatif import *

__all__ = [
    "__version__",
    *closed_loop.__all__,
    *compensation.__all__,
    *cycles.__all__,
    *detection.__all__,
    *diagnosis.__all__,
    *fitting.__all__,
    *fusion.__all__,
    *identification.__all__,
    *oscillations.__all__,
    *own.__all__,
    *populations.__all__,
    *recordings.__all__,
    *series.__all__,
    *stem.__all__,
    *valves.__all__,
    *whatif.__all__,
]

_RENAMED = {"Stretch": "Segment", "stretches": "segments"}


def __getattr__(name: str) -> object:
    if name not in _RENAMED:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    _warnings.warn(f"stiction.{name} is now called {_RENAMED[name]}", DeprecationWarning, stacklevel=2)
    return globals()[_RENAMED[name]]
