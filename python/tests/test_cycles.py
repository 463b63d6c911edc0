"""Limit cycles: against the reference, simulation and each other."""

import csv
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
PAPER = "paper/closed-loop"
STICKY = {"valve.S": 5, "valve.J": 3}


def table(name):
    with open(FIXTURES / name, newline="") as file:
        rows = list(csv.DictReader(file))
    return [{k: v if k == "single_slip_valid" else float(v) for k, v in row.items()} for row in rows]


def looped(row, model):
    return {
        "controller": {"kc": row["Kc"], "ti": row["tau"]},
        "valve": {"model": model, "S": row["S"], "J": row["J"]},
        "process": {"gain": row["Kp"], "tau": row["tau"], "delay": row["theta"]},
        "sample_time": 0.1,
        "duration": 10,
    }


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    plt.close("all")


@pytest.mark.parametrize("row", table("exact_pole_cancel.csv"), ids=lambda row: f"J={row['J']:g}, q={row['q']:.2g}")
def test_the_closed_form_is_met(row):
    cycle = stiction.limit_cycle(looped(row, "two-phase")).cycle
    assert cycle.period_s == pytest.approx(row["T_exact"], rel=1e-9)
    assert cycle.half_pp_op == pytest.approx(row["op_exact"], rel=1e-9)
    assert cycle.half_pp_vp == pytest.approx(row["mv_exact"], rel=1e-9)
    assert cycle.half_pp_pv == pytest.approx(row["pv_event"], rel=2e-9)
    # Half a period leaves -(1 - q) of a deviation of the stuck position.
    assert np.abs(cycle.multipliers - (1 - row["q"]) ** 2).min() < 1e-9
    he = stiction.limit_cycle(looped(row, "he")).cycle
    assert (he.period_s, he.half_pp_op) == pytest.approx((row["T_he_exact"], row["op_he_exact"]), rel=1e-9)


def test_the_cycles_of_the_papers_loop_are_met():
    for row in table("seed_loop_limit_cycles_continuous.csv"):
        settings = {"valve.S": row["S"], "valve.J": row["J"]}
        cycle = stiction.limit_cycle(PAPER, settings).cycle
        expected = row["period_s"], row["op_halfpp"], row["mv_halfpp"], row["pv_halfpp"]
        found = cycle.period_s, cycle.half_pp_op, cycle.half_pp_vp, cycle.half_pp_pv
        assert found == pytest.approx(expected, rel=1e-5)
        balanced = stiction.limit_cycle(PAPER, settings, method="describing-function")
        if math.isnan(row["df_X"]):
            assert balanced.state == "no cycle"
        else:
            assert balanced.cycle.half_pp_op == pytest.approx(row["df_X"], rel=1e-6)
            assert balanced.cycle.period_s == pytest.approx(row["df_period_s"], rel=1e-6)


def test_the_family_of_hes_valve_is_met():
    for row in table("he_model_tsypkin_seed_loop.csv"):
        if row["single_slip_valid"] != "True":
            continue
        he = {"valve.model": "he", "valve.S": row["S"], "valve.J": row["J"]}
        cycle = stiction.cycles.limit_cycle_member(PAPER, he, offset=row["delta"]).cycle
        assert cycle.period_s == pytest.approx(row["period_s"], rel=1e-9)
        # The reference samples the OP.
        assert cycle.half_pp_op == pytest.approx(row["op_halfpp"], rel=1e-4)


def test_the_describing_function_is_met():
    rows = table("describing_function.csv")
    for S, J in sorted({(row["S"], row["J"]) for row in rows}):
        of = [row for row in rows if (row["S"], row["J"]) == (S, J)]
        found = stiction.cycles.describing_function([row["X"] for row in of], S, J)
        expected = np.array([complex(row["ReN"], row["ImN"]) for row in of])
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8)


def test_a_valve_that_stays_stuck_has_no_gain():
    least = stiction.cycles.least_amplitude(5, 3)
    assert stiction.cycles.describing_function([0.5 * least, least], 5, 3).tolist() == [0, 0]
    assert stiction.cycles.describing_function([1.001 * least], 5, 3)[0] != 0
    stairs = [stiction.cycles.describing_function([5.5], 5, 1, model="he", slips=n)[0] for n in (5, 6)]
    assert stairs[0] != stairs[1]
    assert stiction.cycles.describing_function([5.5], 5, 1, model="he")[0] == stairs[0]
    assert stiction.cycles.describing_function(np.array([7], dtype=np.int8), 5, 3, model="ideal").tolist() == [1]


