"""Independent reference for the physical stem, written to ../fixtures/stem/.

Regenerate with `python stem_oracle.py` (NumPy and SciPy; takes a few minutes). It shares no code
with the library: the smooth laws are integrated by SciPy's Radau at a relative tolerance of 1e-11
and restarted at every change of mode; the air lag is a state of its own; the Coulomb case is the
closed solution in extended precision.

Writes
  stem_paths.csv    positions (m) of the cases below at common times
  stem_events.json  times and positions of slips and stops of the cases that stick
  coulomb_extended.json  events and two positions of the CTS valve with Fv = 3.5 N s/m
"""

import json
import sys
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

OUT = Path(__file__).resolve().parent.parent / "fixtures" / "stem"
RTOL = 1e-11
TIMES = np.round(np.arange(0, 60.01, 0.25), 10)

CTS = dict(M=1.36, k=52500.0, Sa=0.0645, Fi=0.0, Fs=1708.0, Fc=1423.0, Fv=612.9, vs=2.54e-3)
USP = dict(M=1.6, k=210490.0, Sa=0.0445, Fi=2550.0, Fs=780.0, Fc=700.0, Fv=125000.0, vs=5e-4)
GRAPHITE = dict(M=1.6, k=206916.0, Sa=0.0445, Fi=2572.1, Fs=942.1, Fc=669.9, Fv=70481.0, vs=3.221e-3)
BOOK = dict(M=1.0, k=2.0, Sa=1.0, Fi=0.0, Fs=1.5, Fc=1.0, Fv=0.4, vs=1e-3)
CTS_TRIANGLE = [(0.0, 0.0), (20.0, 80000.0), (40.0, 0.0), (60.0, 80000.0)]
USP_TRIANGLE = [(0.0, 41368.0), (20.0, 180000.0), (40.0, 41368.0), (60.0, 180000.0)]
BOOK_TRIANGLE = [(0.0, 0.0), (20.0, 4.0), (40.0, 0.0), (60.0, 4.0)]


def pressure(points):
    t, p = np.array(points).T
    return lambda s: np.interp(s, t, p)


def curve(q, v):
    return q["Fc"] + (q["Fs"] - q["Fc"]) * np.exp(-((v / q["vs"]) ** 2))


def run(rhs, y, t0, t1, events, atol):
    """Until t1 or the first event; returns solution."""
    for e in events:
        e.terminal, e.direction = True, -1
    return solve_ivp(rhs, (t0, t1), y, method="Radau", rtol=RTOL, atol=atol, events=events or None,
                     dense_output=True)


def fill(path, sol, t0, t1):
    mask = (TIMES >= t0) & (TIMES <= t1)
    if mask.any():
        path[mask] = sol.sol(TIMES[mask])[0]


def bristles(q, points, law, n, atol_z):
    """Smooth motion: law(v, z, d, modes) -> (F, z'); law.margin, law.reset for GMS."""
    p = pressure(points)
    path = np.full(len(TIMES), np.nan)
    y = np.zeros(2 + n)
    atol = [1e-15, 1e-15] + [atol_z] * n
    for (t0, _), (t1, _) in zip(points, points[1:]):
        t = t0
        d = None
        while t < t1:
            if d is None:
                F, _ = law(y[1], y[2:], 1.0)
                surplus = q["Sa"] * p(t) - q["k"] * y[0] - q["Fi"] - F
                d = np.sign(y[1]) if abs(y[1]) > 1e-12 else (np.sign(surplus) or 1.0)

            def rhs(s, y, d=d):
                F, dz = law(y[1], y[2:], d)
                a = (q["Sa"] * p(s) - q["k"] * y[0] - q["Fi"] - F) / q["M"]
                return np.concatenate([[y[1], a], dz])

            events = [lambda s, y, d=d: d * y[1] + 1e-14]
            margins = getattr(law, "margins", None)
            if margins:
                events += [lambda s, y, i=i, d=d: margins(y[1], y[2:], d)[i] for i in range(n)]
            sol = run(rhs, y, t, t1, events, atol)
            assert sol.status >= 0, sol.message
            fill(path, sol, t, sol.t[-1])
            t, y = sol.t[-1], sol.y[:, -1]
            if sol.status == 1:
                which = next(i for i, e in enumerate(sol.t_events) if len(e))
                if which == 0:
                    d = -d
                    if margins:
                        law.reset()
                else:
                    law.slip[which - 1] = True
    return path


