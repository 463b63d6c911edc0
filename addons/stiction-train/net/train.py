"""Train the nets that hear raw signals, on what `stiction-train gather` has kept.

    python train.py CACHE MODEL/net.bin --n 300000 --seed 1 --test 15000

Trains two nets, one on the even and one on the odd loops among the first four fifths. Both go into one file, which
`stiction_diagnose::evidence::raw` reads. The shape must be the one that its `net.rs` describes. For the examination `stiction-train
signals`, `--half` trains the first net alone, and `--without "AXIS: NAME"` leaves families out.
"""

import argparse
import csv
import struct
import time

import numpy as np
import torch
import torch.nn.functional as F
from torch import nn

CHANNELS, LENGTH, SCALARS, UNITS, FOLDS = 8, 1024, 8, 2000.0, 2
RECORD = np.dtype(
    [
        ("index", "<u8"),
        ("samples", "<u4"),
        ("nothing", "<u4"),
        ("scalars", "<f4", SCALARS),
        ("values", "<i2", (LENGTH, CHANNELS)),
    ]
)
# In the order of `Cause::ALL`.
CAUSES = [
    "sticking valve",
    "no response",
    "aggressive tuning",
    "external oscillation",
    "external wave with corners",
    "load that ramps and resets",
    "dead zone elsewhere",
    "quantisation",
    "saturation",
    "set-point changes",
    "process nonlinearity",
    "normal operation",
]
FEWEST_SLIPS = 3
BATCH = 192
RATE = 3e-3


class Block(nn.Module):
    """Two separable convolutions, and a way around them."""

    def __init__(self, inputs, outputs, spacing, every):
        super().__init__()
        self.every = every
        reach = 4 * spacing
        self.filters = nn.ModuleList(
            [
                nn.Conv1d(inputs, inputs, 9, every, reach, spacing, groups=inputs, bias=False),
                nn.Conv1d(outputs, outputs, 9, 1, reach, spacing, groups=outputs, bias=False),
            ]
        )
        self.mixes = nn.ModuleList(
            [nn.Conv1d(inputs, outputs, 1, bias=False), nn.Conv1d(outputs, outputs, 1, bias=False)]
        )
        self.norms = nn.ModuleList([nn.BatchNorm1d(outputs), nn.BatchNorm1d(outputs)])
        same = every == 1 and inputs == outputs
        self.around = None if same else nn.Conv1d(inputs, outputs, 1, every, bias=False)

    def forward(self, x, mask):
        behind = mask[:, :, :: self.every]
        y = F.hardswish(self.norms[0](self.mixes[0](self.filters[0](x)))) * behind
        y = self.norms[1](self.mixes[1](self.filters[1](y)))
        x = x if self.around is None else self.around(x)
        return F.hardswish(x + y) * behind, behind


