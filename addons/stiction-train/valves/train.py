"""Trains the model of valves on the pools that `stiction-train valves` writes, and measures it on valves that it has not seen.

    python addons/stiction-train/valves/train.py target/valves crates/stiction-diagnose/model

The program reads `valves.pools`, `valves.pools.csv`, `valves.columns.csv` and `valves.confidence.csv` in the first folder (and
`invented.*`, if these files exist, to measure only). It writes `valves.bin` and its card `VALVES.md` into the second folder.

Each valve gives a row for its whole record, and rows for its first and last half, quarter and so on, which together weigh as much
as the first. The training uses all rows; thresholds and tables use whole records. Valves whose record cannot show their fault are
left out. Valves with a single window are used for training, but a diagnosis keeps the probability of the first model for a single
window. So thresholds and tables are of valves with two windows or more. All choices are made on predictions for valves on which a
trial model was not trained: five folds for thresholds and S, and every family of loops in turn for the confidence. LightGBM is
deterministic on one version of it, on any number of threads.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import struct
import sys
from pathlib import Path

import lightgbm
import numpy as np
from scipy.stats import beta

FOLDS = 5
FEATURES = 120
COMMON = {
    "learning_rate": 0.03, "num_leaves": 23, "min_data_in_leaf": 20, "feature_fraction": 0.25, "bagging_fraction": 0.8,
    "bagging_freq": 1, "lambda_l2": 5.0, "seed": 1, "deterministic": True, "force_col_wise": True, "num_threads": 1,
    "verbose": -1,
}  # fmt: skip
FAULT = (700, COMMON | {"objective": "binary"})
TRIAL = (150, COMMON | {"objective": "binary", "learning_rate": 0.1})
S = (250, COMMON | {"objective": "quantile", "num_leaves": 15, "lambda_l2": 0.0})

# As in decide.rs and families.rs.
SURE, FREE, WRONG_SURE, COUNTED, EXCUSED, NEVER = 0.98, 0.1, 0.04, 20, 2, 0.975
DOUBT, WRONG, ACCUSED, ACCUSED_OF_KIND, LEFT_OUT, FEWEST, LARGEST = 0.1, 0.04, 0.01, 0.03, 0.05, 200, 0.6
COVERAGE = 0.9


class Valves:
    """Pools of valves and their truth."""

    def __init__(self, folder: Path, what: str) -> None:
        columns = [line.rsplit(",", 1) for line in (folder / f"{what}.columns.csv").read_text().splitlines()]
        self.names = [name for name, _ in columns]
        self.signs = [int(sign) for _, sign in columns]
        # From which log-odds the model of a window reports 0.98, against a fault and for one.
        self.reached = [float(side) for side in (folder / f"{what}.confidence.csv").read_text().split(",")]
        self.first = self.names.index("ln span, most less mean") + 1
        with (folder / f"{what}.pools.csv").open() as lines:
            rows = list(csv.DictReader(lines))
        self.x = np.frombuffer((folder / f"{what}.pools").read_bytes(), "<f4").reshape(-1, len(columns))
        number = lambda key: np.array([float(row[key]) for row in rows])  # noqa: E731
        self.kind = np.array([row["kind"] for row in rows])
        self.fault, self.visible = number("fault") > 0.5, number("visible") > 0.5
        self.s = number("S")
        self.windows = self.x[:, 0]
        self.part = np.array([row["part"] for row in rows])
        self.whole = self.part == "all"
        self.valve = number("valve").astype(int)
        self.fold = self.valve % FOLDS
        parts = np.bincount(self.valve)[self.valve] - 1
        self.weight = np.where(self.whole, 1.0, 1.0 / np.maximum(parts, 1))
        self.families = [set(row["families"].split(";")) - {""} for row in rows]
        self.known = ~self.fault | self.visible
        self.several = self.known & self.whole & (self.windows > 1.5)
        # S of a valve in the loop below refers to a different OP, and that of a stuck one is not its own.
        self.has_s = self.fault & self.visible & (self.s > 0.0) & (self.s < 100.0)
        # As the trees learn it: above the weighted mean of the windows.
        self.ln_s = np.log(np.maximum(self.s, 1e-9)) - number("mean_ln_s")


def fitted(recipe: tuple, valves: Valves, columns: np.ndarray, y: np.ndarray, use: np.ndarray, **more: object) -> lightgbm.Booster:
    rounds, parameters = recipe
    data = lightgbm.Dataset(valves.x[use][:, columns], y[use], weight=valves.weight[use])
    return lightgbm.train(parameters | more, data, rounds)


def out_of_fold(recipe: tuple, valves: Valves, columns: np.ndarray, y: np.ndarray, use: np.ndarray, raw: bool = False, **more: object) -> np.ndarray:
    """Predictions for every valve by a model without its fold."""
    found = np.full(len(y), np.nan)
    for fold in range(FOLDS):
        asked = valves.fold == fold
        model = fitted(recipe, valves, columns, y, use & ~asked, **more)
        found[asked] = model.predict(valves.x[asked][:, columns], raw_score=raw)
    return found


def sigmoid(x: np.ndarray) -> np.ndarray:
    return 1.0 / (1.0 + np.exp(-x))


def logit(p: float) -> float:
    return float(np.log(p / (1.0 - p)))


def reported(log_odds: np.ndarray, sides: list[tuple[float, float]]) -> np.ndarray:
    """The reported log-odds, as `Confidence::reported`."""
    free, sure = logit(1.0 - FREE), logit(SURE)
    size = np.abs(log_odds)
    out = size.copy()
    for side, own in zip(sides, (log_odds < 0.0, log_odds >= 0.0)):
        reached, most = side
        slope = (sure - free) / (reached - free)
        out = np.where(own & (size > free), np.minimum(free + (size - free) * slope, most), out)
    return np.sign(log_odds) * out


def without_families(valves: Valves, columns: np.ndarray, signs: list[int]) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """For every family of sufficient size: the log-odds of its valves by a model trained without it, and which of these valves
    are at fault.
    """
    faults = [valves.kind == kind for kind in np.unique(valves.kind[valves.fault])]
    chosen = []
    for name in sorted(set().union(*valves.families)):
        of = np.array([name in each for each in valves.families])
        # One that contains all loops of a fault leaves nothing to learn it from, as in families.rs.
        if FEWEST <= (of & valves.several).sum() <= LARGEST * valves.several.sum() and not any(of[kind].all() for kind in faults):
            chosen.append((name, of))

    found = []
    # One after another: LightGBM is safe neither on threads nor after a fork.
    for name, of in chosen:
        asked, rest = of & valves.several, ~of & valves.known & valves.whole
        model = fitted(TRIAL, valves, columns, valves.fault, rest, monotone_constraints=signs)
        found.append((name, model.predict(valves.x[asked][:, columns], raw_score=True), valves.fault[asked]))
    return found


def sides_of(families: list, least: list[float]) -> list[tuple[float, float]]:
    """From which log-odds 0.98 is reported, against a fault and for one, and the largest: as `thresholds` in families.rs.

    They give the most sure decisions under two conditions: on either side over all left-out families, at most 4 % are wrong, and
    more are wrong in at most two families. They are never below the probabilities of a window's model trained without the same
    families.
    """

    def counted(sign: float, first: float) -> list[tuple[float, np.ndarray]]:
        found = []
        for start in np.arange(first, first + 6.05, 0.1):
            sure = [(sign * log_odds >= start, fault != (sign > 0)) for _, log_odds, fault in families]
            found.append((float(start), np.array([((wrong & of).sum(), of.sum()) for of, wrong in sure])))
        return [*found, (np.inf, np.zeros((len(families), 2), int))]

    best, most = [np.inf, np.inf], 0
    clearing, accusing = (counted(sign, first) for sign, first in zip((-1.0, 1.0), least))
    for low, cleared in clearing:
        for high, accused in accusing:
            sides = [cleared.sum(axis=0), accused.sum(axis=0)]
            wrong, every = (cleared + accused).T
            above = (wrong > 1) & (every >= COUNTED) & (wrong > WRONG_SURE * every)
            decided = sum(n for _, n in sides)
            if decided > most and all(k <= WRONG_SURE * n for k, n in sides) and above.sum() <= EXCUSED:
                best, most = [low, high], decided
    return [(each, np.inf) if np.isfinite(each) else (logit(SURE) + 6.0, logit(NEVER)) for each in best]


def at_most(k: int, n: int) -> float:
    """The upper limit of the one-sided interval of a share."""
    return 1.0 if k >= n else float(beta.ppf(1.0 - DOUBT, k + 1, n - k))


def breaks(p: np.ndarray, valves: Valves, families: list, accuse: float, clear: float) -> list[str]:
    """The bounds that these thresholds break."""
    known, fault = valves.several, valves.fault
    accused, cleared = known & (p >= accuse), known & (p <= clear)
    wrong = (accused & ~fault) | (cleared & fault)
    found = []
    if at_most(int(wrong.sum()), int((accused | cleared).sum())) > WRONG:
        found.append("wrong")
    if at_most(int((accused & ~fault).sum()), int((known & ~fault).sum())) > ACCUSED:
        found.append("accused")
    for kind in np.unique(valves.kind[~fault]):
        of = known & ~fault & (valves.kind == kind)
        if of.sum() >= FEWEST and (accused & of).sum() > ACCUSED_OF_KIND * of.sum():
            found.append(f"accused of {kind}")
    shares = [((q >= accuse) & ~f | (q <= clear) & f, (q >= accuse) | (q <= clear)) for q, f in families]
    if sum(w.sum() for w, _ in shares) > LEFT_OUT * sum(d.sum() for _, d in shares):
        found.append("left out")
    return found


def thresholds(p: np.ndarray, valves: Valves, families: list) -> tuple[float, float]:
    """From 0.95 and 0.05 outwards by a hundredth on each side in turn, as far as all bounds hold."""
    accuse, clear = 0.95, 0.05
    moving = {"accuse", "clear"}
    while moving:
        for side in ("accuse", "clear"):
            if side not in moving:
                continue
            tried = (round(accuse - 0.01, 2), clear) if side == "accuse" else (accuse, round(clear + 0.01, 2))
            found = breaks(p, valves, families, *tried)
            print(f"{tried}: {', '.join(found) or 'holds'}", file=sys.stderr)
            if found or tried[0] < 0.6 or tried[1] > 0.4:
                moving.discard(side)
            else:
                accuse, clear = tried
    return accuse, clear


def conformal(excess: np.ndarray, share: float) -> float:
    """The smallest shift that at least this share of new cases does not exceed."""
    ordered = np.sort(excess)
    place = int(np.ceil(share * (len(ordered) + 1))) - 1
    return float(ordered[min(place, len(ordered) - 1)])


def s_shifts(quantiles: list[np.ndarray], y: np.ndarray, use: np.ndarray) -> list[tuple[float, float]]:
    """The shift of the interval for each fifth of its width."""
    low, _, high = np.sort([each[use] for each in quantiles], axis=0)
    width, excess = high - low, np.maximum(low - y[use], y[use] - high)
    ends = np.quantile(width, [0.2, 0.4, 0.6, 0.8])
    place = np.searchsorted(ends, width)
    return [(float([*ends, np.inf][k]), conformal(excess[place == k], COVERAGE)) for k in range(5)]


# The file.


def preorder(node: dict, out: list[bytes]) -> None:
    if "leaf_value" in node:
        out.append(struct.pack("<Hf", 0x7FFF, node["leaf_value"]))
        return
    assert node["decision_type"] == "<=", node
    # Without missing values in the training, a missing one counts as 0.
    left = node["default_left"] if node["missing_type"] == "NaN" else node["threshold"] >= 0.0
    out.append(struct.pack("<Hf", node["split_feature"] | (0 if left else 0x8000), below(node["threshold"])))
    preorder(node["left_child"], out)
    preorder(node["right_child"], out)


def below(threshold: float) -> float:
    """The largest f32 that is not above a threshold: of f32 values, the same go left."""
    with np.errstate(over="ignore"):
        near = np.float32(threshold)
    return float(near if near <= threshold else np.nextafter(near, np.float32(-np.inf)))


def trees(model: lightgbm.Booster) -> bytes:
    parts = [struct.pack("<d", 0.0)]
    all_of = model.dump_model()["tree_info"]
    parts.append(struct.pack("<I", len(all_of)))
    for tree in all_of:
        nodes: list[bytes] = []
        preorder(tree["tree_structure"], nodes)
        parts += [struct.pack("<I", len(nodes)), *nodes]
    return b"".join(parts)


def pairs(all_of: list[tuple[float, float]]) -> bytes:
    return struct.pack("<I", len(all_of)) + b"".join(struct.pack("<dd", *each) for each in all_of)


def text(of: str) -> bytes:
    return struct.pack("<I", len(of)) + of.encode()


# Accuracy on valves that the model has not seen.


def auc(fault: np.ndarray, p: np.ndarray) -> float:
    order = np.argsort(p, kind="stable")
    ranks = np.empty(len(p))
    ranks[order] = np.arange(1, len(p) + 1)
    n = fault.sum()
    return (ranks[fault].sum() - n * (n + 1) / 2) / (n * (len(p) - n))


HEAD = (
    "| valves | number | AUC | log loss | found where 1 % of the healthy are accused | decided | right | faults found | "
    "healthy accused | healthy cleared | faults cleared | sure (0.98) | wrong, of the sure |\n" + "|---" * 13 + "|\n"
)


def line(what: str, fault: np.ndarray, p: np.ndarray, accuse: float, clear: float) -> str:
    healthy, faulty = p[~fault], p[fault]
    if min(len(healthy), len(faulty)) < 10:
        return ""
    loss = -np.mean(np.log(np.clip(np.where(fault, p, 1 - p), 1e-9, 1)))
    one = np.sort(healthy)[::-1][len(healthy) // 100]
    decided = (p >= accuse) | (p <= clear)
    wrong = ((p >= accuse) & ~fault) | ((p <= clear) & fault)
    sure = (p >= SURE) | (p <= 1 - SURE)
    misled = ((p >= SURE) & ~fault) | ((p <= 1 - SURE) & fault)
    return (
        f"| {what} | {len(p)} | {auc(fault, p):.3f} | {loss:.3f} | {np.mean(faulty > one):.0%} | {decided.mean():.0%} | "
        f"{1 - wrong.sum() / max(decided.sum(), 1):.1%} | {np.mean(faulty >= accuse):.0%} | {np.mean(healthy >= accuse):.1%} | "
        f"{np.mean(healthy <= clear):.0%} | {np.mean(faulty <= clear):.1%} | {sure.mean():.0%} | {misled.sum() / max(sure.sum(), 1):.1%} |\n"
    )


LENGTHS = ((1.5, 3.5, "2 to 3"), (3.5, 7.5, "4 to 7"), (7.5, 15.5, "8 to 15"), (15.5, 1e9, "16 or more"), (1.5, 1e9, "all"))


def lengths(valves: Valves, p: np.ndarray, accuse: float, clear: float) -> str:
    out = HEAD
    for low, high, what in LENGTHS:
        own = valves.several & (valves.windows > low) & (valves.windows <= high)
        out += line(f"{what} windows", valves.fault[own], p[own], accuse, clear)
    return out


def calibration(valves: Valves, p: np.ndarray) -> str:
    out = "| probability | valves | mean | at fault |\n|---|---|---|---|\n"
    for low, high in ((0, 0.02), (0.02, 0.1), (0.1, 0.3), (0.3, 0.7), (0.7, 0.9), (0.9, 0.98), (0.98, 1.01)):
        own = valves.several & (p >= low) & (p < high)
        if own.any():
            out += f"| {low:.2f} to {min(high, 1):.2f} | {own.sum()} | {p[own].mean():.3f} | {valves.fault[own].mean():.3f} |\n"
    return out


def of_s(valves: Valves, quantiles: list[np.ndarray], shifts: list[tuple[float, float]], p: np.ndarray, accuse: float) -> str:
    low, middle, high = np.sort(quantiles, axis=0)
    width = high - low
    shift = np.array([shifts[min(int((np.array([w for w, _ in shifts]) < each).sum()), len(shifts) - 1)][1] for each in width])
    low, high = np.minimum(low - shift, middle), np.maximum(high + shift, middle)
    out = "| windows | valves accused | S is a number | median error | error below 15 % | interval contains S |\n|---|---|---|---|---|---|\n"
    for least, most, what in LENGTHS:
        own = valves.several & valves.has_s & (p >= accuse) & (valves.windows > least) & (valves.windows <= most)
        number = own & ((np.exp(high) - np.exp(low)) <= 2 * 0.35 * np.exp(middle))
        if number.sum() < 10:
            continue
        error = np.abs(np.expm1(middle - valves.ln_s))[number]
        held = ((valves.ln_s >= low) & (valves.ln_s <= high))[number]
        out += (
            f"| {what} | {own.sum()} | {number.sum() / own.sum():.0%} | {np.median(error):.1%} | {np.mean(error < 0.15):.0%} | "
            f"{held.mean():.0%} |\n"
        )
    return out


def longer(valves: Valves, p: np.ndarray, accuse: float, clear: float) -> str:
    out = "| windows | undecided | decided by 2 times the record | by 4 times | by 8 times |\n|---|---|---|---|---|\n"
    place = {key: k for k, key in enumerate(zip(valves.valve, valves.part))}
    first = lambda valve, k: place.get((valve, "all" if k == 0 else f"first {1 << k}"))  # noqa: E731
    decided = (p >= accuse) | (p <= clear)
    for low, high, what in LENGTHS:
        shares = {times: [0, 0] for times in (1, 2, 3)}
        for valve in np.unique(valves.valve):
            for k in range(1, 8):
                now = first(valve, k)
                if now is None or decided[now] or not low < valves.windows[now] <= high:
                    continue
                for times, share in shares.items():
                    if k >= times:
                        share[0] += int(decided[first(valve, k - times)])
                        share[1] += 1
        if shares[3][1] >= 10:
            of = " | ".join(f"{k / n:.0%} of {n}" for k, n in shares.values())
            out += f"| {what} | {shares[1][1]} | {of} |\n"
    return out


def main() -> int:
    arguments = argparse.ArgumentParser()
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("model", type=Path)
    arguments.add_argument("--fast", action="store_true", help="leave out no families; for trials")
    asked = arguments.parse_args()
    valves = Valves(asked.folder, "valves")
    every = np.arange(len(valves.names))
    summary = every < valves.first
    signs = np.where(summary, valves.signs, 0)
    first = fitted(TRIAL, valves, every, valves.fault, valves.known & valves.whole, monotone_constraints=signs.tolist())
    gain = first.feature_importance("gain") * ~summary
    features = np.sort(np.argsort(-gain, kind="stable")[:FEATURES])
    columns = np.concatenate([every[summary], features])
    own = signs[columns].tolist()

    fault = valves.fault
    log_odds = out_of_fold(FAULT, valves, columns, fault, valves.known, raw=True, monotone_constraints=own)
    left = [] if asked.fast else without_families(valves, columns, own)
    sides = sides_of(left, valves.reached) if left else [(reached, np.inf) for reached in valves.reached]
    p = sigmoid(reported(log_odds, sides))
    families = [(sigmoid(reported(each, sides)), truth) for _, each, truth in left]
    accuse, clear = thresholds(p, valves, families) if left else (0.9, 0.1)
    quantiles = [out_of_fold(S, valves, columns, valves.ln_s, valves.has_s, alpha=alpha) for alpha in (0.05, 0.5, 0.95)]
    shifts = s_shifts(quantiles, valves.ln_s, valves.has_s & valves.whole)

    final = fitted(FAULT, valves, columns, fault, valves.known, monotone_constraints=own)
    of_ln_s = [fitted(S, valves, columns, valves.ln_s, valves.has_s, alpha=alpha) for alpha in (0.05, 0.5, 0.95)]
    name = f"valves-{valves.whole.sum()}-{hashlib.sha256(valves.x.tobytes()).hexdigest()[:8]}"
    names = [valves.names[k] for k in features]
    parts = [b"VALVES 1", text(name), struct.pack("<I", len(names)), *map(text, names), struct.pack("<dd", accuse, clear)]
    parts += [struct.pack("<dd", *side) for side in sides]
    parts += [trees(final), *map(trees, of_ln_s), pairs(shifts), struct.pack("<d", 1.0)]
    content = b"".join(parts)
    (asked.model / "valves.bin").write_bytes(content)

    card = (
        f"# The model of valves: {name}\n\n"
        f"`addons/stiction-train/train.sh` trained this model with LightGBM {lightgbm.__version__}. It has {len(content):,} bytes and {len(names)} "
        f"features. The training has {valves.whole.sum()} simulated valves, {(valves.known & valves.whole).sum()} of them healthy or visibly at "
        f"fault, with records of 1 to 64 usual lengths. The training uses the whole record of each valve, and parts of this record. The tables cover the "
        f"{valves.several.sum()} of these valves with two windows or more. Each valve is judged by a model trained without the fold of this valve. A valve with a single "
        f"window keeps the probability from the single-window model.\n\n"
        f"A valve is accused from a probability of {accuse:.2f} and cleared up to {clear:.2f}. Log-odds beyond those of 0.90 are compressed so that a confidence of 0.98 is "
        f"reported at log-odds of {sides[0][0]:.1f} against a fault and of {sides[1][0]:.1f} for one. Beyond these log-odds, decisions on left-out families ({len(left)}) "
        f"are right in 96 % or more. These bounds are never below those for a single window.\n\n## Accuracy by number of windows\n\n" + lengths(valves, p, accuse, clear)
        + "\n## Calibration\n\n" + calibration(valves, p)
        + "\n## S\n\n" + of_s(valves, quantiles, shifts, p, accuse)
        + "\n## Longer records\n\nThe table counts valves that are undecided by the first part of their record, and the share of these valves that a "
        + "longer part decides.\n\n"
        + longer(valves, p, accuse, clear)
    )  # fmt: skip
    if families:
        card += "\n## Families left out in turn\n\nEach family was judged by smaller models that were trained without this family.\n\n" + HEAD
        for (family, *_), (of, truth) in zip(left, families):
            card += line(family, truth, of, accuse, clear)
    if (asked.folder / "invented.pools").exists():
        other = Valves(asked.folder, "invented")
        raw = final.predict(other.x[:, columns], raw_score=True)
        q = sigmoid(reported(raw, sides))
        card += "\n## Kinds that are never trained on\n\n" + lengths(other, q, accuse, clear) + "\n" + calibration(other, q) + "\n" + HEAD
        for kind in np.unique(other.kind):
            of = other.several & (other.kind == kind)
            card += line(kind, other.fault[of], q[of], accuse, clear)
        predicted = [model.predict(other.x[:, columns]) for model in of_ln_s]
        card += "\n" + of_s(other, predicted, shifts, q, accuse)
    (asked.model / "VALVES.md").write_text(card)
    print(card)
    return 0


if __name__ == "__main__":
    sys.exit(main())
