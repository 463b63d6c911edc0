"""The physical valve against an independent simulation, and what else it does."""

import json
import pickle

import matplotlib

matplotlib.use("Agg")

import numpy as np
import pytest
import stiction
from reference import FIXTURES, table

PHYSICAL = json.loads((FIXTURES / "stem" / "physical.json").read_text())
CASES = {
    "CTS_coulomb_overdamped": ("x_cts_coulomb", "P_cts", "smooth"),
    "CTS_coulomb_underdamped_Fv61.29": ("x_cts_Fv61.29", "P_cts", "staircase"),
    "CTS_coulomb_underdamped_Fv3.5": ("x_cts_Fv3.5", "P_cts", "staircase"),
    "CTS_stribeck_vs2.54mm_s": ("x_cts_stribeck", "P_cts", "staircase"),
    "USP_coulomb": ("x_usp_coulomb", "P_usp", "smooth"),
}


def _stem(p):
    return stiction.Stem(
        "cts",
        friction="classical",
        parameters={
            "mass_kg": p["M"],
            "spring_n_per_m": p["k"],
            "area_m2": p["Sa"],
            "preload_n": p["Finit"],
            "stroke_m": p["xmax"],
            "pressure_min_pa": 0,
            "pressure_max_pa": 1e5,
            "end_stops": False,
            "static_n": p["Fs"],
            "coulomb_n": p["Fc"],
            "viscous_n_s_per_m": p["Fv"],
            "stribeck_m_per_s": p["vs"],
        },
    )


def _triangle(traces, pressure):
    """Two periods of 200 s between the pressures of the trace at 0 and 100 s."""
    low, high = traces[pressure][0], traces[pressure][traces["t"] == 100][0]
    return [low, high, low, high, low], [0, 100, 200, 300, 400]


@pytest.mark.parametrize("key", CASES)
def test_it_moves_as_the_reference(key):
    expected, traces = PHYSICAL[key], table("stem/physical_traces.csv")
    trace, pressure, sliding = CASES[key]
    stem = _stem(expected["params"])
    found = stem.follow_pressure(*_triangle(traces, pressure), at_s=traces["t"], position=0)
    slips = [event for event in found.events if event.kind == "slip"]
    stops = [event for event in found.events if event.kind == "stop"]
    assert found.slips == len(slips) == expected["n_slips"] and found.stops == len(stops)
    for events, times, places in (
        (slips, expected["slip_times"], expected["slip_from_m"]),
        (stops, expected["stop_times"], expected["stop_at_m"]),
    ):
        assert [e.time_s for e, _ in zip(events, times)] == pytest.approx(times, rel=1e-6)
        assert [e.position_m for e, _ in zip(events, places)] == pytest.approx(places, abs=1e-9)
    # In the middle of a slip the reference shows its own error of the slip's time.
    allowed = 1e-9 + np.abs(found.velocity_m_per_s) * 1e-10 * found.time_s
    assert (np.abs(found.position_m - traces[trace]) <= allowed).all()

    equivalent = stem.equivalent()
    for value, name in (
        (equivalent.damping_ratio, "zeta"),
        (equivalent.overshoot, "K_theory"),
        (equivalent.fs_m, "fs_m"),
        (equivalent.fd_m, "fd_m"),
        (equivalent.S_m, "S_m"),
        (equivalent.J_m, "J_m"),
        (equivalent.bands.S, "S_pct"),
        (equivalent.bands.J, "J_pct"),
    ):
        assert value == pytest.approx(expected[name], rel=1e-13), name
    assert equivalent.sliding == sliding
    if "e_theory_m" in expected:
        assert stem.trailing_m(expected["ramp_rate_m_s"]) == pytest.approx(expected["e_theory_m"], rel=1e-9)


def test_lugre_moves_as_the_reference():
    traces = table("stem/physical_traces.csv")
    stem = stiction.Stem("usp-lugre", parameters={"end_stops": False})
    found = stem.follow_pressure(*_triangle(traces, "P_usp"), at_s=traces["t"], position=0, relaxed=True)
    assert np.abs(found.position_m - traces["x_usp_lugre"]).max() < 1e-6 * stem.parameters["stroke_m"]


def test_an_op_is_a_pressure():
    stem = stiction.Stem("cts")
    op, times = np.array([0.0, 60, 20, 100]), np.array([0.0, 50, 90, 200])
    by_op = stem.follow(op, time_s=times)
    by_pressure = stem.follow_pressure(op * 689.48, times)
    assert np.abs(by_op.vp - by_pressure.vp).max() < 1e-9
    assert by_op.op.tolist() == op.tolist() and by_pressure.op is None
    assert np.allclose(by_op.pressure_pa, op * 689.48)
    assert stem.follow([0, 0, 100, 100], time_s=[0, 5, 5, 60]).vp[-1] > 50


def test_a_valve_in_samples_is_a_held_op():
    stem = stiction.Stem("cts-stribeck")
    op = 50 + 40 * np.sin(np.arange(300) / 20)
    valve = stiction.stem.StemValve(stem, 0.5, position=50, op=op[0])
    followed = valve.follow(op)
    response = stem.follow(op, sample_time=0.5, held=True, position=50)
    # The valve answers with where it is at the end of a sample.
    assert np.abs(followed[:-1] - response.vp[1:]).max() < 1e-9
    valve.restart()
    assert valve.position == pytest.approx(50) and valve.follow(op).tolist() == followed.tolist()


