#!/usr/bin/env bash
# Trains the nets, the trees of the verdict and the model of valves, and writes crates/stiction-diagnose/model. With Rust and
# Python, in an environment in which `pip install -r addons/stiction-train/requirements.txt` was done. Some three hours and 6 GB
# of disk on two cores; the trees are the same to the bit wherever the nets are.
set -euo pipefail
cd "$(dirname "$0")/../.."

members=${1:-300000}
cache=${2:-target/training}
model=crates/stiction-diagnose/model
train() { cargo run --profile dist -p stiction-train -- --n "$members" --seed 1 --test 15000 --cache "$cache" "$@"; }

train gather
python addons/stiction-train/net/train.py "$cache" "$model/net.bin" --n "$members" --seed 1 --test 15000
# The nets are compiled in.
train hear
train -o "$model"
# Valves with long records, by the model of a window above.
valves=target/valves
cargo run --profile dist -p stiction-train -- --n 20000 --seed 11 --cache "$valves" valves
cargo run --profile dist -p stiction-train -- --n 2400 --seed 5 --cache "$valves" valves --invented
python addons/stiction-train/valves/train.py "$valves" "$model"