def test_a_simulation_with_short_samples_shows_the_exact_cycle():
    run = stiction.simulate(PAPER, {**STICKY, "sample_time": 0.01})
    cycle = stiction.limit_cycle(PAPER, STICKY).cycle
    assert cycle.period_s == pytest.approx(run.period_s, rel=5e-3)
    assert cycle.half_pp_pv == pytest.approx(run.half_pp_pv, rel=5e-3)


def test_without_a_cycle_there_is_a_reason():
    for method in ("exact", "describing-function"):
        found = stiction.limit_cycle(PAPER, {"valve.J": 0}, method=method)
        assert (found.state, found.cycle, found.cycles) == ("no cycle", None, []) and found.reasons
    with pytest.raises(ValueError, match="no final limit cycle"):
        stiction.cycles.limit_cycle_trajectory(PAPER, {"valve.J": 0})


def test_what_has_no_part_is_reported():
    found = stiction.limit_cycle(PAPER, {"controller.limits": [0, 100], "valve.lag": 0.1})
    assert sorted(found.no_part) == ["controller.limits", "valve.lag"]


def test_all_cycles_contain_the_one_in_which_the_loop_ends():
    one, all_of_them = stiction.limit_cycle(PAPER, STICKY), stiction.cycles.limit_cycles(PAPER, STICKY)
    assert all_of_them.cycles[0].period_s == pytest.approx(one.cycle.period_s, rel=1e-9)


def test_a_trajectory_has_the_amplitudes_of_its_cycle():
    orbit = stiction.cycles.limit_cycle_trajectory(PAPER, STICKY, samples=2000)
    for signal in ("op", "vp", "pv"):
        half = np.ptp(getattr(orbit, signal)) / 2
        # The PV turns in a corner, between two times.
        assert half == pytest.approx(getattr(orbit.cycle, f"half_pp_{signal}"), rel=1e-3)
    assert orbit.time_s[0] == 0 and orbit.time_s[-1] <= orbit.cycle.period_s


def test_the_frequency_response_is_that_of_controller_and_process():
    omega = np.geomspace(0.01, 10, 50)
    response = stiction.cycles.frequency_response(PAPER, STICKY, omega=omega)
    s = 1j * omega
    process = 1.5 / (5.93 * s + 1) * np.exp(-1.07 * s)
    np.testing.assert_allclose(response.process_gain, process, rtol=1e-12)
    np.testing.assert_allclose(response.loop_gain, 1.1 * (1 + 1 / (2.5 * s)) * process, rtol=1e-12)
    assert response.gain_margin == pytest.approx(4.543, abs=1e-3)
    cycle = stiction.limit_cycle(PAPER, STICKY, method="describing-function").cycle
    (crossing,) = response.crossings
    balance = crossing * stiction.cycles.describing_function([cycle.half_pp_op], 5, 3)[0]
    assert balance == pytest.approx(-1, abs=1e-9)


def test_a_map_is_its_points():
    kc, ti = np.linspace(0.8, 1.4, 3), np.array([2.0, 2.5, 9.0])
    found = stiction.cycles.limit_cycle_map(PAPER, STICKY, x=("Kc", kc), y=("Ti", ti))
    assert found.period_s.shape == found.state.shape == (3, 3)
    for row, column in np.ndindex(3, 3):
        settings = {**STICKY, "controller.kc": kc[column], "controller.ti": ti[row]}
        single = stiction.limit_cycle(PAPER, settings)
        assert found.state[row, column] == single.state
        expected = single.cycle.period_s if single.cycle else np.nan
        np.testing.assert_allclose(found.period_s[row, column], expected, rtol=1e-9)
        expected = single.cycle.half_pp_pv if single.cycle else np.nan
        np.testing.assert_allclose(found.half_pp_pv[row, column], expected, rtol=1e-9)


