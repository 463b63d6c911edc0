"""Simulated loops with known truth."""

import pickle

import matplotlib

matplotlib.use("Agg")

import numpy as np
import polars as pl
import pytest
import stiction
from tqdm import tqdm


def test_a_loop_depends_on_seed_and_number_alone():
    whole = stiction.population(12, seed=3)
    parts = [*stiction.population(5, seed=3), *stiction.population(7, seed=3, first=5)]
    for one, other in zip(whole, parts):
        assert one.name == other.name and one.truth.to_dict() == other.truth.to_dict()
        assert np.array_equal(one.op, other.op) and np.array_equal(one.vp, other.vp)
        assert np.array_equal(one.pv, other.pv)
    assert not np.array_equal(whole[0].op, stiction.population(1, seed=4)[0].op)


def test_the_truth_is_a_table():
    loops = stiction.population(20, seed=7)
    frame = pl.DataFrame(loops.truth())
    assert frame.height == len(loops) == 20
    for row, loop in zip(frame.iter_rows(named=True), loops):
        truth = loop.truth.to_dict()
        assert row == {"name": loop.name, **{k: v for k, v in truth.items() if k != "facts"}, **truth["facts"]}
        assert truth["facts"]["sample_time_s"] == loop.sample_time
    assert frame["sticks"].any() and not frame["sticks"].all()


def test_kinds():
    kinds = stiction.populations.population_kinds()
    assert len(kinds) == 19 and sum(kinds.values()) == pytest.approx(1)
    for kind in kinds:
        (loop,) = stiction.population(1, seed=5, kind=kind)
        assert loop.truth.kind == kind
        assert loop.truth.sticks == (kind in {"sticky valve", "sticky valve below", "stuck valve"})
        assert (loop.truth.model is None) != loop.truth.sticks
    assert isinstance(stiction.populations.POPULATION_VERSION, int)


def test_it_is_a_sequence():
    loops = stiction.population(4, seed=1)
    assert loops[-1].name == loops[3].name == "loop 3"
    assert [loop.name for loop in loops[::2]] == ["loop 0", "loop 2"]
    with pytest.raises(IndexError):
        loops[4]
    assert repr(loops) == "<Population of 4 loops>"


def test_a_member_is_a_result():
    loop = stiction.population(1, seed=7)[0]
    again = pickle.loads(pickle.dumps(loop))
    assert repr(again) == repr(loop) and again.to_dict()["truth"]["kind"] == loop.truth.kind
    columns = [name for name in ("time_s", "sp", "pv", "op", "vp") if getattr(loop, name) is not None]
    assert loop.to_table().column_names == columns
    above, below = loop.plot()
    assert loop.truth.kind in above.get_title(loc="left") and below.get_legend() and "(s)" in below.get_xlabel()


def test_progress_moves_a_bar():
    with tqdm(total=200, disable=False) as bar:
        stiction.population(200, progress=lambda done: bar.update(done - bar.n))
        assert bar.n == 200


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda: stiction.population(0), ValueError, "n is 0, but must be at least 1"),
        (lambda: stiction.population(10**18), ValueError, "n is 1000000000000000000, but must be at most 1000000; make"),
        (lambda: stiction.population("3"), TypeError, "n must be a whole number"),
        (lambda: stiction.population(1.5), TypeError, "n must be a whole number"),
        (lambda: stiction.population(1, seed=-1), ValueError, "seed is -1, but must be at least 0"),
        (lambda: stiction.population(1, seed=1 << 64), ValueError, "seed is 18446744073709551616, but must be below"),
        (lambda: stiction.population(1, first=-1), ValueError, "first is -1"),
        (lambda: stiction.population(1, kind="x"), ValueError, 'no kind of loop named "x"; known are'),
        (lambda: stiction.population(1, kind=3), TypeError, "kind must be a string"),
        (lambda: stiction.population(1, progress=3), TypeError, "progress must be callable"),
    ],
)
def test_bad_arguments_are_refused_by_name(call, error, words):
    with pytest.raises(error, match=words):
        call()
