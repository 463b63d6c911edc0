"""Measures the effect of the communication step, for the figure of docs/fmu.md.

    pip install ".[test]" && python python/benchmarks/communication_step.py docs/figures/fmu-communication-step.svg

FMUs of a valve and of two stems follow a sine of OP in FMPy, co-simulated at ever longer steps. At the ends of the steps, each FMU
is compared with its model in the library under a continuous OP (the valve: sampled every millisecond).
"""

import sys
import tempfile
from pathlib import Path

import fmpy
import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams.update({"svg.hashsalt": "stiction", "svg.fonttype": "none"})

import matplotlib.pyplot as plt
import numpy as np
import stiction

AMPLITUDE, PERIOD_S, STOP_S, FINE_S = 20.0, 60.0, 120.0, 0.001
STEPS_S = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0]


def sine(time_s):
    return 50 + AMPLITUDE * np.sin(2 * np.pi * time_s / PERIOD_S)


def main(target):
    fine = np.arange(0, STOP_S + FINE_S / 2, FINE_S)
    op = sine(fine)
    exact = {
        "data-driven valve, S = 5 %, J = 3 %": stiction.valve(op, S=5, J=3, position=50),
        "stem, Karnopp friction (set usp-graphite-karnopp)": stiction.Stem("usp-graphite-karnopp").follow(op, time_s=fine, position=50).vp,
        "stem, LuGre friction (set usp-lugre)": stiction.Stem("usp-lugre").follow(op, time_s=fine, position=50).vp,
    }
    sources = [{"model": "two-phase", "S": 5, "J": 3}, {"stem": "usp-graphite-karnopp"}, {"stem": "usp-lugre"}]
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), sharex=True, layout="constrained")
    with tempfile.TemporaryDirectory() as folder:
        for (name, reference), source, marker in zip(exact.items(), sources, "os^"):
            path = stiction.fmu.export(Path(folder) / "model.fmu", **source, start={"VP_start": 50, "OP": 50})
            means, most = [], []
            for step in STEPS_S:
                times = np.arange(0, STOP_S + step / 2, step)
                signal = np.rec.fromarrays([times, sine(times)], names=["time", "OP"])
                found = fmpy.simulate_fmu(
                    str(path),
                    fmi_type="CoSimulation",
                    stop_time=STOP_S,
                    step_size=step,
                    output_interval=step,
                    input=signal,
                    output=["VP"],
                )["VP"]
                error = np.abs(found - reference[np.round(times / FINE_S).astype(int)][: len(found)])
                means.append(error.mean())
                most.append(error.max())
            left.loglog(STEPS_S, means, marker=marker, label=name)
            right.loglog(STEPS_S, most, marker=marker, label=name)
            print(name, *(f"{step:g} s: {mean:.2g} / {max_:.2g} %" for step, mean, max_ in zip(STEPS_S, means, most)), sep="\n  ")
    rate = AMPLITUDE * 2 * np.pi / PERIOD_S
    for ax, words in ((left, "mean error of VP, % of span"), (right, "largest error of VP, % of span")):
        ax.loglog(STEPS_S, rate * np.array(STEPS_S), ":", color="0.4", label=f"fastest OP, {rate:.1f} %/s, times the step")
        ax.set(xlabel="communication step, s", ylabel=words)
        ax.grid(True, alpha=0.25)
    right.legend(fontsize="small", loc="lower right")
    figure.suptitle(f"FMUs under a sine of OP, 50 ± {AMPLITUDE:g} %, period {PERIOD_S:g} s", fontsize="medium")
    figure.savefig(target, metadata={"Date": None} if str(target).endswith(".svg") else None)


if __name__ == "__main__":
    main(sys.argv[1])