def test_a_map_tells_where_cycling_ends():
    j = np.linspace(0, 4, 5)
    told = []
    found = stiction.cycles.limit_cycle_map(
        PAPER, x=("J", j), y=("Kc", [1.0, 1.1]), method="describing-function", progress=told.append
    )
    assert (found.state == "cycle").any() and (found.state == "no cycle").any()
    assert np.isnan(found.half_pp_pv[found.state != "cycle"]).all()
    assert found.boundary.shape[1:] == (2, 2) and len(found.boundary)
    assert sorted(told) == told and all(0 < done <= 10 for done in told)
    table = found.to_table()
    frame = pl.DataFrame(table)
    assert len(table) == 10 and frame["J"].to_list() == [*j, *j]
    assert frame["state"].to_list() == found.state.ravel().tolist()
    assert frame["period_s"].null_count() == (found.state != "cycle").sum()


def test_an_exception_in_progress_ends_a_map():
    def stop(done):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stiction.cycles.limit_cycle_map(
            PAPER, x=("Kc", np.linspace(0.5, 2, 20)), y=("Ti", np.linspace(2, 9, 400)), progress=stop
        )


def test_amplitudes_answer_to_s_and_j_together_with_one():
    found = {each.parameter: each for each in stiction.cycles.sensitivities(PAPER, STICKY)}
    assert found["S"].half_pp_pv + found["J"].half_pp_pv == pytest.approx(1, abs=1e-6)
    assert found["S"].period + found["J"].period == pytest.approx(0, abs=1e-6)
    assert found["Kc"].value == 1.1


def test_tuning_rules():
    simc = stiction.cycles.simc(PAPER)
    assert (simc.kc, simc.ti) == pytest.approx((5.93 / (1.5 * 2.14), 5.93))
    lambda_tuned = stiction.cycles.lambda_tuning(PAPER, time_constant_s=3)
    assert (lambda_tuned.kc, lambda_tuned.ti) == pytest.approx((5.93 / (1.5 * 4.07), 5.93))


def test_retuning_keeps_within_the_bound():
    told = []
    found = stiction.cycles.retune(PAPER, STICKY, ms=1.6, points=4, within=3, progress=told.append)
    assert found.best.ms <= 1.6 and found.ms_bound == 1.6
    assert found.present.tuning.kc == 1.1 and found.pv_ratio <= 1
    settings = {**STICKY, "controller.kc": found.best.tuning.kc, "controller.ti": found.best.tuning.ti}
    again = stiction.limit_cycle(PAPER, settings).cycle
    assert (again is None) == (found.best.cycle is None)
    assert stiction.cycles.frequency_response(PAPER, settings).peak_sensitivity == pytest.approx(found.best.ms)
    assert found.best.load_iae == pytest.approx(stiction.cycles.load_step_iae(PAPER, settings), rel=1e-6)


def test_figures_are_drawn():
    orbit = stiction.cycles.limit_cycle_trajectory(PAPER, STICKY, samples=50)
    top, bottom = orbit.plot()
    assert bottom.get_xlabel() == "time (s)" and top.get_legend() is not None
    assert orbit.plot_phase()[1].get_xlabel() == "OP (%)"
    assert orbit.plot(plt.subplots(2)[1])
    ax = stiction.cycles.frequency_response(PAPER, STICKY).plot()
    assert ax.get_ylabel() == "imaginary part"
    drawn = stiction.cycles.limit_cycle_map(PAPER, x=("J", [0, 1, 2]), y=("Kc", [1.0, 1.1]))
    for show in ("pv", "op", "vp", "period"):
        assert drawn.plot(show=show).get_xlabel() == "J (%)"
    for number in plt.get_fignums():
        plt.figure(number).canvas.draw()


def test_results_travel():
    found = stiction.limit_cycle(PAPER, STICKY)
    again = pickle.loads(pickle.dumps(found))
    assert again.cycles[0].period_s == found.cycles[0].period_s
    assert found.to_dict()["cycles"][0]["slips"] == 2 and "period_s=18.0437" in repr(found)
    method, state, *_ = found
    assert (method, state) == ("exact", "cycle")
    for result in (
        stiction.cycles.limit_cycle_trajectory(PAPER, samples=5),
        stiction.cycles.frequency_response(PAPER),
        stiction.cycles.limit_cycle_map(PAPER, x=("J", [1]), y=("Kc", [1])),
        stiction.cycles.sensitivities(PAPER)[0],
        stiction.cycles.retune(PAPER, method="describing-function", points=3),
    ):
        assert pickle.loads(pickle.dumps(result)).to_dict().keys() == result.to_dict().keys()
        assert type(result).__name__ in repr(result)


