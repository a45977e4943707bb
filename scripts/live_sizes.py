#!/usr/bin/env python3
"""Whether this machine keeps what a size promises: the live trial of docs/choose/sizing.md.

  scripts/live_sizes.py PROGRAM ROUNDS [--rate "1 %"] [--record SECONDS] [--busy] [--exact]

Each round records scenarios/live/sized.toml (60 s by default), sizes the recording for its next two minutes (--per "2 min",
with --rate if given), and where that gives a promise runs the scenario for two minutes with its latency and lead. Where it
is refused, nothing is run; with --exact the scenario runs with the exact size, for which nobody vouches. --busy keeps
every core busy meanwhile. A row a round: the latency, the share of late segments, and whether the promise was kept.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

SCENARIO = pathlib.Path(__file__).resolve().parent.parent / "scenarios/live/sized.toml"


def read(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        sys.exit(f"{' '.join(map(str, command))}: exit {done.returncode}\n{done.stderr}")
    return done.stdout


def a_round(options, folder):
    """(latency in ns, share of late segments or None, what became of the promise)"""
    recording = folder / "now.csv"
    read(options.program, "record", SCENARIO, "-o", recording, "--seconds", options.record)
    rate = ["--rate", options.rate] if options.rate else []
    size = json.loads(read(options.program, "size", recording, "--emission", "linear", "--per", "2 min", *rate, "--json"))
    found = size["strategies"]["phase_locked"]
    promise = found["per"]
    refused = promise.get("refused")
    latency, lead = (found["latency_any_phase_ns"], found["lead_ns"]) if refused else (promise["latency_ns"], promise["lead_ns"])
    if refused and not options.exact:
        return latency, None, f"refused: {refused}"
    read(options.program, "run", "--clock", "wall", SCENARIO, "--out", folder / "run", "--set", f'remap.latency="{latency} ns"',
         "--set", f'remap.lead="{lead} ns"')
    summary = json.loads((folder / "run/summary.json").read_text(encoding="utf-8"))
    late = summary["metrics"]["left.buffers.phase_locked"]["underrun_rate"]
    if refused:
        return latency, late, f"refused: {refused}; run with the exact size"
    return latency, late, "kept" if late <= promise["rate"] else "broken"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("rounds", type=int)
    parser.add_argument("--rate")
    parser.add_argument("--record", default="60")
    parser.add_argument("--busy", action="store_true")
    parser.add_argument("--exact", action="store_true")
    options = parser.parse_args()
    load = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(os.cpu_count() if options.busy else 0)]
    try:
        with tempfile.TemporaryDirectory(prefix="evenstep sizes ") as place:
            rows = []
            for number in range(1, options.rounds + 1):
                rows.append(a_round(options, pathlib.Path(place)))
                latency, late, how = rows[-1]
                share = "-" if late is None else f"{100 * late:.3g} %"
                print(f"| {number} | {latency / 1e6:.3f} ms | {share} | {how} |", flush=True)
        promised = [how for _, _, how in rows if how in ("kept", "broken")]
        print(f"{promised.count('kept')} of {len(promised)} promises kept, {len(rows) - len(promised)} refused")
    finally:
        for one in load:
            one.kill()


main()
