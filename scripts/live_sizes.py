#!/usr/bin/env python3
"""Whether this machine keeps what a size promises: the live trial of docs/choose/sizing.md.

  scripts/live_sizes.py PROGRAM ROUNDS [--first N] [--rate "1 %"] [--record SECONDS] [--busy]

Each round records scenarios/live/sized.toml (60 s by default), sizes the recording for its next two minutes (--per "2 min",
with --rate if given), and where that gives a promise runs the scenario for two minutes with its latency and lead, and with
other drawings than those recorded. Where it is refused, nothing is run. --busy keeps every core busy meanwhile. A row a
round: the latency, how many of the 3600 segments were late, and whether the promise was kept. Rounds are numbered from N (1),
and draw what their number says, so that several of these scripts can run side by side.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

SCENARIO = pathlib.Path(__file__).resolve().parent.parent / "scenarios/live/sized.toml"
SEGMENTS = 3600  # in two minutes at 30 Hz


def read(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        sys.exit(f"{' '.join(map(str, command))}: exit {done.returncode}\n{done.stderr}")
    return done.stdout


def a_round(options, number, folder):
    """(latency in ns, late segments, what became of the promise); without a promise the first two are None"""
    recording = folder / "now.csv"
    read(options.program, "record", SCENARIO, "-o", recording, "--seconds", options.record,
         "--set", f"run.seed={2 * number}")
    rate = ["--rate", options.rate] if options.rate else []
    size = json.loads(read(options.program, "size", recording, "--emission", "linear", "--per", "2 min", *rate, "--json"))
    promise = size["strategies"]["phase_locked"]["per"]
    if "refused" in promise:
        return None, None, f"refused: {promise['refused']}"
    latency, lead = promise["latency_ns"], promise["lead_ns"]
    read(options.program, "run", "--clock", "wall", SCENARIO, "--out", folder / "run", "--set", f"run.seed={2 * number + 1}",
         "--set", f'remap.latency="{latency} ns"', "--set", f'remap.lead="{lead} ns"')
    summary = json.loads((folder / "run/summary.json").read_text(encoding="utf-8"))
    late = round(SEGMENTS * summary["metrics"]["left.buffers.phase_locked"]["underrun_rate"])
    return latency, late, "kept" if late <= round(SEGMENTS * promise["rate"]) else "broken"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("rounds", type=int)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--rate")
    parser.add_argument("--record", default="60")
    parser.add_argument("--busy", action="store_true")
    options = parser.parse_args()
    busy = os.cpu_count() if options.busy else 0
    load = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(busy)]
    try:
        with tempfile.TemporaryDirectory(prefix="evenstep sizes ") as place:
            rows = []
            for number in range(options.first, options.first + options.rounds):
                rows.append(a_round(options, number, pathlib.Path(place)))
                latency, late, how = rows[-1]
                shown = "- | -" if latency is None else f"{latency / 1e6:.3f} ms | {late}"
                print(f"| {number} | {shown} | {how} |", flush=True)
        promised = [how for _, _, how in rows if how in ("kept", "broken")]
        print(f"{promised.count('kept')} of {len(promised)} promises kept, {len(rows) - len(promised)} refused")
    finally:
        for one in load:
            one.kill()


main()