AXES = {"x": ("J", [1]), "y": ("Kc", [1])}


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda: stiction.limit_cycle(PAPER, method="x"), ValueError, "method is 'x', but must be one of 'exact'"),
        (lambda: stiction.limit_cycle(PAPER, method=1), TypeError, "method must be a string"),
        (lambda: stiction.limit_cycle("paper/open-loop-stiction"), ValueError, "must be a closed loop"),
        (lambda: stiction.limit_cycle(PAPER, {"valve.model": "chen"}), ValueError, "Chen's model"),
        (lambda: stiction.cycles.limit_cycle_member(PAPER, offset=0.1), ValueError, "not a family"),
        (lambda: stiction.cycles.limit_cycle_member(PAPER, offset="a"), TypeError, "offset must be a number"),
        (lambda: stiction.cycles.limit_cycle_member(PAPER, offset=np.inf), ValueError, "offset is inf"),
        (lambda: stiction.cycles.limit_cycle_trajectory(PAPER, samples=0), ValueError, "samples is 0, but must be at least 1"),
        (lambda: stiction.cycles.limit_cycle_trajectory(PAPER, samples=2.5), TypeError, "samples must be a whole number"),
        (lambda: stiction.cycles.describing_function([0.0], 5, 3), ValueError, "amplitude of the OP is 0"),
        (lambda: stiction.cycles.describing_function([np.nan], 5, 3), ValueError, "amplitude of the OP is NaN"),
        (lambda: stiction.cycles.describing_function(["a"], 5, 3), TypeError, "amplitude must hold real numbers"),
        (lambda: stiction.cycles.describing_function([9], 5, 1, model="he", slips=1), ValueError, "with 1 slips per stroke"),
        (lambda: stiction.cycles.describing_function([9], 5, 1, slips=0), ValueError, "slips is 0, but must be at least 1"),
        (lambda: stiction.cycles.describing_function([1], -5, 3), ValueError, "S is -5"),
        (lambda: stiction.cycles.describing_function([1], 5, 3, model="x"), ValueError, "no valve model named"),
        (lambda: stiction.cycles.least_amplitude(5, "3"), TypeError, "J must be a number"),
        (lambda: stiction.cycles.frequency_response(PAPER, omega=[[1]]), ValueError, "omega has the shape"),
        (lambda: stiction.cycles.limit_cycle_map(PAPER, x="Kc", y=("Ti", [1])), TypeError, "values in x"),
        (lambda: stiction.cycles.limit_cycle_map(PAPER, x=3, y=("Ti", [1])), TypeError, "x must be a pair"),
        (lambda: stiction.cycles.limit_cycle_map(PAPER, x=("a", [1]), y=("Ti", [1])), ValueError, "no parameter of a loop"),
        (lambda: stiction.cycles.limit_cycle_map(PAPER, x=("J", [1]), y=("J/S", [1])), ValueError, "vary the same quantity"),
        (lambda: stiction.cycles.limit_cycle_map(PAPER, **AXES).plot(show="x"), ValueError, "show is 'x'"),
        (lambda: stiction.cycles.limit_cycle_map(PAPER, **AXES).plot([1, 2]), ValueError, "ax holds 2 axes, but 1"),
        (lambda: stiction.cycles.simc(PAPER, tc=-1), ValueError, "tc is -1"),
        (lambda: stiction.cycles.lambda_tuning(PAPER, time_constant_s=None), TypeError, "time_constant_s must be a number"),
        (lambda: stiction.cycles.retune(PAPER, ms=0.5, points=2), ValueError, "bound on Ms is 0.5"),
        (lambda: stiction.cycles.retune(PAPER, within=1), ValueError, "factor is 1"),
        (lambda: stiction.cycles.retune(PAPER, points=1), ValueError, "points is 1, but must be at least 2"),
        (lambda: stiction.cycles.load_step_iae(PAPER, {"controller.kc": 9}), ValueError, "stable loop"),
    ],
)
def test_bad_arguments_are_refused_by_name(call, error, words):
    with pytest.raises(error, match=words):
        call()