class Net(nn.Module):
    """From signals, their length and scalars to outputs."""

    SHAPE = [(32, 1, 1), (64, 1, 4), (64, 2, 1), (96, 1, 2), (96, 2, 1), (128, 1, 2), (128, 2, 1)]

    def __init__(self):
        super().__init__()
        self.first = nn.Conv1d(CHANNELS, 32, 9, 2, 4, bias=False)
        self.norm = nn.BatchNorm1d(32)
        channels, blocks = 32, []
        for outputs, spacing, every in self.SHAPE:
            blocks.append(Block(channels, outputs, spacing, every))
            channels = outputs
        self.blocks = nn.ModuleList(blocks)
        self.hidden = nn.Linear(2 * channels + SCALARS, 128)
        self.drop = nn.Dropout(0.2)
        self.output = nn.Linear(128, 3 + len(CAUSES))

    def forward(self, x, mask, scalars):
        mask = mask[:, :, ::2]
        x = F.hardswish(self.norm(self.first(x))) * mask
        for block in self.blocks:
            x, mask = block(x, mask)
        mean = x.sum(2) / mask.sum(2).clamp(min=1)
        most = (x - 1e4 * (1 - mask)).amax(2)
        return self.output(self.drop(F.hardswish(self.hidden(torch.cat([mean, most, scalars], 1)))))

    def weights(self):
        """All weights in the order of their file, normalisation folded into the matrices before it."""

        def folded(matrix, norm):
            scale = norm.weight / torch.sqrt(norm.running_var + norm.eps)
            # Tap by tap and input by input, outputs side by side.
            yield (matrix.weight * scale[:, None, None]).permute(2, 1, 0)
            yield norm.bias - norm.running_mean * scale

        yield from folded(self.first, self.norm)
        for block in self.blocks:
            for filters, mix, norm in zip(block.filters, block.mixes, block.norms, strict=True):
                yield filters.weight[:, 0].T
                yield from folded(mix, norm)
            if block.around is not None:
                yield block.around.weight.permute(2, 1, 0)
                yield torch.zeros(block.around.out_channels)
        for layer in (self.hidden, self.output):
            yield layer.weight.T
            yield layer.bias

    def packed(self):
        """Those weights as the upper halves of 32-bit numbers, rounded to even."""
        values = np.concatenate([w.detach().numpy().ravel() for w in self.weights()])
        bits = values.astype("<f4").view("<u4").astype(np.uint64)
        return ((bits + 0x7FFF + ((bits >> 16) & 1)) >> 16).astype("<u2").tobytes()


class Loops:
    """Signals and truth of the loops of a seed."""

    def __init__(self, folder, seed, members):
        self.signals = np.memmap(f"{folder}/signals-{seed}-{members}.bin", RECORD, "r")
        with open(f"{folder}/seed-{seed}-{members}.csv", encoding="utf-8") as file:
            next(file), next(file)
            rows = csv.reader(file)
            names = next(rows)
            wanted = ["index", "cause", "visible", "slips", "S", "J", "op_span", "families"]
            places = [names.index(name) for name in wanted]
            columns = list(zip(*([row[k] for k in places] for row in rows), strict=True))
        index, cause, visible, slips, s, j, span, families = columns
        self.index = np.array(index, np.int64)
        if not (self.index == self.signals["index"]).all():
            raise SystemExit("signals and matrix are of different loops")
        self.cause = np.array([CAUSES.index(name) for name in cause])
        at_fault, shows = self.cause < 2, np.array(visible) == "true"
        self.fault = (at_fault & shows).astype(np.float32)
        self.taught = (~at_fault | shows) & (self.signals["samples"] > 0)
        s, span = np.array(s, np.float64), np.array(span, np.float64)
        slipped = np.array(slips, np.int64) >= FEWEST_SLIPS
        self.sticks = ((self.cause == 0) & shows & slipped & (s > 0)).astype(np.float32)
        with np.errstate(all="ignore"):
            ratio = [np.log(s / span), np.array(j, np.float64) / s]
        self.ln_s, self.j = (
            np.where(self.sticks > 0, x, 0).astype(np.float32) for x in ratio
        )
        self.families = families

    def batch(self, rows):
        """Signals, which samples there are, and scalars."""
        records = self.signals[rows]
        x = torch.from_numpy(records["values"].astype(np.float32) / UNITS)
        samples = torch.from_numpy(records["samples"].astype(np.int64))
        mask = (torch.arange(LENGTH)[None] < samples[:, None]).float()[:, None]
        return x.transpose(1, 2).contiguous(), mask, torch.from_numpy(records["scalars"] / 2)


def loss_of(said, loops, rows):
    """Fault, ln S and J/S of what sticks, and the cause."""

    def of(values):
        return torch.from_numpy(values[rows])

    sticks = of(loops.sticks)
    count = sticks.sum().clamp(min=1)
    s = (F.smooth_l1_loss(said[:, 1], of(loops.ln_s), reduction="none") * sticks).sum() / count
    j = (F.smooth_l1_loss(said[:, 2], of(loops.j), reduction="none") * sticks).sum() / count
    fault = F.binary_cross_entropy_with_logits(said[:, 0], of(loops.fault))
    return fault + 0.15 * s + 0.3 * j + 0.25 * F.cross_entropy(said[:, 3:], of(loops.cause))


