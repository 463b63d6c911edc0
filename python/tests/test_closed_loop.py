"""Simulated loops: identity with the reference, tables, plots, sweeps, interrupts."""

import pickle
import subprocess
import sys
import textwrap

import matplotlib

matplotlib.use("Agg")

import numpy as np
import polars as pl
import pyarrow as pa
import pytest
import stiction
from reference import table
from tqdm import tqdm

PAPER = {
    "controller": {"kc": 1.1, "ti": 2.5},
    "valve": {"model": "two-phase", "S": 5, "J": 3},
    "process": {"gain": 1.5, "tau": 5.93, "delay": 1.07, "dead_time": "nearest"},
    "set_point": {"value": 5},
    "sample_time": 0.01,
    "duration": 600,
}


def test_sampled_loops_reproduce_the_reference():
    rows = table("seed_loop_sampled.csv")
    worst_last, worst_cycle = 0.0, 0.0
    for k in range(len(rows["S"])):
        loop = stiction.scenario(
            PAPER,
            {
                "valve.model": str(rows["model"][k]),
                "valve.S": rows["S"][k],
                "valve.J": rows["J"][k],
                "sample_time": rows["Ts"][k],
            },
        )
        run = stiction.simulate(loop)
        last = [run.op[-1] - rows["u_last"][k], run.vp[-1] - rows["x_last"][k], run.pv[-1] - rows["y_last"][k]]
        worst_last = max(worst_last, *np.abs(last))
        assert (run.period_s is None) == np.isnan(rows["period_s"][k])
        found = [run.period_s or np.nan, run.half_pp_op, run.half_pp_vp, run.half_pp_pv]
        expected = [rows[name][k] for name in ("period_s", "op_halfpp", "mv_halfpp", "pv_halfpp")]
        relative = np.abs(np.subtract(found, expected)) / np.maximum(np.abs(expected), 1)
        worst_cycle = max(worst_cycle, np.nanmax(relative))
    print(f"largest difference: last samples {worst_last:.1e}, cycles {worst_cycle:.1e} relative")
    # The recursions are the same; their sums are rounded in another order.
    assert worst_last <= 1e-10 and worst_cycle <= 1e-9


def test_the_trace_reproduces_the_reference():
    rows = table("seed_loop_trace_S5_J3.csv")
    run = stiction.simulate(PAPER, {"valve.model": "kano"})
    k = np.round(rows["t"] / 0.01).astype(int)
    for signal, column in ((run.sp, "sp"), (run.op, "op"), (run.vp, "mv"), (run.pv, "pv")):
        assert np.abs(signal[k] - rows[column]).max() <= 1e-9


def test_each_kind_has_its_result():
    loop = stiction.simulate("paper/closed-loop", {"duration": 100})
    cascade = stiction.closed_loop.simulate_cascade("paper/flow-cascade")
    valve = stiction.closed_loop.simulate_open_loop("paper/open-loop-high")
    assert [type(run) for run in (loop, cascade, valve)] == [stiction.closed_loop.Run, stiction.closed_loop.CascadeRun, stiction.closed_loop.OpenLoopRun]
    assert valve.period_s is None and valve.half_pp_op == pytest.approx(15, abs=0.1)
    assert np.array_equal(valve.vp, stiction.closed_loop.simulate_open_loop("paper/open-loop-high").vp)
    for run, columns in (
        (loop, ["time_s", "sp", "pv", "op", "vp"]),
        (cascade, ["time_s", "sp", "pv", "op", "vp", "master_sp", "master_pv"]),
        (valve, ["time_s", "op", "vp"]),
    ):
        made = run.to_table()
        assert made.column_names == columns
        assert pl.DataFrame(made)["time_s"].to_list() == run.time_s.tolist()
        again = pickle.loads(pickle.dumps(run))
        assert repr(again) == repr(run) and pa.table(again.to_table()) == pa.table(made)
        assert list(run.to_dict()) == [name for name in vars(run)]
    slave, sp, pv = cascade
    assert slave is cascade.slave and len(sp) == len(pv) == len(slave.op)


