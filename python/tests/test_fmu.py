"""Exported FMUs in importers that are not ours: FMPy, with its CVode, and fmutool."""

import json
import platform
import shutil
import sys
import zipfile
from datetime import datetime, timezone

import fmpy
import numpy as np
import pytest
import stiction
from fmpy.simulation import Input
from fmpy.sundials import CVodeSolver
from fmpy.validation import validate_fmu
from fmu_manipulation_toolbox.cli.fmutool import fmutool
from reference import FIXTURES, table

MODELS = stiction.fmu.models()
RNG = np.random.default_rng(7)


# The icon and its description, by version of FMI.
ICONS = {2: ["model.png"], 3: ["terminalsAndIcons/" + name for name in ("icon.png", "icon.svg", "terminalsAndIcons.xml")]}


def exported(folder, kind, name, fmi=2, **start):
    """The path of an FMU of a model of the list."""
    path = folder / f"{kind}-{name}-{fmi}.fmu"
    if kind == "loop":
        loop = {"valve.model": name, "valve.S": 5, "valve.J": 2, "duration": 100}
        return stiction.fmu.export(path, loop=stiction.scenario("paper/closed-loop", loop), start=start, fmi=fmi)
    return stiction.fmu.export(path, **{"model" if kind == "valve" else "stem": name}, start=start, fmi=fmi)


class Stepped:
    """An FMU in FMPy, in co-simulation, step by step."""

    def __init__(self, path):
        self.folder = fmpy.extract(str(path))
        self.description = fmpy.read_model_description(self.folder)
        self.fmu = fmpy.instantiate_fmu(self.folder, self.description, fmi_type="CoSimulation")
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        two = self.description.fmiVersion == "2.0"
        self.put = self.fmu.setReal if two else self.fmu.setFloat64
        self.get = self.fmu.getReal if two else self.fmu.getFloat64
        self.fresh = True

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)

    def start(self, **values):
        """Begins at time 0, again if it has begun before."""
        if not self.fresh:
            self.fmu.reset()
        self.fresh = False
        if values:
            self.put([self.reference[name] for name in values], list(values.values()))
        if self.description.fmiVersion == "2.0":
            self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.time = 0.0

    def step(self, op, step=1.0, output="VP"):
        """The output after a step with this OP."""
        self.put([self.reference["OP"]], [op])
        self.fmu.doStep(currentCommunicationPoint=self.time, communicationStepSize=step)
        self.time += step
        return self.get([self.reference[output]])[0]


def op_signal(times, op):
    """An input of FMPy."""
    return np.array(list(zip(times, op)), dtype=[("time", float), ("OP", float)])


@pytest.mark.parametrize("model", MODELS, ids=lambda m: f"{m.kind}-{m.name}")
def test_importers_accept_it_and_both_versions_agree(model, tmp_path, monkeypatch):
    times = np.arange(0, 50, 0.5)
    # Wide enough for the 59 % of the set cts.
    op = 50 + 45 * np.sin(2 * np.pi * times / 40)
    results = []
    for fmi in (2, 3):
        path = exported(tmp_path, model.kind, model.name, fmi)
        assert validate_fmu(str(path)) == []
        monkeypatch.setattr(sys, "argv", ["fmutool", "-input", str(path), "-check"])
        try:
            fmutool()
        except SystemExit as end:
            assert not end.code, f"fmutool refuses {path.name}"
        results.append(
            fmpy.simulate_fmu(
                str(path),
                fmi_type="CoSimulation",
                stop_time=50,
                step_size=0.5,
                output_interval=0.5,
                input=None if model.kind == "loop" else op_signal(times, op),
            )
        )
    two, three = results
    assert two.dtype.names == three.dtype.names and len(two) == 101
    for name in two.dtype.names:
        assert np.array_equal(two[name], three[name]), name
        assert np.isfinite(two[name].astype(float)).all(), name
    assert np.ptp(two["VP"]) > 0


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("model", ["kano", "choudhury", "twophase", "xch", "he", "stenman", "backlash"])
def test_valves_reproduce_the_reference(model, fmi, tmp_path):
    rows = table("open_loop_models.csv.gz")
    with Stepped(exported(tmp_path, "valve", model, fmi, VP_start=0)) as valve:
        for S, J in ((5, 0), (5, 2), (5, 5), (5, 7), (2, 1), (10, 3)):
            for name in np.unique(rows["input"]):
                here = rows["input"] == name
                valve.start(S=S, J=J)
                found = [valve.step(op) for op in rows["u"][here]]
                assert np.array_equal(found, rows[f"{model}_S{S}_J{J}"][here]), (S, J, name)


