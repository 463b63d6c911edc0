"""Compensators and what-if: against the reference and against each other."""

import json
import math
import pickle
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import polars as pl
import pytest
import stiction

FIXTURES = Path(__file__).parents[2] / "crates" / "stiction-model" / "tests" / "fixtures"
REFERENCE = json.loads((FIXTURES / "compensation.json").read_text())
PAPER = "paper/closed-loop"
STICKY = {"valve.S": 5, "valve.J": 3}


def loop(S, J):
    return {
        "sample_time": 0.1,
        "duration": 600,
        "set_point": {"value": 5},
        "controller": {"kc": 1.1, "ti": 2.5},
        "valve": {"model": "kano", "S": S, "J": J},
        "process": {"gain": 1.5, "tau": 5.93, "delay": 1.07, "dead_time": "nearest"},
    }


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    plt.close("all")


@pytest.mark.parametrize("key", REFERENCE)
def test_the_reference_is_met(key):
    S, J, name = key.split("_", 2)
    S, J = float(S[1:]), float(J[1:])
    method, parameters = {
        "none": ("knocker", {"amplitude": 0}),
        "knocker_a=S/2_w2_h5": ("knocker", {"amplitude": S / 2, "width": 2, "period": 5}),
        "knocker_a=J/2_w2_h5": ("knocker", {"amplitude": J / 2, "width": 2, "period": 5}),
        "knocker_a=S_w1_h4": ("knocker", {"amplitude": S, "width": 1, "period": 4}),
        "CR_a=S/2": ("constant-reinforcement", {"amplitude": S / 2}),
        "CR_a=(S-J)/2": ("constant-reinforcement", {"amplitude": (S - J) / 2}),
        "open_two_move": ("two-move", {"steady OP": 5 / 1.5, "hold": 0.1, "settle": 30}),
    }[name]
    done = stiction.compensation.compensate(
        loop(S, J), method=method, parameters=parameters, at_s=200, settle_s=200, window_s=200
    )
    before = stiction.compensation.compensate(loop(S, J), method="knocker", at_s=100, settle_s=0, window_s=100)
    sides = [("before", before.measures_without, 100), ("after", done.measures, 200)]
    for side, found, window in sides:
        expected = REFERENCE[key][side]
        for column, value in {
            "pv_std": found.pv_std,
            "pv_iae_per_s": found.iae_per_s,
            "mv_travel_per_s": found.vp_travel_per_s,
            "mv_reversals": found.reversals_per_h * window / 3600,
            "mv_halfpp": found.half_pp_vp,
            "op_halfpp": found.half_pp_op,
        }.items():
            assert value == pytest.approx(expected[column], rel=1e-6, abs=1e-9), (side, column)


def test_parameters_that_are_given_are_taken_and_others_chosen():
    done = stiction.compensation.compensate(PAPER, STICKY, method="supervised", parameters={"wake": 2, "amplitude": 1})
    values = {each.name: each.value for each in done.parameters}
    assert (values["wake"], values["amplitude"], values["width"]) == (2, 1, 2)
    for each in stiction.compensation.compensators():
        chosen = stiction.compensation.compensate(PAPER, STICKY, method=each.name, at_s=20, settle_s=10, window_s=20)
        same = {n.name: n.value for n in chosen.parameters if n.name not in {"S", "J"}}
        again = stiction.compensation.compensate(
            PAPER, STICKY, method=each.name, parameters=same, at_s=20, settle_s=10, window_s=20
        )
        assert again.signal.tolist() == chosen.signal.tolist(), each.name


def test_until_it_is_on_nothing_changes():
    done = stiction.compensation.compensate(PAPER, STICKY, method="knocker", at_s=50, settle_s=30, window_s=20)
    before = done.run.time_s < 50
    assert done.run.pv[before].tolist() == done.without.pv[before].tolist()
    assert done.signal[before].tolist() == done.run.op[before].tolist()
    assert len(done.signal) == len(done.run.op) == 100 / done.run.sample_time


def test_a_comparison_is_ranked_and_its_nominal_case_is_a_run():
    found = stiction.compensation.compare_compensators(PAPER, STICKY, methods=["knocker", "two-move"])
    worst = [row.worst_error for row in found.rows]
    assert worst == sorted(worst) and {row.action for row in found.rows} == {"as it is", "knocker", "two-move"}
    knocker = next(row for row in found.rows if row.action == "knocker")
    single = stiction.compensation.compensate(PAPER, STICKY, method="knocker")
    assert single.measures.to_dict() == knocker.outcomes[0].measures.to_dict()
    assert single.window_s == found.protocol.window_s and len(knocker.outcomes) == 6
    wrong = stiction.compensation.compare_compensators(PAPER, STICKY, methods=["knocker"], S=2.5, J=1.5)
    assert wrong.rows[0].outcomes[0].measures.iae_per_s == knocker.outcomes[1].measures.iae_per_s
    frame = pl.DataFrame(found.to_table())
    assert frame.height == 18 and frame["rank"].to_list() == np.repeat([1, 2, 3], 6).tolist()
    assert frame["iae_per_s"][0] == found.rows[0].error


@pytest.fixture(scope="module")
def paper():
    return stiction.what_if(PAPER, STICKY, methods=["knocker", "integral-limit"])


