"""Loops with parts written in Python: the same numbers as with the library's, and exceptions that arrive."""

import math

import pytest
import stiction

LOOP = {
    "controller": {"kc": 1.1, "ti": 2.5},
    "valve": {"model": "he", "S": 5, "J": 3},
    "process": {"gain": 1.5, "tau": 5.93, "delay": 1.0},
    "operating_point": {"op": 40, "pv": 50},
    "set_point": {"signal": "steps", "steps": [[0, 50], [10, 55]]},
    "noise": {"sd": 0.05},
    "load": [{"value": 1.5}],
    "sample_time": 0.1,
    "duration": 100,
}


class He(stiction.own.OwnValve):
    def restart(self, position):
        self.position = position

    def step(self, op):
        e = op - self.position
        if abs(e) > 4.0:
            self.position = op - math.copysign(1.0, e)
        return self.position


class Pi(stiction.own.OwnController):
    def restart(self, sample_time, op, sp, pv):
        assert (op, sp, pv) == (40, 50, 50)
        self.ki_ts, self.integral = 1.1 / 2.5 * sample_time, op

    def step(self, sp, pv):
        e = sp - pv
        self.integral += self.ki_ts * e
        return 1.1 * e + self.integral


class FirstOrder(stiction.own.OwnProcess):
    def restart(self, sample_time):
        self.a, self.pv, self.delayed = math.exp(-sample_time / 5.93), 0.0, [0.0] * 10

    def output(self):
        return self.pv

    def advance(self, input):
        self.delayed.append(input)
        self.pv = self.a * self.pv + 1.5 * (1 - self.a) * self.delayed.pop(0)


@pytest.mark.parametrize(
    "parts",
    [
        {"valve": He()},
        {"controller": Pi()},
        {"process": FirstOrder()},
        {"valve": He(), "controller": Pi(), "process": FirstOrder()},
        {"valve": stiction.valves.Valve(S=5, J=3, model="he")},
        {"valve": stiction.valves.Valve(S=5, J=3, model="he"), "controller": Pi()},
    ],
    ids=lambda parts: "-".join(parts),
)
def test_parts_that_repeat_the_librarys_give_the_same_bits(parts):
    expected = stiction.simulate(LOOP)
    # A second run begins again.
    for _ in range(2):
        run = stiction.simulate(LOOP, **parts)
        for signal in ("sp", "pv", "op", "vp"):
            assert getattr(run, signal).tolist() == getattr(expected, signal).tolist()
        assert run.period_s == expected.period_s and run.growth == expected.growth


def test_a_physical_stem_goes_into_a_loop_alone_and_with_others():
    stem = stiction.Stem("cts-stribeck")
    alone = stiction.simulate(LOOP, valve=stem)
    beside = stiction.simulate(LOOP, valve=stem, controller=Pi())
    assert alone.vp.tolist() == beside.vp.tolist()
    valve = stiction.stem.StemValve(stem, sample_time=0.1, position=40)
    assert [valve.step(op) for op in alone.op] == alone.vp.tolist()


@pytest.mark.parametrize(
    "method, base, part",
    [("restart", He, "valve"), ("step", He, "valve"), ("step", Pi, "controller"), ("output", FirstOrder, "process"),
     ("advance", FirstOrder, "process")],
)
def test_exceptions_arrive_and_end_the_simulation(method, base, part):
    calls = []

    def fails(self, *arguments):
        calls.append(arguments)
        raise LookupError("mine")

    broken = type("Broken", (base,), {method: fails})
    with pytest.raises(LookupError, match="mine"):
        stiction.simulate(LOOP, **{part: broken()})
    assert len(calls) == 1


def test_what_is_no_number_or_no_part_is_refused():
    class Mute(He):
        def step(self, op):
            return None

    with pytest.raises(TypeError, match="the result of `step` must be a number, but its type is NoneType"):
        stiction.simulate(LOOP, valve=Mute())
    with pytest.raises(TypeError, match="valve must be OwnValve or Valve or Stem, but its type is Pi"):
        stiction.simulate(LOOP, valve=Pi())
    with pytest.raises(TypeError, match="give an object, not its class"):
        stiction.simulate(LOOP, controller=Pi)
    with pytest.raises(ValueError, match="must be a closed loop"):
        stiction.simulate("paper/flow-cascade", valve=He())
    with pytest.raises(TypeError, match="abstract"):
        stiction.own.OwnValve()
