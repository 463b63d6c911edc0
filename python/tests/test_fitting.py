"""Fits: the loop behind a recording, as a scenario, what could be done about it, and what came of that."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import matplotlib
import numpy as np
import pytest
import stiction
from stiction._result import Result

matplotlib.use("Agg")
import matplotlib.pyplot as plt

ROOT = Path(__file__).parents[2]
HEALTHY = {"valve.S": 0.4, "valve.J": 0.1}


def recorded(settings=None, *, signals=("op", "pv", "sp"), **told):
    run = stiction.simulate("samples/sticky-flow", settings)
    return stiction.recording(**{name: getattr(run, name) for name in signals}, sample_time=1, name="FIC101", **told)


def intervals(result):
    """All estimates in a result."""
    for value in result:
        if isinstance(value, stiction.diagnosis.Estimate):
            yield value
        elif isinstance(value, Result):
            yield from intervals(value)


@pytest.fixture(scope="module")
def loop():
    [loop] = stiction.read(ROOT / "samples" / "FIC101-sticky.csv")
    return loop


@pytest.fixture(scope="module")
def fitted(loop):
    return stiction.fit(loop)


def test_the_loop_behind_the_sample_is_found(fitted):
    # The truth is that of the scenario samples/sticky-flow.
    assert fitted.name == "FIC101-sticky" and fitted.sample_time_s == 1 and fitted.why_not == {}
    controller, process, valve, cycle = fitted.controller, fitted.process, fitted.valve, fitted.cycle
    assert controller.structure == "PI" and controller.td is None and controller.explained > 0.99
    assert controller.kc.low < 0.45 < controller.kc.high and abs(controller.kc.value - 0.45) < 0.02
    assert controller.ti.low < 6 < controller.ti.high and abs(controller.ti.value - 6) < 0.3
    assert valve.model == "two-phase" and abs(valve.S.value - 4) < 0.5 and valve.follows < 0.05
    assert valve.from_ == "the evidence in OP and PV"
    assert process.kind == "self-regulating" and process.gain.value > 0 and process.jointly is None
    assert cycle.explained is True and cycle.cycling > 0.9 and cycle.sentence.endswith("The valve explains the swing.")
    assert abs(cycle.recorded.period_s - 73.86) < 0.01
    assert cycle.predicted.period_s.low < cycle.predicted.period_s.value < cycle.predicted.period_s.high
    found = list(intervals(fitted))
    assert len(found) >= 10 and all(each.low <= each.value <= each.high for each in found)


def test_the_scenario_cycles_as_recorded(fitted):
    scenario = fitted.scenario()
    assert isinstance(scenario, stiction.closed_loop.Scenario) and scenario.kind == "closed loop" and scenario.notes == []
    assert scenario.model == "two-phase" and fitted.valve.S.low <= scenario.bands.S <= fitted.valve.S.high
    assert "90 % intervals" in scenario.text
    assert stiction.scenario(scenario) == scenario == pickle.loads(pickle.dumps(scenario))
    cycle = stiction.limit_cycle(scenario).cycle
    assert cycle.stable and abs(cycle.period_s / fitted.cycle.recorded.period_s - 1) < 0.25
    assert len(stiction.simulate(scenario).pv) > 0
    assert {row.action for row in stiction.what_if(scenario, methods=[]).rows} >= {"as it is", "valve repaired"}


def test_prospects_are_ranked_with_intervals(fitted):
    prospects = fitted.prospects()
    actions = {row.action: row for row in prospects.actions}
    assert {"as it is", "valve repaired", "repaired and retuned"} <= actions.keys() and prospects.loops > 2
    # Ranked by the pessimistic end; those as good as each other by effort.
    worst = [row.error_ratio.high for row in prospects.actions]
    assert all(first <= 1.15 * later for k, first in enumerate(worst) for later in worst[k:])
    repaired, present = actions["valve repaired"], actions["as it is"]
    assert repaired.pv_swing_ratio.value < 0.5 and repaired.sure >= 0.95 and repaired.tuning is None
    assert present.pv_swing_ratio.to_dict() == {"value": 1, "low": 1, "high": 1} and present.sure == 0
    tuning = actions["repaired and retuned"].tuning
    assert tuning.kc > 0 and tuning.ti > 0 and tuning.ms.low > 1 and "SIMC" in tuning.rule
    assert any(sentence.startswith("Repair the valve") for sentence in prospects.advice)
    assert fitted.prospects().to_dict() == prospects.to_dict()


def test_what_came_of_an_action():
    before = stiction.fit(recorded())
    mended = before.ring(recorded(HEALTHY))
    assert mended.action == "valve repaired" and mended.as_predicted and mended.after < 0.8 * mended.before
    assert mended.sentence.startswith("PV swing before: ")
    same = before.ring(recorded(), "repair")
    assert not same.as_predicted and same.after == same.before and "no better than before" in same.sentence
    assert before.ring(recorded(), "nothing").action == "as it is"
    # Nobody would try to tell what a method brings that an ordinary controller cannot carry out.
    with pytest.raises(ValueError, match='there is no prediction for "six-move"'):
        before.ring(recorded(), "six-move")


def test_what_is_missing_is_reported(loop):
    with pytest.raises(ValueError, match="loop FIC101: without a PV no loop can be fitted; export the PV"):
        stiction.fit(recorded(signals=("op",)))
    still = stiction.fit(stiction.recording(np.full(500, 50.0), np.full(500, 1.0), sample_time=1, name="FIC9"))
    assert still.controller is still.process is still.valve is still.cycle is None
    assert set(still.why_not) == {"controller", "process", "valve", "cycle"} and all(still.why_not.values())
    for ask in (still.scenario, still.prospects, still.plot):
        with pytest.raises(ValueError, match=f"loop FIC9: .*{still.why_not['controller']}"):
            ask()
    # A healthy valve: nothing is promised of what would be done to it.
    [disturbed] = stiction.read(ROOT / "samples" / "FIC102-disturbed.csv")
    healthy = stiction.fit(disturbed)
    assert healthy.valve.follows > 0.5 and healthy.cycle.explained is False
    with pytest.raises(ValueError, match="the valve follows its OP, so the benefit of a repair is unknown"):
        healthy.prospects()


def test_the_set_point_may_be_missing(fitted):
    found = stiction.fit(recorded(signals=("op", "pv")))
    assert found.controller.set_point.low < 60 < found.controller.set_point.high
    assert fitted.controller.set_point is None and found.controller.kc.low < 0.45 < found.controller.kc.high


def test_the_seed_decides(loop, fitted):
    with ThreadPoolExecutor(2) as threads:
        one, again = threads.map(lambda _: stiction.fit(loop), range(2))
    assert one.to_dict() == again.to_dict() == fitted.to_dict() and repr(one) == repr(fitted)
    other = stiction.fit(loop, seed=2)
    assert other.cycle.predicted.period_s.to_dict() != fitted.cycle.predicted.period_s.to_dict()
    assert other.controller.to_dict() == fitted.controller.to_dict()
    assert stiction.fit(loop, draws=30).cycle.predicted.period_s.to_dict() != fitted.cycle.predicted.period_s.to_dict()


def test_a_grid_can_be_requested_for(loop, fitted):
    coarse = stiction.fit(loop, sample_time=2, loop_type="flow")
    assert coarse.sample_time_s == 2 == coarse.segment.sample_time
    assert len(coarse.segment.op) == len(fitted.segment.op) // 2


def test_it_pickles(fitted):
    again = pickle.loads(pickle.dumps(fitted))
    assert repr(again) == repr(fitted) and again.to_dict() == fitted.to_dict()
    assert again.scenario() == fitted.scenario()
    assert again.prospects().to_dict() == fitted.prospects().to_dict()
    assert pickle.loads(pickle.dumps(fitted.prospects())).advice == fitted.prospects().advice


def test_plots(fitted):
    axes = fitted.plot()
    assert len(axes) == 4 and axes[-1].get_xlabel() == "time (s)"
    assert axes[0].get_ylim() == axes[2].get_ylim() and axes[1].get_ylim() == axes[3].get_ylim()
    measured = recorded(signals=("op", "pv", "vp"))
    assert len(stiction.fit(measured).plot()) == 4
    error = fitted.prospects().plot()[1]
    assert [label.get_text() for label in error.get_yticklabels()] == [r.action for r in fitted.prospects().actions]
    with pytest.raises(ValueError, match="ax holds 1 axes, but 4 are needed"):
        fitted.plot(plt.gca())
    plt.close("all")


LOOP = stiction.recording(50 + np.sin(np.arange(300) / 7), np.cos(np.arange(300) / 7), sample_time=1)
BAD = [
    (lambda: stiction.fit("FIC101.csv"), TypeError, "recording must be a Recording or a table, but its type is str"),
    (lambda: stiction.fit(LOOP, draws=0), ValueError, "draws is 0, but must be at least 1"),
    (lambda: stiction.fit(LOOP, draws=10_001), ValueError, "draws is 10001, but must be at most 10000"),
    (lambda: stiction.fit(LOOP, draws=1.5), TypeError, "draws must be a whole number"),
    (lambda: stiction.fit(LOOP, seed=-1), ValueError, "seed is -1, but must be at least 0"),
    (lambda: stiction.fit(LOOP, seed=2**64), ValueError, "seed is 18446744073709551616, but must be below"),
    (lambda: stiction.fit(LOOP, loop_type="flo"), ValueError, 'no loop type named "flo"'),
    (lambda: stiction.fit(LOOP, loop_type=3), TypeError, "loop_type must be a string"),
    (lambda: stiction.fit(LOOP, sample_time="1"), TypeError, "sample_time must be a number"),
    (lambda: stiction.fit(LOOP, sample_time=0), ValueError, "loop loop: the sample time is 0"),
    (lambda: stiction.fit(LOOP).ring(3), TypeError, "after must be a Recording or a table, but its type is int"),
    (lambda: stiction.fit(LOOP).ring(LOOP, "mend"), ValueError, "action is 'mend', but must be one of 'nothing', 'repair'"),
    (lambda: stiction.fit(LOOP).ring(LOOP, 3), TypeError, "action must be a string"),
]


@pytest.mark.parametrize(("call", "error", "words"), BAD, ids=range(len(BAD)))
def test_bad_arguments_are_refused_by_name(call, error, words):
    with pytest.raises(error, match=words):
        call()