def test_what_if_ranks_and_recommends(paper):
    actions = [row.action for row in paper.rows]
    assert sorted(actions) == sorted(
        ["as it is", "valve repaired", "retuned", "positioner", "knocker", "integral-limit"]
    )
    worst = [row.worst_error for row in paper.rows]
    assert worst == sorted(worst)
    as_it_is = paper.rows[actions.index("as it is")]
    assert as_it_is.state == "cycle" and as_it_is.against == []
    assert as_it_is.cycle.period_s == stiction.limit_cycle(PAPER, STICKY).cycle.period_s
    assert paper.interim is None or paper.interim in actions
    assert any("Repair the valve" in sentence for sentence in paper.recommendation) and paper.assumptions
    assert paper.retuning.best.ms <= 2 and paper.no_retuning is None
    assert paper.manual_test.each == 2 and paper.manual_test.instructions
    assert len(paper.to_table()) == 6 * len(actions)


def test_progress_is_reported_and_can_stop():
    told = []
    stiction.compensation.compare_compensators(PAPER, STICKY, methods=["knocker", "two-move"], progress=told.append)
    assert told == sorted(told) and told[-1] == 6 * 2 + 2
    told = []
    stiction.what_if(PAPER, STICKY, methods=["knocker"], progress=told.append)
    assert told == sorted(told) and told[-1] > 4 * 2 + 6

    def stop(_):
        raise RuntimeError("enough")

    for ask in (stiction.compensation.compare_compensators, stiction.what_if):
        with pytest.raises(RuntimeError, match="enough"):
            ask(PAPER, STICKY, progress=stop)


def test_a_valve_without_friction_needs_nothing():
    found = stiction.what_if(PAPER, {"valve.S": 0, "valve.J": 0}, methods=[])
    assert found.manual_test is None and found.retuning is None and found.no_retuning
    assert "does not stick" in found.recommendation[0]


def test_figures_are_drawn(paper):
    done = stiction.compensation.compensate(PAPER, STICKY, method="knocker")
    assert done.plot()[1].get_xlabel() == "time (s)"
    found = stiction.compensation.compare_compensators(PAPER, STICKY, methods=["knocker"])
    for drawn in (found.plot(), paper.plot(), paper.plot(plt.subplots(2)[1])):
        assert "%/s" in drawn[1].get_xlabel() and drawn[0].get_legend() is not None
    for number in plt.get_fignums():
        plt.figure(number).canvas.draw()


def test_results_travel(paper):
    done = stiction.compensation.compensate(PAPER, STICKY, method="knocker", at_s=10, settle_s=0, window_s=10)
    found = stiction.compensation.compare_compensators(PAPER, STICKY, methods=[])
    for result in (done, found, paper):
        assert pickle.loads(pickle.dumps(result)).to_dict().keys() == result.to_dict().keys()
        assert type(result).__name__ in repr(result)
    assert [row["action"] for row in found.to_dict()["rows"]] == ["as it is"]


def knock(scenario=PAPER, **keywords):
    return stiction.compensation.compensate(scenario, method="knocker", **keywords)


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda: stiction.compensation.compensate(PAPER, method="x"), ValueError, 'no compensator named "x"; known are'),
        (lambda: stiction.compensation.compensate(PAPER, method=3), TypeError, "method must be a string"),
        (lambda: knock(parameters=[1]), TypeError, "parameters must be a mapping"),
        (
            lambda: knock(parameters={"x": 1}),
            ValueError,
            'no parameter of this compensator named "x"; known are amplitude, width, period',
        ),
        (
            lambda: knock(parameters={"width": 1.5}),
            ValueError,
            "width is 1.5, but must be a whole number",
        ),
        (lambda: knock(parameters={"width": "a"}), TypeError, "width must be a number"),
        (lambda: knock(S=-1), ValueError, "S is -1"),
        (lambda: knock(at_s=math.inf), ValueError, "a run of inf s"),
        (lambda: knock(window_s=0), ValueError, "window"),
        (lambda: knock("paper/open-loop-stiction"), ValueError, "must be a closed loop"),
        (lambda: stiction.compensation.compare_compensators(PAPER, methods="knocker"), TypeError, "methods must be a sequence"),
        (lambda: stiction.compensation.compare_compensators(PAPER, methods=[3]), TypeError, "a name in methods must be a string"),
        (lambda: stiction.compensation.compare_compensators(PAPER, methods=["x"]), ValueError, "no compensator named"),
        (lambda: stiction.compensation.compare_compensators(PAPER, at_s=-1), ValueError, "time before the compensator is on is -1"),
        (lambda: stiction.what_if(PAPER, ms=1), ValueError, "ms is 1, but must be a finite number above 1"),
        (lambda: stiction.what_if(PAPER, repaired_S="a"), TypeError, "repaired_S must be a number"),
        (lambda: stiction.what_if(PAPER, positioner_gain=-1), ValueError, "gain of the positioner is -1"),
        (lambda: stiction.what_if(PAPER, methods=["x"]), ValueError, "no compensator named"),
        (lambda: stiction.what_if("paper/open-loop-stiction"), ValueError, "must be a closed loop"),
        (lambda: stiction.compensation.compare_compensators(PAPER, progress=3), TypeError, "progress must be callable"),
        (lambda: stiction.what_if(PAPER, progress=3), TypeError, "progress must be callable"),
    ],
)
def test_bad_arguments_are_refused_by_name(call, error, words):
    with pytest.raises(error, match=words):
        call()