def lugre(q, s0, s1):
    def law(v, z, d):
        dz = v - d * v * z * s0 / curve(q, v)
        return s0 * z[0] + s1 * dz[0] + q["Fv"] * v, dz
    return law


def dahl(Fc, s0, Fv):
    def law(v, z, d):
        dz = v - d * v * z * s0 / Fc
        return s0 * z[0] + Fv * v, dz
    return law


class Gms:
    def __init__(self, q, k, nu, alpha, C):
        self.q, self.C = q, C
        self.k, self.nu, self.alpha = map(np.array, (k, nu, alpha))
        self.reset()

    def reset(self):
        self.slip = np.zeros(3, bool)

    def __call__(self, v, z, d):
        s = curve(self.q, v)
        # z' = (C a/k) (d - F/(a s)), F = k z + nu z': solved for z'.
        c = self.C * self.alpha / self.k
        slipping = c * (d - self.k * z / (self.alpha * s)) / (1 + c * self.nu / (self.alpha * s))
        dz = np.where(self.slip, slipping, v)
        return float(np.sum(self.k * z + self.nu * dz)) + self.q["Fv"] * v, dz

    def margins(self, v, z, d):
        m = self.alpha * curve(self.q, v) - d * (self.k * z + self.nu * v)
        return np.where(self.slip, 1.0, m)


def stick_slip(q, points, tau=0.0, band=0.0, constant=False):
    """Classical or Karnopp friction, optional air lag (a third state)."""
    demand = pressure(points)
    path = np.full(len(TIMES), np.nan)
    slips, stops = [], []
    x, v, p, mode, d = 0.0, 0.0, points[0][1], "held", 1.0
    friction = (lambda v: q["Fc"]) if constant else (lambda v: curve(q, v))
    for (t0, a), (t1, b) in zip(points, points[1:]):
        slope = (b - a) / (t1 - t0)
        t = t0
        while t < t1:
            # exact lag, used only while the stem stands still
            def acting(s, t=t, p=p):
                if tau == 0:
                    return demand(s)
                u = a + slope * (t - t0)
                return u + slope * (s - t) - slope * tau + (p - u + slope * tau) * np.exp(-(s - t) / tau)

            def net(s, x=x):
                return q["Sa"] * acting(s) - q["k"] * x - q["Fi"]

            if mode == "held":
                grid = np.linspace(t, t1, 4001)
                over = np.abs([net(s) for s in grid]) - q["Fs"]
                hit = np.nonzero(over[1:] > 0)[0]
                end = t1 if len(hit) == 0 else brentq(
                    lambda s: abs(net(s)) - q["Fs"], grid[hit[0]], grid[hit[0] + 1], xtol=1e-14, rtol=1e-15)
                path[(TIMES >= t) & (TIMES <= end)] = x
                p = acting(end)
                if len(hit):
                    d = np.sign(net(end))
                    mode = "breaking" if band > 0 else "moving"
                    v = 0.0
                    if band == 0:
                        slips.append((end, x))
                t = end
                continue
            if mode == "breaking":
                momentum = lambda s: solve_ivp(lambda r, y: [(d * net(r) - q["Fs"]) / q["M"]], (t, s), [0.0],
                                               method="DOP853", rtol=1e-13, atol=1e-18).y[0, -1] - band
                hi = t + 1e-6
                while momentum(hi) < 0:
                    hi = t + 2 * (hi - t)
                end = brentq(momentum, t, hi, xtol=1e-14, rtol=1e-15)
                path[(TIMES >= t) & (TIMES <= end)] = x
                p, t, v, mode = acting(end), end, d * band, "moving"
                slips.append((t, x))
                continue

            def rhs(s, y, d=d):
                u = a + slope * (s - t0)
                P = u if tau == 0 else y[2]
                acc = (q["Sa"] * P - q["k"] * y[0] - q["Fi"] - d * friction(y[1]) - q["Fv"] * y[1]) / q["M"]
                return [y[1], acc, 0.0 if tau == 0 else (u - y[2]) / tau]

            start = t
            y = np.array([x, v, p if tau else demand(t)])
            leave = lambda s, y, d=d: 1.0 if s < start + 1e-9 else d * y[1] - band
            sol = run(rhs, y, t, t1, [leave], [1e-15, 1e-15, 1e-8])
            assert sol.status >= 0, sol.message
            fill(path, sol, t, sol.t[-1])
            t, (x, v, p) = sol.t[-1], sol.y[:, -1]
            if tau == 0:
                p = demand(t)
            if sol.status == 1:
                v = 0.0
                stops.append((t, x))
                assert abs(q["Sa"] * p - q["k"] * x - q["Fi"]) <= q["Fs"]
                mode = "held"
    return path, dict(slips=slips, stops=stops)