def train(loops, rows, passes, seed):
    """Train a net on some of the loops."""
    torch.manual_seed(seed)
    random = np.random.default_rng(seed)
    net = Net()
    steps = len(rows) // BATCH
    optimiser = torch.optim.AdamW(net.parameters(), RATE, weight_decay=1e-3)
    schedule = torch.optim.lr_scheduler.OneCycleLR(
        optimiser, RATE, total_steps=passes * steps, pct_start=0.08
    )
    begun = time.time()
    for turn in range(passes):
        net.train()
        order, total = random.permutation(rows), 0.0
        for step in range(steps):
            some = np.sort(order[step * BATCH : (step + 1) * BATCH])
            with torch.autocast("cpu", dtype=torch.bfloat16):
                said = net(*loops.batch(some))
            loss = loss_of(said.float(), loops, some)
            optimiser.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(net.parameters(), 1.0)
            optimiser.step()
            schedule.step()
            total += loss.item()
        print(f"pass {turn + 1}: loss {total / steps:.4f}, {time.time() - begun:.0f} s", flush=True)
    return net.eval()


def logits(net, loops, rows):
    """The log-odds of a fault."""
    out = []
    with torch.no_grad(), torch.autocast("cpu", dtype=torch.bfloat16):
        for part in np.array_split(rows, max(1, len(rows) // 512)):
            out.append(net(*loops.batch(part))[:, 0].float().numpy())
    return np.concatenate(out)


def printed(name, logit, fault):
    """Prints how well log-odds rank, and their log loss."""
    order = np.argsort(logit, kind="stable")
    ranks = np.empty(len(order))
    ranks[order] = np.arange(1, len(order) + 1)
    hits = fault > 0
    yes, no = hits.sum(), (~hits).sum()
    auc = (ranks[hits].sum() - yes * (yes + 1) / 2) / max(yes * no, 1)
    loss = np.logaddexp(0, np.where(hits, -logit, logit)).mean()
    print(f"{name}: {len(logit)} loops, AUC {auc:.4f}, log loss {loss:.4f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("cache", help="folder of `stiction-train gather`")
    parser.add_argument("output", help="file for the nets")
    parser.add_argument("--n", type=int, default=300_000, help="members of the population")
    parser.add_argument("--seed", type=int, default=1, help="seed of their population")
    parser.add_argument("--test", type=int, default=15_000, help="members of the next seed")
    parser.add_argument("--passes", type=int, default=5, help="passes through the loops")
    parser.add_argument("--half", action="store_true", help="train the first net alone")
    parser.add_argument("--without", action="append", default=[], help="a family to leave out")
    args = parser.parse_args()

    loops = Loops(args.cache, args.seed, args.n)
    fresh = Loops(args.cache, args.seed + 1, args.test)
    left_out = set(args.without)
    kept = np.array([left_out.isdisjoint(of.split(";")) for of in loops.families])
    trained = loops.index < round(0.8 * args.n)
    rows = np.arange(len(fresh.index))[fresh.taught]
    packed, sum_of_all = b"", 0.0
    nets = 1 if args.half else FOLDS
    for fold in range(nets):
        taught = np.flatnonzero(loops.taught & trained & kept & (loops.index % FOLDS == fold))
        print(f"net {fold + 1}: {len(taught)} loops", flush=True)
        net = train(loops, taught, args.passes, fold)
        packed += net.packed()
        said = logits(net, fresh, rows)
        printed(f"net {fold + 1}, fresh loops", said, fresh.fault[rows])
        sum_of_all = sum_of_all + said
    printed("mean, fresh loops", sum_of_all / nets, fresh.fault[rows])
    with open(args.output, "wb") as file:
        file.write(b"STICNET1" + struct.pack("B", nets) + packed)


if __name__ == "__main__":
    main()