def test_a_table_has_null_where_there_is_no_number():
    done = stiction.sweep(stiction.scenario(PAPER, {"valve.J": J}) for J in (0, 3))
    assert np.isnan(done.period_s[0]) and done.to_table()["period_s"][0] is None


def test_a_sweep_is_the_loops_one_by_one():
    loops = [
        stiction.scenario(PAPER, {"valve.S": S, "valve.J": J, "duration": duration, "sample_time": 0.05})
        for duration in (100, 200)
        for S in (2, 5)
        for J in (1, 2, 3)
    ]
    told = []
    done = stiction.sweep(loops, progress=told.append)
    assert told[-1] == len(loops) == len(done.period_s)
    for k, loop in enumerate(loops):
        run = stiction.simulate(loop)
        found = (done.half_pp_op[k], done.half_pp_vp[k], done.half_pp_pv[k])
        assert found == (run.half_pp_op, run.half_pp_vp, run.half_pp_pv)
        error = (run.sp - run.pv)[len(run.pv) // 2 :]
        assert done.error_abs[k] == pytest.approx(np.abs(error).mean(), rel=1e-12)
        assert (done.S[k], done.J[k]) == (loop.bands.S, loop.bands.J)
    assert len(stiction.sweep([]).S) == 0
    assert pl.DataFrame(done.to_table()).columns == list(done.to_dict())


def test_progress_moves_a_bar():
    loops = [stiction.scenario(PAPER, {"duration": 20})] * 1000
    with tqdm(total=len(loops), disable=False) as bar:
        stiction.sweep(loops, progress=lambda done: bar.update(done - bar.n))
        assert bar.n == len(loops)


def test_an_error_in_progress_ends_the_sweep():
    def fail(done):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        stiction.sweep([stiction.scenario(PAPER)] * 2000, progress=fail)


@pytest.mark.parametrize(
    "work",
    [
        'stiction.sweep([stiction.scenario("paper/closed-loop")] * 20_000)',
        "stiction.population(1_000_000)",
        'stiction.simulate("paper/closed-loop", {"sample_time": 1e-5, "duration": 400})',
        'stiction.Stem("cts-stribeck").follow(np.tile([0.0, 100.0], 2000), sample_time=100)',
        'stiction.compensation.compare_compensators("paper/closed-loop", {"sample_time": 1e-3})',
        'stiction.what_if("paper/closed-loop", {"sample_time": 1e-3})',
    ],
    ids=["sweep", "population", "simulate", "stem", "compare_compensators", "what_if"],
)
def test_an_interrupt_ends_it_within_a_second(work):
    script = f"""
        import os, signal, sys, threading, time
        import numpy as np
        import stiction

        def interrupt():
            global at
            at = time.monotonic()
            os.kill(os.getpid(), signal.SIGINT)

        threading.Timer(0.4, interrupt).start()
        try:
            {work}
        except KeyboardInterrupt:
            took = time.monotonic() - at
            sys.exit(0 if took < 1 else f"it took {{took}} s")
        sys.exit("it was not interrupted")
    """
    run = subprocess.run([sys.executable, "-c", textwrap.dedent(script)], capture_output=True, text=True, timeout=60)
    assert run.returncode == 0, run.stderr


@pytest.mark.parametrize(
    "table, expected",
    [
        ({"signal": "constant", "value": 3}, [3, 3, 3, 3]),
        ({"signal": "steps", "steps": [[0, 1], [2, 5]]}, [1, 1, 5, 5]),
        ({"signal": "line", "start": 1, "slope": 2, "from": 1}, [1, 1, 3, 5]),
        ({"signal": "square", "mean": 1, "amplitude": 1, "period": 2}, [2, 0, 2, 0]),
        ({"signal": "staircase", "step": 1, "dwell": 1, "stairs": 2}, [0, 1, 2, 1]),
    ],
    ids=lambda value: value["signal"] if isinstance(value, dict) else "",
)
def test_signals(table, expected):
    assert stiction.signal(table, sample_time=1, duration=4).tolist() == expected


def test_a_signal_is_the_input_of_a_scenario():
    noise = {"signal": "noise", "sd": 2, "seed": 7}
    run = stiction.closed_loop.simulate_open_loop(
        {"input": noise, "valve": {"model": "ideal"}, "sample_time": 0.5, "duration": 100}
    )
    assert np.array_equal(run.op, stiction.signal(noise, sample_time=0.5, duration=100))


def test_plots_have_names_units_and_legends():
    import matplotlib.pyplot as plt

    runs = (
        (stiction.simulate("paper/closed-loop"), 2),
        (stiction.closed_loop.simulate_cascade("paper/flow-cascade"), 3),
        (stiction.closed_loop.simulate_open_loop("paper/open-loop-high"), 2),
    )
    for run, count in runs:
        made = run.plot()
        assert len(made) == count and made[-1].get_xlabel() and all(ax.get_ylabel() for ax in made)
        assert made[0].get_legend()
        _, given = plt.subplots(count)
        assert run.plot(given) == list(given)
    with pytest.raises(ValueError, match="ax holds 2 axes, but 3 are needed"):
        stiction.closed_loop.simulate_cascade("paper/flow-cascade").plot(plt.subplots(2)[1])
    plt.close("all")


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda: stiction.simulate(3), TypeError, "source must be a scenario, its name, path or tables"),
        (lambda: stiction.simulate("paper/flow-cascade"), ValueError, "`simulate_cascade` simulates it"),
        (lambda: stiction.closed_loop.simulate_cascade(PAPER), ValueError, "`simulate` simulates it"),
        (lambda: stiction.closed_loop.simulate_open_loop(PAPER), ValueError, "`simulate` simulates it"),
        (lambda: stiction.simulate("nothing"), ValueError, 'no scenario file or built-in "nothing"'),
        (lambda: stiction.simulate(PAPER, 3), TypeError, "settings must be a mapping"),
        (lambda: stiction.simulate(PAPER, {"valve.S": -1}), ValueError, "S is -1"),
        (lambda: stiction.simulate(PAPER, {"valve.S": {1}}), ValueError, "S"),
        (lambda: stiction.simulate({"sample_time": 1, "duration": 9}), ValueError, "simulates nothing"),
        (lambda: stiction.sweep("paper/closed-loop"), TypeError, "scenarios must be a sequence of scenarios"),
        (lambda: stiction.sweep(PAPER), TypeError, "scenarios must be a sequence of scenarios"),
        (lambda: stiction.sweep(["paper/flow-cascade"]), ValueError, "is a cascade, but must be a closed loop"),
        (lambda: stiction.sweep([PAPER], progress=3), TypeError, "progress must be callable"),
        (lambda: stiction.signal(3, sample_time=1, duration=2), TypeError, "table must be a mapping"),
        (lambda: stiction.signal({"signal": "x"}, sample_time=1, duration=2), ValueError, 'is "x", but must be one of'),
        (lambda: stiction.signal({"value": 1}, sample_time=0, duration=2), ValueError, "sample_time: is 0 s"),
        (lambda: stiction.signal({"value": 1}, sample_time="a", duration=2), TypeError, "sample_time must be a number"),
        (lambda: stiction.signal({"value": 1}, sample_time=1, duration=0), ValueError, "duration: gives 0 samples"),
        (lambda: stiction.signal({"signal": "file"}, sample_time=1, duration=2), ValueError, "file"),
    ],
)
def test_bad_arguments_are_refused_by_name(call, error, words):
    with pytest.raises(error, match=words):
        call()