def armstrong(q, points, kt, excess, memory, rise):
    """Presliding spring, delayed Stribeck part, rising static friction; windows of one memory."""
    p = pressure(points)
    path = np.full(len(TIMES), np.nan)
    slips, stops = [], []
    past = []                     # (start, end, solution)
    x, t, d = 0.0, 0.0, 1.0
    net = lambda s, x: q["Sa"] * p(s) - q["k"] * x - q["Fi"]
    anchor, last, rest = x - net(0, x) / kt, excess, -np.inf

    def delayed(s):
        for a, b, sol in reversed(past):
            if a <= s <= b:
                return sol(s)[1]
        return 0.0

    def static(s):
        dwell = s - rest
        return q["Fc"] + last + (excess - last) * (1.0 if np.isinf(dwell) else dwell / (dwell + rise))

    T = points[-1][0]
    corners = [c for c, _ in points]
    while t < T:
        held = lambda s: anchor + net(s, anchor) / (q["k"] + kt)
        over = lambda s: abs(kt * (held(s) - anchor)) - static(s)
        grid = np.unique(np.concatenate([np.arange(t, T, 0.002), corners, [T]]))
        grid = grid[grid >= t]
        end = T
        for a, b in zip(grid, grid[1:]):
            if over(b) > 0:
                end = brentq(over, a, b, xtol=1e-14, rtol=1e-15)
                break
        mask = (TIMES >= t) & (TIMES <= end)
        path[mask] = [held(s) for s in TIMES[mask]]
        t = end
        if t >= T:
            break
        x, d = held(t), np.sign(net(t, held(t)))
        level = static(t) - q["Fc"]
        slips.append((t, x))
        y, begin, moving = np.array([x, 0.0]), t, True
        while moving and t < T:
            stop = min([t + memory] + [c for c in corners if c > t + 1e-12])

            def rhs(s, y):
                w = delayed(s - memory)
                F = d * (q["Fc"] + level / (1 + (w / q["vs"]) ** 2)) + q["Fv"] * y[1]
                return [y[1], (net(s, y[0]) - F) / q["M"]]

            leave = lambda s, y: 1.0 if s < begin + 1e-9 else d * y[1]
            leave.terminal, leave.direction = True, -1
            sol = solve_ivp(rhs, (t, stop), y, method="DOP853", rtol=1e-12, atol=1e-15, events=[leave],
                            dense_output=True)
            past.append((t, sol.t[-1], sol.sol))
            past = past[-4:]
            fill(path, sol, t, sol.t[-1])
            t, y = sol.t[-1], sol.y[:, -1]
            if sol.status == 1:
                x = y[0]
                stops.append((t, x))
                last = level / (1 + (delayed(t - memory) / q["vs"]) ** 2)
                rest, anchor, moving = t, x - net(t, x) / kt, False
                assert abs(net(t, x)) <= static(t)
    return path, dict(slips=slips, stops=stops)


