"""The valve models, against the reference and against each other."""

import copy
import pickle

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest
import stiction
from reference import table

OP = [50.0, 52.0, 54.0, 55.0, 53.0]
VP = [50.0, 50.0, 52.5, 53.5, 53.5]


@pytest.mark.parametrize(
    "op",
    [
        OP,
        tuple(OP),
        np.array(OP),
        np.array(OP, dtype=np.float32),
        np.array(OP, dtype=np.int32),
        np.repeat(OP, 2)[::2],
        pd.Series(OP),
        pl.Series(OP),
        pa.array(OP),
        pa.chunked_array([OP[:2], OP[2:]]),
    ],
    ids=lambda op: f"{type(op).__module__}.{type(op).__name__}",
)
def test_it_takes_whatever_holds_numbers(op):
    assert stiction.valve(op, S=5, J=2).tolist() == VP


def test_sample_by_sample_and_all_at_once_are_the_same():
    rng = np.random.default_rng(1)
    op = 50 + np.cumsum(rng.normal(size=2000))
    for model in stiction.valves.valve_models():
        valve = stiction.valves.Valve(S=5, J=2, model=model.name, position=op[0])
        single = [valve.step(u) for u in op]
        assert stiction.valve(op, S=5, J=2, model=model.name).tolist() == single
        valve.restart()
        assert valve.follow(op).tolist() == single


@pytest.mark.parametrize("model", ["kano", "choudhury", "twophase", "xch", "he", "stenman", "backlash"])
def test_models_reproduce_the_reference(model):
    rows = table("open_loop_models.csv.gz")
    for S, J in ((5, 0), (5, 2), (5, 5), (5, 7), (2, 1), (10, 3)):
        for name in np.unique(rows["input"]):
            here = rows["input"] == name
            found = stiction.valve(rows["u"][here], S=S, J=J, model=model, position=0)
            assert np.array_equal(found, rows[f"{model}_S{S}_J{J}"][here])


def test_overshoot_and_rest_tolerance_are_the_scenarios():
    op = [50 + 0.5 * (k % 40) for k in range(400)]
    for model, settings in (("he-wang", {"K": 1.5}), ("two-phase", {"rest_tolerance": 6.0})):
        here = stiction.valve(op, S=5, J=2, model=model, sample_time=0.1, **settings)
        tables = {"valve": {"model": model, "S": 5, "J": 2, **settings}, "sample_time": 0.1, "duration": 40}
        tables["input"] = {"signal": "steps", "steps": [[0.1 * k - 0.01, u] for k, u in enumerate(op)]}
        run = stiction.closed_loop.simulate_open_loop(tables)
        assert run.op.tolist() == op and run.vp.tolist() == here.tolist()
        assert here.tolist() != stiction.valve(op, S=5, J=2, model=model).tolist()


def test_a_refused_series_leaves_the_valve_where_it_is():
    valve = stiction.valves.Valve(S=5, J=2, position=50)
    with pytest.raises(ValueError, match="sample 1 of op is NaN"):
        valve.follow([60, float("nan")])
    assert valve.position == 50


def test_tables_go_to_whoever_speaks_arrow():
    table = stiction.valves.valve_table()
    assert pl.DataFrame(table)["name"].to_list() == table["name"] == pa.table(table)["name"].to_pylist()
    assert len(table) == len(stiction.valves.valve_models()) and set(table.to_dict()) == set(table.column_names)
    with pytest.raises(KeyError, match="no column"):
        table["nothing"]