def test_sets_and_laws():
    sets = {each.name: each for each in stiction.stem.stem_sets()}
    laws = {law.name: law for law in stiction.stem.friction_laws()}
    assert len(sets) == 8 and len(laws) == 6
    for name, each in sets.items():
        stem = stiction.Stem(name)
        assert stem.parameters == each.parameters and stem.friction == each.friction
        assert set(laws[each.friction].parameters) <= set(each.parameters)
        assert pickle.loads(pickle.dumps(stem)) == stem
        assert stem.follow([0, 100, 0], sample_time=50).vp.max() > 20
    changed = stiction.Stem("usp", friction="lugre", parameters={"coulomb_n": 650}, tolerance=1e-6)
    assert (changed.set, changed.friction, changed.tolerance) == ("usp", "lugre", 1e-6)
    assert changed.parameters["coulomb_n"] == 650 and pickle.loads(pickle.dumps(changed)) == changed
    assert changed != stiction.Stem("usp")
    dahl = stiction.Stem("usp", friction="dahl", parameters={"stiffness_n_per_m": 3e7})
    assert "reversal" in {event.kind for event in dahl.follow([50, 60, 40], sample_time=30).events}


def test_its_response_is_a_result():
    response = stiction.Stem("cts-stribeck").follow([0, 100], sample_time=100)
    again = pickle.loads(pickle.dumps(response))
    assert repr(again) == repr(response) and again.events[0].to_dict() == response.events[0].to_dict()
    columns = ["time_s", "op", "pressure_pa", "vp", "position_m", "velocity_m_per_s", "friction_n"]
    assert response.to_table().column_names == columns
    time_s, op, *_ = response
    assert time_s is response.time_s and op is response.op
    above, below = response.plot()
    assert above.get_legend() and "(N)" in below.get_ylabel() and "(s)" in below.get_xlabel()


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda: stiction.Stem("x"), ValueError, 'no stem parameter set named "x"; known are'),
        (lambda: stiction.Stem(3), TypeError, "set must be a name"),
        (lambda: stiction.Stem(friction="x"), ValueError, 'no friction law named "x"; known are'),
        (lambda: stiction.Stem("cts", friction="lugre"), ValueError, "needs stiffness_n_per_m, damping_n_s_per_m"),
        (lambda: stiction.Stem(parameters=3), TypeError, "parameters must be a mapping"),
        (lambda: stiction.Stem(parameters={"mass": 1}), ValueError, 'there is no stem parameter named "mass"; known are'),
        (lambda: stiction.Stem(parameters={"mass_kg": "1"}), TypeError, "mass_kg must be a number"),
        (lambda: stiction.Stem(parameters={"mass_kg": -1}), ValueError, "mass is -1, but must be"),
        (lambda: stiction.Stem(tolerance=1), ValueError, "solver tolerance is 1, but must be between"),
        (lambda: stiction.Stem().follow([1, 2]), ValueError, "give either sample_time or time_s"),
        (lambda: stiction.Stem().follow([1, 2], sample_time=1, time_s=[0, 1]), ValueError, "give either"),
        (lambda: stiction.Stem().follow([1, 2], sample_time=0), ValueError, "sample_time is 0.0 s, but must be"),
        (lambda: stiction.Stem().follow([1, 2], sample_time="1"), TypeError, "sample_time must be a number"),
        (lambda: stiction.Stem().follow([1, 2], time_s=[0, 1], held=True), ValueError, "held needs sample_time"),
        (lambda: stiction.Stem().follow([1, 2], time_s=[0]), ValueError, "time_s has 1 samples, but op has 2"),
        (lambda: stiction.Stem().follow([1, 2], time_s=[1, 0]), ValueError, "in order of time"),
        (lambda: stiction.Stem().follow([1, np.nan], sample_time=1), ValueError, "sample 1 of op is NaN"),
        (lambda: stiction.Stem().follow_pressure([1, np.inf], [0, 1]), ValueError, "sample 1 of pressure_pa is inf"),
        (lambda: stiction.Stem().follow_pressure([1, 2], [0, 1], at_s=[3]), ValueError, "sample times must ascend"),
        (lambda: stiction.Stem().follow([1, 2], sample_time=1, position=200), ValueError, "start position is"),
        (lambda: stiction.Stem().trailing_m("1"), TypeError, "rate_m_per_s must be a number"),
        (lambda: stiction.stem.StemValve("cts", 1), TypeError, "stem must be a Stem, but its type is str"),
        (lambda: stiction.stem.StemValve(stiction.Stem(), 0), ValueError, "sample time is 0, but must be"),
        (lambda: stiction.stem.StemValve(stiction.Stem(), 1, position=200), ValueError, "start position is"),
        (lambda: stiction.stem.StemValve(stiction.Stem(), 1).step(np.nan), ValueError, "op is NaN"),
    ],
)
def test_bad_arguments_are_refused_by_name(call, error, words):
    with pytest.raises(error, match=words):
        call()
