"""The bridge to python-control: its simulations and its harmonic balance against ours."""

import numpy as np
import pytest
import stiction

control = pytest.importorskip("control")

import stiction.control as bridge  # noqa: E402

PAPER = "paper/closed-loop"
MODELS = ["two-phase", "he", "he-wang", "stenman", "chen", "play", "ideal"]


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("bands", [(5, 2), (5, 0), (4, 4), (0, 0), (3, 6)], ids=str)
def test_a_valve_as_a_system_is_the_valve(model, bands):
    if model == "he-wang" and bands[1] > bands[0]:
        pytest.skip("he-wang has no overshoot of the input")
    rng = np.random.default_rng(3)
    steps = rng.normal(size=800) * rng.choice([0, 0.1, 3], size=800)
    op = 50 + np.round(np.cumsum(steps), 2)
    system = bridge.valve_system(*bands, model=model, dt=0.5)
    time = 0.5 * np.arange(len(op))
    response = control.input_output_response(system, time, op, [op[0], op[0], 0])
    expected = stiction.valve(op, *bands, model=model)
    assert np.array_equal(response.outputs, expected)
    assert np.array_equal(response.states[1, 1:], op[:-1]) or model != "two-phase"


def test_a_valve_as_a_system_can_begin_in_motion():
    op = np.array([50.5, 51, 50.8, 47.0, 46.0])
    system = bridge.valve_system(5, 2, dt=1.0)
    response = control.input_output_response(system, np.arange(5.0), op, [48.5, 50, 1])
    valve = stiction.valves.Valve(5, 2, position=48.5, op=50, direction=1, moving=True)
    assert np.array_equal(response.outputs, valve.follow(op))


def test_a_loop_of_systems_is_the_loop():
    run = stiction.simulate(
        {
            "sample_time": 0.1,
            "duration": 60,
            "controller": {"kc": 1.1, "ti": 2.5},
            "valve": {"S": 5, "J": 3},
            "process": {"gain": 1.5, "tau": 5.93, "delay": 1.0},
            "set_point": {"value": 5},
        }
    )
    valve = bridge.valve_system(5, 3, dt=0.1)
    response = control.input_output_response(valve, run.time_s, run.op, [0, 0, 0])
    np.testing.assert_allclose(response.outputs, run.vp, rtol=1e-12)
    process = control.sample_system(control.tf([1.5], [5.93, 1]), 0.1)
    delayed = np.concatenate([np.zeros(10), run.vp[:-10]])
    pv = control.forced_response(process, run.time_s, delayed).outputs
    np.testing.assert_allclose(pv, run.pv, atol=1e-9)


def test_a_process_goes_into_a_scenario():
    def cycle(process):
        found = stiction.limit_cycle(
            {
                "sample_time": 0.1,
                "duration": 10,
                "controller": {"kc": 1.1, "ti": 2.5},
                "valve": {"S": 5, "J": 3},
                "process": process,
            }
        ).cycle
        return found.period_s, found.half_pp_pv

    first = {"gain": 1.5, "tau": 5.93, "delay": 1.07}
    transfer = control.tf([1.5], [5.93, 1])
    for system in (transfer, control.ss(transfer), control.tf([3], [11.86, 2])):
        assert cycle(bridge.process_of(system, dead_time=1.07)) == pytest.approx(cycle(first), rel=1e-9)
    second = {"type": "second-order", "gain": 1.5, "tau": 5, "tau2": 2, "delay": 0.5}
    product = control.tf([1.5], [5, 1]) * control.tf([1], [2, 1])
    for system in (product, control.ss(product)):
        assert cycle(bridge.process_of(system, dead_time=0.5)) == pytest.approx(cycle(second), rel=1e-7)


def test_harmonic_balance_agrees():
    S, J = 5, 3
    valve = bridge.describing_function(S, J)
    assert isinstance(valve, control.DescribingFunctionNonlinearity)
    amplitude = np.linspace(1.02, 3, 60) * stiction.cycles.least_amplitude(S, J)
    assert np.array_equal(control.describing_function(valve, amplitude), stiction.cycles.describing_function(amplitude, S, J))
    omega = np.linspace(0.05, 3, 300)
    # A process without dead time, so that python-control has the same loop.
    process = control.tf([1.5], [5.93, 1]) * control.tf([1], [1.07, 1])
    controller = control.tf([1.1 * 2.5, 1.1], [2.5, 0])
    response = control.describing_function_response(process * controller, valve, amplitude, omega)
    ours = stiction.limit_cycle(
        {
            "sample_time": 0.1,
            "duration": 10,
            "controller": {"kc": 1.1, "ti": 2.5},
            "valve": {"S": S, "J": J},
            "process": bridge.process_of(process),
        },
        method="describing-function",
    ).cycle
    ((x, w),) = response.intersections
    assert (x, 2 * np.pi / w) == pytest.approx((ours.half_pp_op, ours.period_s), rel=1e-4)


def test_harmonic_balance_agrees_with_dead_time():
    omega = np.linspace(0.05, 3, 400)
    loop = stiction.cycles.frequency_response(PAPER, omega=omega)
    given = control.frd(loop.loop_gain, omega, smooth=True)
    S, J = loop.bands.S, loop.bands.J
    amplitude = np.linspace(1.02, 3, 60) * stiction.cycles.least_amplitude(S, J)
    response = control.describing_function_response(given, bridge.describing_function(S, J), amplitude, omega)
    ours = stiction.limit_cycle(PAPER, method="describing-function").cycle
    ((x, w),) = response.intersections
    assert (x, 2 * np.pi / w) == pytest.approx((ours.half_pp_op, ours.period_s), rel=1e-3)


def test_shapes_are_kept_and_the_valve_can_be_followed():
    valve = bridge.describing_function(5, 2, "he")
    assert valve.describing_function([[4, 5], [6, 7]]).shape == (2, 2)
    assert isinstance(valve.describing_function(6.0), complex)
    assert valve(4.0) == stiction.valve([4.0], 5, 2, model="he", position=0)[0]


SISO = control.tf([1], [1, 1])
TWICE = control.append(control.ss(SISO), control.ss(SISO))


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda: bridge.process_of(3), TypeError, "system must be a TransferFunction or a StateSpace"),
        (lambda: bridge.process_of(TWICE), ValueError, "2 inputs and 2 outputs"),
        (lambda: bridge.process_of(control.tf([1], [1, 0.5], 0.1)), ValueError, "continuous in time"),
        (lambda: bridge.process_of(control.tf([1, 0, 0], [1, 1])), ValueError, "improper"),
        (lambda: bridge.process_of(SISO, dead_time=-1), ValueError, "dead_time is -1"),
        (lambda: bridge.process_of(SISO, dead_time="a"), TypeError, "dead_time must be a number"),
        (lambda: bridge.valve_system(5, 2, model="kano"), ValueError, "model is 'kano', but must be one of"),
        (lambda: bridge.valve_system(5, 2, model="choudhury"), ValueError, "model is 'choudhury'"),
        (lambda: bridge.valve_system(-5, 2), ValueError, "S is -5"),
        (lambda: bridge.valve_system(5, "a"), TypeError, "J must be a number"),
        (lambda: bridge.valve_system(5, 2, dt=0), ValueError, "dt is 0"),
        (lambda: bridge.describing_function(5, 2, "x"), ValueError, "no valve model named"),
        (lambda: bridge.describing_function(5, 2).describing_function(-1), ValueError, "amplitude of the OP is -1"),
    ],
)
def test_bad_arguments_are_refused_by_name(call, error, words):
    with pytest.raises(error, match=words):
        call()