def test_a_simulation_by_fmpy_is_the_library(tmp_path):
    times = 0.5 * np.arange(400)
    op = 50 + np.cumsum(RNG.normal(size=len(times)))
    for model in stiction.valves.valve_models():
        for start, given in (({}, {}), ({"stem_lag": 2.0, "limited": True}, {"lag_s": 2.0, "limits": (0, 100)})):
            expected = stiction.valve(op, S=5, J=2, model=model.name, position=50, sample_time=0.5, **given)
            for fmi in (2, 3):
                path = exported(tmp_path, "valve", model.name, fmi, VP_start=50, **start)
                found = fmpy.simulate_fmu(
                    str(path), stop_time=200, step_size=0.5, output_interval=0.5, input=op_signal(times, op), output=["VP"]
                )
                # A row is what follows the OP of the row before it.
                assert np.array_equal(found["VP"][1:], expected), model.name


def test_a_loop_is_the_simulated_scenario(tmp_path):
    run = stiction.simulate("paper/closed-loop", {"duration": 100})
    dt = run.sample_time
    for fmi in (2, 3):
        path = stiction.fmu.export(tmp_path / "loop.fmu", loop="paper/closed-loop", fmi=fmi)
        found = fmpy.simulate_fmu(str(path), stop_time=99, step_size=dt, output_interval=dt, output=["OP", "VP", "PV"])
        for name, signal in (("OP", run.op), ("VP", run.vp), ("PV", run.pv)):
            count = len(found) - 1
            assert np.array_equal(found[name][1:], signal[:count]), name


def test_a_stem_is_the_library(tmp_path):
    op = 50 + 8 * np.cumsum(RNG.normal(size=100)).clip(-4, 4)
    for name in [model.name for model in MODELS if model.kind == "stem"]:
        known = {s.name for s in stiction.stem.stem_sets()}
        expected = stiction.Stem(name).follow(np.append(op, op[-1]), sample_time=0.5, held=True, position=50) if name in known else None
        answers = []
        for fmi in (2, 3):
            with Stepped(exported(tmp_path, "stem", name, fmi, supply=1e6)) as stem:
                # The bristles begin in balance with the first OP.
                stem.start(OP=op[0])
                answers.append([stem.step(u, 0.5, "position") for u in op])
        assert answers[0] == answers[1], name
        if expected is not None:
            # The library's first sample is the beginning.
            reference = expected.position_m[1:]
            worst = np.max(np.abs(np.subtract(answers[0], reference) / reference))
            assert worst <= 1e-9, (name, worst)


def paper_loop(valve, sample_time):
    """The paper's PI controller and process around a valve for 600 s: OP, VP and PV, the recursion of the reference."""
    decay, delay = np.exp(-sample_time / 5.93), round(1.07 / sample_time)
    past, integral, pv = [0.0] * (delay + 1), 0.0, 0.0
    signals = []
    for _ in range(round(600 / sample_time)):
        error = 5 - pv
        integral += 1.1 / 2.5 * sample_time * error
        op = 1.1 * error + integral
        vp = valve(op)
        signals.append((op, vp, pv))
        past.append(vp)
        pv = decay * pv + (1 - decay) * 1.5 * past[-1 - delay]
    return np.array(signals).T


