"""The sample recordings of the package are those of the repository."""

from pathlib import Path

import pytest
import stiction
from stiction import datasets

SAMPLES = Path(__file__).parents[2] / "samples"


def test_there_are_those_of_the_repository():
    files = sorted(SAMPLES.glob("*IC*.csv"))
    assert sorted(datasets.names()) == [file.stem for file in files]
    for file in files:
        assert datasets.path(file.stem).read_bytes() == file.read_bytes()


def test_they_load_and_their_truth_is_known():
    for name in datasets.names():
        loop, truth = datasets.load(name), datasets.truth(name)
        assert loop.name == truth.name == name and loop.pv is not None
        assert truth.sticks == (truth.S > 0) and truth.model in {model.name for model in stiction.valves.valve_models()}
        assert truth.scenario in stiction.closed_loop.scenarios()
    assert datasets.truth("FIC105-cascade").J == 2.5


def test_others_are_refused_by_name():
    for function in (datasets.load, datasets.path, datasets.truth):
        with pytest.raises(ValueError, match="name is 'FIC999', but must be one of 'FIC101-sticky'"):
            function("FIC999")
        with pytest.raises(TypeError, match="name must be a string"):
            function(101)
