"""Sticking control valves: models with known truth, simulated loops, and the diagnosis of recorded loops.

Controller output (OP), valve position (VP), S (stick band plus dead band) and J (slip jump) are in percent of span. Times are in
seconds, and the process value (PV) is in its own units. The Rust library of the same name does all computations. The same input
gives the same numbers in Rust, in Python and on the command line.

The most used functions are in ``stiction`` itself. All other names are in the modules, as ``stiction.cycles.describing_function``.
``help(stiction.diagnose)`` and ``help(stiction.cycles)`` describe parameters, results and errors.

Functions and classes
---------------------
read                       recordings of loops from a file
recording                  a recording from arrays
recording_from             a recording from a table of pandas, polars or pyarrow
diagnose                   the verdict on the valve of a recording, with S, J, causes and remedies
diagnose_all               the verdicts on many recordings, on all processors
summary_table              a table of diagnoses with one row per loop
detect                     the result of one method
evidence, weigh            the numbers behind a verdict, and the trained model that weighs them
fit                        controller, process and valve of a recording, and the effect of each action
what_if                    the effect of repair, retuning, compensators and positioner on a loop
scenario                   a loop to simulate, from a name, a file or dictionaries
simulate, sweep            the signals of one simulated loop, and statistics of many
limit_cycle                the predicted limit cycle of a loop
signal                     a test signal
valve, Stem                the position of a valve model for a series of OP values, and the physical valve
population                 simulated loops with known truth

Modules
-------
stiction.recordings        recordings from files, tables and arrays, their segments and fitness
stiction.datasets          sample recordings with known truth
stiction.diagnosis         verdicts, their combination over time, reports, and all classes of a diagnosis
stiction.detection         the methods that detect stiction
stiction.fusion            the evidence and the trained model
stiction.oscillations      whether a signal oscillates, with which period, and when
stiction.identification    models of process, valve and stem fitted to signals
stiction.fitting           the fitted loop and the predicted effect of actions
stiction.whatif            actions for a loop whose valve sticks
stiction.compensation      compensators and their comparison
stiction.valve_test        plan and evaluation of a test of a valve, and comparison before and after a repair
stiction.valves            valve models, sample by sample and over series
stiction.stem              the physical valve with its friction laws
stiction.closed_loop       scenarios, and simulation of loops, cascades and valves alone
stiction.own               base classes for a valve, controller or process of your own
stiction.cycles            limit cycles, describing functions, frequency responses and tuning rules
stiction.populations       populations of simulated loops with known truth
stiction.bench             the benchmark of detectors
stiction.series            functions on series of samples
stiction.fmu               export of FMUs for Simulink, OpenModelica, Dymola and FMPy

Import these modules by name, as in ``import stiction.plant``:

stiction.plant             a plant of many loops, day by day, and on Apache Spark
stiction.live              live data from OPC UA servers, SQL databases and PI
stiction.pandas            ``frame.stiction`` for data frames
stiction.sklearn           estimators for scikit-learn
stiction.control           valves and loops for python-control

Examples
--------
>>> import stiction
>>> loop = stiction.datasets.load("FIC101-sticky")
>>> found = stiction.diagnose(loop)
>>> found.verdict.class_, round(found.stiction.S.value)
('sticks', 4)
>>> stiction.valve([50, 52, 54, 55, 53], S=5, J=2)
array([50. , 50. , 52.5, 53.5, 53.5])
"""

import typing as _typing

from stiction import bench as bench
from stiction import closed_loop as closed_loop
from stiction import compensation as compensation
from stiction import cycles as cycles
from stiction import datasets as datasets
from stiction import detection as detection
from stiction import diagnosis as diagnosis
from stiction import fitting as fitting
from stiction import fmu as fmu
from stiction import fusion as fusion
from stiction import identification as identification
from stiction import oscillations as oscillations
from stiction import own as own
from stiction import populations as populations
from stiction import recordings as recordings
from stiction import series as series
from stiction import stem as stem
from stiction import valve_test as valve_test
from stiction import valves as valves
from stiction import whatif as whatif
from stiction._core import __version__ as __version__
from stiction.closed_loop import scenario as scenario
from stiction.closed_loop import signal as signal
from stiction.closed_loop import simulate as simulate
from stiction.closed_loop import sweep as sweep
from stiction.cycles import limit_cycle as limit_cycle
from stiction.detection import detect as detect
from stiction.diagnosis import diagnose as diagnose
from stiction.diagnosis import diagnose_all as diagnose_all
from stiction.diagnosis import summary_table as summary_table
from stiction.fitting import fit as fit
from stiction.fusion import evidence as evidence
from stiction.fusion import weigh as weigh
from stiction.populations import population as population
from stiction.recordings import read as read
from stiction.recordings import recording as recording
from stiction.recordings import recording_from as recording_from
from stiction.stem import Stem as Stem
from stiction.valves import valve as valve
from stiction.whatif import what_if as what_if

if not _typing.TYPE_CHECKING:

    def __getattr__(name):
        """Return a public name of any module, for short lines at a prompt. `dir` lists only the names above."""
        modules = [value for value in globals().values() if isinstance(value, type(_typing))]
        for module in modules:
            if name in getattr(module, "__all__", ()) and module.__name__.startswith("stiction."):
                return getattr(module, name)
        raise AttributeError(f"module 'stiction' has no attribute {name!r}")