def test_a_loop_assembled_in_fmpy_reproduces_the_limit_cycles(tmp_path):
    rows = table("seed_loop_sampled.csv")
    worst_last, worst_cycle, count = 0.0, 0.0, 0
    for model in np.unique(rows["model"]):
        with Stepped(exported(tmp_path, "valve", str(model), VP_start=0)) as valve:
            for k in np.flatnonzero(rows["model"] == model):
                sample_time, count = rows["Ts"][k], count + 1
                valve.start(S=rows["S"][k], J=rows["J"][k])
                op, vp, pv = paper_loop(lambda op: valve.step(op, sample_time), sample_time)
                last = (op[-1] - rows["u_last"][k], vp[-1] - rows["x_last"][k], pv[-1] - rows["y_last"][k])
                worst_last = max(worst_last, *np.abs(last))
                for signal, column in ((op, "op_halfpp"), (vp, "mv_halfpp"), (pv, "pv_halfpp")):
                    half_pp = np.ptp(signal[len(signal) // 2 :]) / 2
                    worst_cycle = max(worst_cycle, abs(half_pp - rows[column][k]))
    print(f"{count} loops: last samples within {worst_last:.1e}, amplitudes within {worst_cycle:.1e}")
    assert worst_last <= 1e-9 and worst_cycle <= 1e-9


# The pressure of each case, and the longest step, s: so short that no two events hide in it.
CASES = {
    "CTS_coulomb_overdamped": ("P_cts", 0.02),
    "CTS_coulomb_underdamped_Fv61.29": ("P_cts", 0.02),
    "CTS_coulomb_underdamped_Fv3.5": ("P_cts", 0.02),
    "CTS_stribeck_vs2.54mm_s": ("P_cts", 0.004),
    "USP_coulomb": ("P_usp", 0.02),
}


def integrated(path, signals, stop_time, step):
    """A stem in model exchange, integrated by FMPy's CVode: times at which it slips and at which it stops.

    As `fmpy.simulate_fmu` does it, but the input follows the solver's time. There it is set when a step of the solver
    has ended only, so that a ramp becomes a staircase, and events come late by up to the output interval.
    """
    folder = fmpy.extract(str(path))
    description = fmpy.read_model_description(folder)
    fmu = fmpy.instantiate_fmu(folder, description, fmi_type="ModelExchange")
    reference = {v.name: v.valueReference for v in description.modelVariables}
    given = Input(fmu, description, signals)
    two = description.fmiVersion == "2.0"
    if two:
        fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    given.apply(0.0)
    fmu.exitInitializationMode()
    update, get_count = (fmu.newDiscreteStates, fmu.getInteger) if two else (fmu.updateDiscreteStates, fmu.getInt32)

    def pass_events():
        again = True
        while again:
            again, terminate, *_ = update()
            assert not terminate
        fmu.enterContinuousTimeMode()

    def set_time(time):
        fmu.setTime(time)
        given.apply(time, discrete=False)

    pass_events()
    solver = CVodeSolver(
        nx=description.numberOfContinuousStates,
        nz=description.numberOfEventIndicators,
        get_x=fmu.getContinuousStates,
        set_x=fmu.setContinuousStates,
        get_dx=fmu.getDerivatives if two else fmu.getContinuousStateDerivatives,
        get_z=fmu.getEventIndicators,
        get_nominals=fmu.getNominalsOfContinuousStates,
        set_time=set_time,
        input=given,
        startTime=0.0,
        relativeTolerance=1e-11,
        maxNumSteps=100_000,
    )
    slips, stops, time = [], [], 0.0
    stuck, count = True, 0
    while time < stop_time:
        # A corner of the input ends a step.
        end = min(stop_time, given.nextEvent(time), time + step)
        state_event, _, time = solver.step(time, end)
        set_time(time)
        step_event, _ = fmu.completedIntegratorStep()
        if state_event or step_event or time == given.nextEvent(np.nextafter(time, 0)):
            fmu.enterEventMode()
            given.apply(time)
            pass_events()
            solver.reset(time)
        before, stuck = stuck, bool(fmu.getBoolean([reference["stuck"]])[0])
        counted, count = count, get_count([reference["slips"]])[0]
        slips += [time] * (count - counted)
        stops += [time] * (stuck and not before)
    fmu.terminate()
    fmu.freeInstance()
    shutil.rmtree(folder, ignore_errors=True)
    return np.array(slips), np.array(stops)


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("case", CASES)
def test_cvode_finds_the_events_of_the_reference(case, fmi, tmp_path):
    reference = json.loads((FIXTURES / "stem" / "physical.json").read_text())[case]
    traces = table("stem/physical_traces.csv")
    column, step = CASES[case]
    pressure, p = traces[column], reference["params"]
    path = exported(
        tmp_path,
        "stem",
        "classical",
        fmi,
        supply=1e6,
        VP_start=0,
        mass_kg=p["M"],
        spring_n_per_m=p["k"],
        area_m2=p["Sa"],
        preload_n=p["Finit"],
        stroke_m=p["xmax"],
        pressure_min_pa=pressure[0],
        pressure_max_pa=pressure[traces["t"] == 100][0],
        end_stops=False,
        static_n=p["Fs"],
        coulomb_n=p["Fc"],
        viscous_n_s_per_m=p["Fv"],
        stribeck_m_per_s=p["vs"],
    )
    slips, stops = integrated(path, op_signal([0, 100, 200, 300, 400], [0, 100, 0, 100, 0]), 400.0, step)
    assert len(slips) == reference["n_slips"]
    off = [
        np.max(np.abs(found[: len(expected)] - expected))
        for found, expected in ((slips, reference["slip_times"]), (stops, reference["stop_times"]))
    ]
    print(f"{case}: {len(slips)} slips within {off[0]:.1e} s, {len(stops)} stops within {off[1]:.1e} s")
    assert max(off) < 1e-6


STEMS = [model.name for model in MODELS if model.kind == "stem" and model.name != "armstrong"]


@pytest.mark.parametrize("vp_start", [0, 50])
@pytest.mark.parametrize("name", STEMS)
def test_stems_run_under_cvode_and_slip_as_in_co_simulation(name, vp_start, tmp_path):
    """By `fmpy.simulate_fmu` as it is, whose staircase of the input has a stiff stem start anew at every step."""
    start = {} if name == "lugre-textbook" else {"supply": 2e5}
    times = np.arange(0, 30.001, 0.05)
    signals = op_signal(times, 50 + 15 * np.sin(2 * np.pi * times / 30))
    fine = np.arange(0, 30.0005, 0.002)
    reference = None
    for fmi in (2, 3):
        path = str(exported(tmp_path, "stem", name, fmi, VP_start=vp_start, **start))
        output = ["VP", "stuck", "slips"]
        if reference is None:
            reference = fmpy.simulate_fmu(
                path,
                fmi_type="CoSimulation",
                stop_time=30,
                step_size=0.002,
                output_interval=0.002,
                input=op_signal(fine, 50 + 15 * np.sin(2 * np.pi * fine / 30)),
                output=output,
            )
        for interval in (0.05, 0.1, 0.5):
            found = fmpy.simulate_fmu(
                path, fmi_type="ModelExchange", stop_time=30, output_interval=interval, input=signals, output=output
            )
            there = np.round(found["time"] / 0.002).astype(int).clip(0, len(reference) - 1)
            error = np.abs(found["VP"] - reference["VP"][there])
            print(
                f"{name} from {vp_start} %, FMI {fmi}, every {interval} s: VP within {error.max():.3f} %, on average "
                f"{error.mean():.4f} %, slips {found['slips'][-1]} and {reference['slips'][-1]}"
            )
            assert found["time"][-1] == pytest.approx(30)
            # A jump comes late by up to the interval, because the input does; the rest fits.
            assert np.mean(error) < (0.1 if interval == 0.05 else 1)
            assert found["slips"][-1] == reference["slips"][-1]
    # These move: their friction is less than what OP 35 to 65 % exerts.
    assert reference["slips"][-1] > 0 or vp_start == 50 or name == "lugre-textbook"


def test_what_belongs_to_an_fmu_is_inside(tmp_path):
    moment = datetime(2026, 3, 1, tzinfo=timezone.utc)
    for fmi in (2, 3):
        path = stiction.fmu.export(tmp_path / "a.fmu", stem="usp-lugre", fmi=fmi, date=moment)
        again = stiction.fmu.export(tmp_path / "b.fmu", stem="usp-lugre", fmi=fmi, date=moment)
        assert path.read_bytes() == again.read_bytes()
        description = fmpy.read_model_description(str(path))
        assert description.generationDateAndTime == "2026-03-01T00:00:00Z"
        assert description.coSimulation.modelIdentifier == "stiction_stem_lugre"
        assert description.modelExchange.modelIdentifier == "stiction_stem_lugre"
        units = {v.name: v.unit for v in fmpy.read_model_description(str(stiction.fmu.export(tmp_path / "c.fmu", loop="paper/closed-loop"))).modelVariables}
        assert [units[name] for name in ("PV", "SP", "Kc", "gain")] == ["%", "%", "1", "1"]
        names = zipfile.ZipFile(path).namelist()
        assert {*ICONS[fmi], "documentation/index.html", "documentation/licenses/license.txt"} <= set(names)


def test_a_date_can_come_from_outside(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    path = stiction.fmu.export(tmp_path / "a.fmu", "he")
    assert fmpy.read_model_description(str(path)).generationDateAndTime == "1970-01-02T00:00:00Z"
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "today")
    with pytest.raises(ValueError, match="SOURCE_DATE_EPOCH is 'today'"):
        stiction.fmu.export(tmp_path / "b.fmu", "he")


@pytest.mark.parametrize("model", MODELS, ids=lambda m: f"{m.kind}-{m.name}")
def test_defaults_can_be_simulated(model, tmp_path, capsys):
    """Without a setting: a valve or stem follows an OP from where it rests, and no input is missed."""
    times = np.arange(0, 20, 0.1)
    signals = None if model.kind == "loop" else op_signal(times, 50 + 45 * np.sin(2 * np.pi * times / 20))
    found = fmpy.simulate_fmu(
        str(exported(tmp_path, model.kind, model.name)), fmi_type="CoSimulation", stop_time=19.9, step_size=0.1, input=signals
    )
    # Its friction is more than its pressure can exert: bristles yield, no more.
    assert np.ptp(found["VP"]) > (0 if model.name == "lugre-textbook" else 1)
    assert "missing input" not in capsys.readouterr().out
    if model.kind != "loop":
        assert abs(found["VP"][1] - 50) < 1


@pytest.mark.parametrize(
    "given, error, words",
    [
        ({"model": "sticky"}, ValueError, "sticky"),
        ({"model": 5}, TypeError, "model must be a string"),
        ({"model": "two-phase", "S": -1}, ValueError, "S is -1"),
        ({"model": "two-phase", "S": "a"}, TypeError, "S must be a number"),
        ({"model": "two-phase", "J": float("nan")}, ValueError, "J is NaN"),
        ({"stem": "butter"}, ValueError, "no friction law or parameter set named"),
        ({"stem": "lugre", "S": 5}, TypeError, "S and J belong to a valve model"),
        ({"stem": "lugre", "start": {"mass": 1}}, ValueError, "mass is not a parameter"),
        ({"stem": "lugre", "start": {"mass_kg": -1}}, ValueError, "mass is -1"),
        ({"model": "he", "start": {"VP": 1}}, ValueError, "VP is computed"),
        ({"model": "he", "start": [1]}, TypeError, "start must be a mapping"),
        ({"model": "he", "stem": "lugre"}, TypeError, "only one of model"),
        ({"loop": "paper/open-loop-high"}, ValueError, "closed loop"),
        ({"loop": 5}, TypeError, "source must be a scenario"),
        ({"model": "he", "fmi": 1}, ValueError, "fmi is 1, but must be 2 or 3"),
        ({"model": "he", "date": "2026"}, TypeError, "date must be a datetime"),
        ({"model": "he", "date": datetime(1960, 1, 1)}, ValueError, "after 1970"),
        ({"model": "he", "fmi": "2"}, TypeError, "fmi must be a whole number"),
        ({"model": "he", "libraries": {"windows": "x.dll"}}, ValueError, "libraries names the platform 'windows'"),
        ({"model": "he", "libraries": {"6502-basic": __file__}}, ValueError, "6502"),
    ],
)
def test_bad_arguments_are_refused_by_name(given, error, words, tmp_path):
    with pytest.raises(error, match=words):
        stiction.fmu.export(tmp_path / "x.fmu", **given)
    assert not (tmp_path / "x.fmu").exists()


def test_more_libraries_are_packed(tmp_path):
    library = tmp_path / "stiction.dll"
    library.write_bytes(b"of another platform")
    own = f"{platform.machine()}-linux"
    for target, more in (("aarch64-windows", True), (own, False)):
        path = stiction.fmu.export(tmp_path / "x.fmu", "he", S=4, J=1, libraries={target: library}, fmi=3)
        fmu = zipfile.ZipFile(path)
        found = [name for name in fmu.namelist() if name.startswith("binaries/")]
        # That of a platform which is built in is replaced.
        if sys.platform == "linux":
            assert len(found) == 1 + more
        [name] = [name for name in found if name.startswith(f"binaries/{target}/")]
        assert fmu.read(name) == b"of another platform"


def test_the_table_of_variables_is_the_description(tmp_path):
    path = stiction.fmu.export(tmp_path / "stem.fmu", stem="usp-lugre", start={"VP_start": 20})
    described = {v.name: v for v in fmpy.read_model_description(str(path)).modelVariables}
    variables = stiction.fmu.variables(stem="usp-lugre", start={"VP_start": 20})
    assert [v.name for v in variables] == list(described)
    for variable in variables:
        assert described[variable.name].description == variable.description
        if isinstance(variable.start, float):
            assert float(described[variable.name].start) == variable.start
    [seed] = [v for v in stiction.fmu.variables(loop="paper/closed-loop") if v.name == "seed"]
    assert isinstance(seed.start, int)