def test_bands_are_values():
    bands = stiction.valves.Bands(S=5, J=3)
    assert (bands.fs, bands.fd) == (4, 1)
    assert bands == stiction.valves.Bands.from_fs_fd(fs=4, fd=1) == pickle.loads(pickle.dumps(bands))


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda: stiction.valve(OP, S=-1, J=2), ValueError, "S is -1, but must be a finite number of at least 0"),
        (lambda: stiction.valve(OP, S=5, J="2"), TypeError, "J must be a number"),
        (lambda: stiction.valve(OP, S=5, J=2, model="x"), ValueError, 'no valve model named "x"; known are'),
        (lambda: stiction.valve(OP, S=5, J=2, model=3), TypeError, "model must be the name of a model"),
        (lambda: stiction.valve(OP, S=5, J=2, limits=5), TypeError, "limits must be a pair of numbers"),
        (lambda: stiction.valve(OP, S=5, J=2, limits=(9, 1)), ValueError, "limit of the valve is 9"),
        (lambda: stiction.valve(OP, S=5, J=2, direction=0), ValueError, "direction is 0, but must be 1 or -1"),
        (lambda: stiction.valve(OP, S=5, J=2, lag_s=1), ValueError, "lag_s needs sample_time"),
        (lambda: stiction.valve(OP, 5, 2, rest_tolerance=1), ValueError, "rest_tolerance needs sample_time"),
        (lambda: stiction.valve(OP, 5, 2, model="he", rest_tolerance=1), ValueError, "of model two-phase only"),
        (lambda: stiction.valve(OP, 5, 2, K=1.5), ValueError, "K is the overshoot of model he-wang only"),
        (lambda: stiction.valve(OP, 5, 2, model="he-wang", K=3), ValueError, "K is 3, but must be between 1"),
        (lambda: stiction.valve(OP, 5, 2, model="he-wang", K="a"), TypeError, "K must be a number"),
        (lambda: stiction.valve([OP], S=5, J=2), ValueError, r"op has the shape \(1, 5\)"),
        (lambda: stiction.valve(["a"], S=5, J=2), TypeError, "op must hold real numbers"),
        (lambda: stiction.valve([1j], S=5, J=2), TypeError, "op must hold real numbers"),
        (lambda: stiction.valve(pa.array(["a"]), S=5, J=2), TypeError, "op must hold numbers"),
        (lambda: stiction.valve([[1], [1, 2]], S=5, J=2), TypeError, "op must be a one-dimensional array"),
        (lambda: stiction.valve([np.inf], S=5, J=2), ValueError, "sample 0 of op is inf"),
        (lambda: stiction.valves.Valve(S=5, J=2, position=np.nan), ValueError, "position is NaN"),
        (lambda: stiction.valves.Valve(S=5, J=2).step("a"), TypeError, "op must be a number"),
        (lambda: stiction.valves.Bands.from_fs_fd(1, 2), ValueError, "fd is 2, but must be between -1 and fs = 1"),
    ],
)
def test_bad_arguments_are_refused_by_name(call, error, words):
    with pytest.raises(error, match=words):
        call()


@pytest.mark.parametrize(
    "settings",
    [
        *({"model": model.name} for model in stiction.valves.valve_models()),
        {"model": "he-wang", "K": 1.5},
        {"rest_tolerance": 0.4, "sample_time": 0.5},
        {"lag_s": 2.0, "sample_time": 0.5, "limits": (30.0, 70.0), "model": "choudhury"},
        {"direction": -1, "moving": True, "op": 51.0},
    ],
    ids=str,
)
def test_a_valve_goes_on_where_it_was_pickled(settings):
    op = 50 + np.cumsum(np.random.default_rng(2).normal(size=600))
    valve = stiction.valves.Valve(S=5, J=2, position=50, **settings)
    for k in range(len(op) // 100):
        valve.follow(op[100 * k : 100 * k + 50])
        twins = [pickle.loads(pickle.dumps(valve)), copy.deepcopy(valve), copy.copy(valve)]
        rest = op[100 * k + 50 : 100 * (k + 1)]
        went = valve.follow(rest).tolist()
        for twin in twins:
            assert twin.follow(rest).tolist() == went and repr(twin) == repr(valve)
    valve.restart()
    for twin in twins:
        twin.restart()
        assert twin.follow(op).tolist() == stiction.valves.Valve(S=5, J=2, position=50, **settings).follow(op).tolist()


def test_a_valve_keeps_attributes_of_its_own_when_it_is_copied():
    valve = stiction.valves.Valve(S=5, J=2)
    valve.tag = "FV101"
    assert copy.deepcopy(valve).tag == pickle.loads(pickle.dumps(valve)).tag == "FV101"