def coulomb_extended():
    """CTS valve, Fv = 3.5 N s/m: closed solution and bisection in extended precision."""
    f = np.longdouble
    M, k, Sa, Fs, Fc, Fv = map(f, ("1.36", "52500", "0.0645", "1708", "1423", "3.5"))
    rate, sigma = f("826.87"), -Fv / (2 * M)
    w = np.sqrt(k / M - sigma * sigma)
    corner = [(f(0), f(0), rate), (f(100), f(82687), -rate), (f(200), f(0), rate), (f(300), f(82687), -rate)]

    def p(s):
        t0, p0, b = corner[min(int(s // 100), 3)]
        return p0 + b * (s - t0), b

    def bisect(g, a, b):
        for _ in range(200):
            m = (a + b) / 2
            a, b = (m, b) if g(m) > 0 else (a, m)
        return b

    x, t, slips, stops, seen = f(0), f(0), [], [], {}
    while t < 400:
        # at rest: linear in each segment
        end = (np.floor(t / 100) + 1) * 100
        while True:
            P, b = p(t)
            ahead = [(s * Fs + k * x - Sa * P) / (Sa * b) for s in (1, -1)]
            ahead = [h for h, s in zip(ahead, (1, -1)) if s * b > 0 and h >= 0]
            if ahead and t + ahead[0] < end:
                t += ahead[0]
                break
            t, end = end, end + 100
            if t >= 400:
                return slips, stops, seen
        d = 1 if Sa * p(t)[0] - k * x > 0 else -1
        slips.append((float(t), float(x)))
        # M x'' + Fv x' + k x = f0 + q s, x(0) = v(0) = 0
        f0, q = d * (Fs - Fc), Sa * b
        a1 = q / k
        a0 = (f0 - Fv * a1) / k
        move = lambda s: a0 + a1 * s + np.exp(sigma * s) * (
            -a0 * np.cos(w * s) + (sigma * a0 - a1) / w * np.sin(w * s))
        speed = lambda s: a1 + np.exp(sigma * s) * (
            -a1 * np.cos(w * s) + (k / M * a0 - sigma * a1) / w * np.sin(w * s))
        # check the velocity formula against differences of the other
        h = f("1e-7")
        assert abs((move(f("0.005") + h) - move(f("0.005") - h)) / (2 * h) - speed(f("0.005"))) < 1e-8
        half = f(np.pi) / w
        last = bisect(lambda s: d * speed(s), half * f("0.9"), half * f("1.2"))
        for at in (f(85), f(285)):
            if t <= at <= t + last:
                seen[str(float(at))] = float(x + move(at - t))
        t, x = t + last, x + move(last)
        stops.append((float(t), float(x)))
    return slips, stops, seen


def main():
    paths, events = {}, {}

    def add(name, result):
        path, found = result if isinstance(result, tuple) else (result, None)
        assert not np.isnan(path).any(), name
        paths[name] = path
        if found is not None:
            events[name] = found
        print(name, path.min(), path.max(), {k: len(v) for k, v in (found or {}).items()}, flush=True)

    slips, stops, seen = coulomb_extended()
    (OUT / "coulomb_extended.json").write_text(json.dumps(dict(slips=slips, stops=stops, positions=seen), indent=1))
    add("stribeck_usp", stick_slip(USP, USP_TRIANGLE))
    add("stribeck_cts_lag", stick_slip(CTS, CTS_TRIANGLE, tau=0.8))
    add("coulomb_cts_lag", stick_slip(CTS, CTS_TRIANGLE, tau=0.8, constant=True))
    add("coulomb_usp_lag", stick_slip(USP, USP_TRIANGLE, tau=3.5714, constant=True))
    add("karnopp_cts", stick_slip(CTS, CTS_TRIANGLE, band=2e-4))
    add("armstrong_cts", armstrong(CTS, CTS_TRIANGLE, kt=1e7, excess=285.0, memory=0.01, rise=2.0))
    add("dahl_usp", bristles(USP, USP_TRIANGLE, dahl(700.0, 2.6e7, 125000.0), 1, 1e-17))
    add("lugre_usp", bristles(USP, USP_TRIANGLE, lugre(USP, 2.6e7, 20396.07805437114), 1, 1e-17))
    add("lugre_graphite", bristles(GRAPHITE, USP_TRIANGLE, lugre(GRAPHITE, 1.038e9, 2.4417e5), 1, 1e-18))
    add("lugre_textbook", bristles(BOOK, BOOK_TRIANGLE, lugre(BOOK, 1e5, np.sqrt(1e5)), 1, 1e-16))
    gms = Gms(USP, [2.925e7, 1.56e7, 3.12e6], [2910.9, 1455.5, 4366.4], [0.75, 0.2, 0.05], 20.0)
    add("gms_usp", bristles(USP, USP_TRIANGLE, gms, 3, 1e-17))

    with open(OUT / "stem_paths.csv", "w") as out:
        out.write(",".join(["t"] + list(paths)) + "\n")
        for i, t in enumerate(TIMES):
            out.write(",".join([repr(float(t))] + [f"{paths[n][i]:.14g}" for n in paths]) + "\n")
    (OUT / "stem_events.json").write_text(json.dumps(events, indent=1))


if __name__ == "__main__":
    sys.exit(main())
