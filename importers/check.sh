#!/usr/bin/env bash
# Exports every model for both versions of FMI, and has the fmi crate import and simulate each: check.sh [STICTION]
# with the command to export with, which else is built. Needs libclang.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
stiction=${1:-}
if [ -z "$stiction" ]; then
    cargo build --quiet --locked -p stiction-cli
    stiction=${CARGO_TARGET_DIR:-target}/debug/stiction
fi
"$stiction" fmu --list | while read -r kind name _; do
    case $kind in
        valve) what=(--model "$name") ;;
        stem) what=(--stem "$name") ;;
        loop) what=(paper/closed-loop --set "valve.model=\"$name\"") ;;
        *) continue ;; # The platforms, below the models.
    esac
    for fmi in 2 3; do
        "$stiction" fmu "${what[@]}" --fmi "$fmi" -o "$folder/$kind-$name-$fmi.fmu"
    done
done
cargo run --quiet --locked --manifest-path importers/fmi-rs/Cargo.toml -- "$folder"
