#!/usr/bin/env python3
"""The tables of README.md, docs/choose/numerics.md, docs/forces/stiffness.md and docs/forces/study.md whose figures a command
gives: the command runs, and each cell must be what it gives, rounded as it is printed there.

    figures_test.py PROGRAM SOURCE_DIR            what takes less than a second a row
    figures_test.py PROGRAM SOURCE_DIR --long     the others, of the recordings those whose day it is: each third day
    figures_test.py PROGRAM SOURCE_DIR --all      all rows
"""
import datetime
import json
import re
import subprocess
import sys
import tempfile
from functools import lru_cache
from pathlib import Path

PROGRAM, SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
ALL = "--all" in sys.argv[3:]
LONG = ALL or "--long" in sys.argv[3:]
PLACE = tempfile.TemporaryDirectory(prefix="evenstep figures ")
SLOT_M = 0.1 / 450  # of the spring that scenarios/timing extends: the hand's way from one step to the next

problems, compared = [], 0


def output(*words):
    done = subprocess.run([PROGRAM, *words], cwd=PLACE.name, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        sys.exit(f"evenstep {' '.join(words)}: exit {done.returncode}\n{done.stderr[-2000:]}")
    return json.loads(done.stdout)


@lru_cache(maxsize=None)
def metrics(scenario):
    return output("run", str(SOURCE / "scenarios" / (scenario + ".toml")), "--json")["metrics"]


@lru_cache(maxsize=None)
def size(recording):
    return output("size", str(SOURCE / "scenarios/recorded" / (recording + ".csv")), "--json")


def worst(scenario, signal, strategy, metric):
    """The largest of all devices."""
    return max(values[metric] for name, values in metrics(scenario).items()
               if re.fullmatch(rf"\w+\.{signal}\.{strategy}", name))


def same(cell, value, unit):
    """Whether the number of the cell is this one, to the digits that it has."""
    number = re.match(r"[0-9.]+(?:e-?\d+)?", cell)
    if number is None:
        return False
    mantissa, _, exponent = number[0].partition("e")
    decimals = len(mantissa.partition(".")[2])
    place = 10.0 ** (int(exponent or 0) - decimals)
    if decimals == 0 and len(mantissa) > 3 and mantissa.endswith("0"):
        place *= 10
    return abs(float(number[0]) - value / unit) <= 0.5000001 * place


def rows(page, heading, keys=0):
    """{first cell: other cells} of the table whose head begins with this; with `keys` {tuple of the first ones: others}."""
    lines = (SOURCE / page).read_text(encoding="utf-8").split("\n")
    at = next((i for i, line in enumerate(lines) if line.startswith(heading)), None)
    if at is None:
        sys.exit(f"{page}: no table begins with '{heading}'")
    found = {}
    while lines[at + 2].startswith("|"):
        cells = [cell.strip() for cell in lines[at + 2].strip("|").split("|")]
        found[tuple(cells[:keys]) if keys else cells[0]] = cells[max(keys, 1):]
        at += 1
    return found


def compare(page, row, what, cell, values):
    """`cell` has numbers, with a comma between them; `values` are (value, unit)."""
    global compared
    numbers = [part.strip() for part in cell.split(", ")]
    if len(numbers) < len(values):
        problems.append(f"{page}: '{row}', {what}: {len(values)} numbers are expected in '{cell}'")
    for number, (value, unit) in zip(numbers, values):
        compared += 1
        if not same(number, value, unit):
            problems.append(f"{page}: '{row}', {what}: {number}, and the command gives {value / unit:.4g}")


def irregular_timing():
    page = "README.md"
    scenarios = {"1 % jitter": "jitter-1", "10 % jitter": "jitter-10", "10 % jitter, ten minutes": "ten-minutes-jitter",
                 "segments grow by 10 % a second": "drift", "paced by a timer, 10 % jitter": "paced",
                 "visualization switches between two lengths, a factor of 1.6 apart": "regimes", "spikes of 4 ms": "spikes"}
    for row, cells in rows(page, "| timing | direct | paper | phase_locked |").items():
        scenario = scenarios[row]  # a new row needs its scenario here
        if (scenario == "ten-minutes-jitter") != LONG:
            continue
        for strategy, cell in zip(("direct", "paper", "phase_locked"), cells):
            jump = worst("timing/" + scenario, "interaction", strategy, "velocity_jump")
            compare(page, row, strategy, cell, [(jump, SLOT_M)])


def recorded_timing():
    page = "README.md"
    today = datetime.date.today().toordinal()
    for number, (row, cells) in enumerate(rows(page, "| recording | direct | paper | phase_locked |").items()):
        if not ALL and (number + today) % 3:
            continue
        scenario = "recorded/" + row.split()[0]
        for strategy, cell in zip(("direct", "paper", "phase_locked"), cells):
            compare(page, row, strategy, cell, [(worst(scenario, "interaction", strategy, "velocity_jump"), 1e-6),
                                                (worst(scenario, "force", strategy, "jump_max"), 1e-3)])


def reference_case():
    page = "README.md"
    table = rows(page, "| | direct | remapped |")
    for row, scenario, metric, of_direct, of_maps in (
            ("tissue, force against the ideal twin, worst device", "paper/figure-1", "deviation_from_ideal", 1e-3, 1e-6),
            ("tissue, largest force change from one tick to the next", "paper/figure-1", "jump_max", 1e-3, 1e-3)):
        direct, maps = table[row]
        compare(page, row, "direct", direct, [(worst(scenario, "force", "direct", metric), of_direct)])
        for strategy in ("paper", "phase_locked"):
            compare(page, row, strategy, maps, [(worst(scenario, "force", strategy, metric), of_maps)])


def what_it_reaches():
    page = "docs/choose/numerics.md"
    for row, cells in rows(page, "| recording | pause bound | any path").items():
        sized = size(row)
        any_path = next(path["latency_ns"] for path in sized["any_path"] if path["velocity_jump"] == 0.15)
        maps = [sized["strategies"][name] for name in ("paper", "phase_locked")]
        wanted = [[(sized["pause_bound_ns"], 1e6)], [(any_path, 1e6)],
                  *[[(one["latency_any_phase_ns"], 1e6), (one["velocity_jump"], 1)] for one in maps],
                  [(maps[1]["latency_any_phase_ns"] / sized["pause_bound_ns"], 1)]]
        for what, cell, values in zip(("pause bound", "any path", "paper", "phase_locked", "times"), cells, wanted):
            compare(page, row, what, cell, values)


def gpu_of_today():
    page, render, spread = "README.md", "recorded/h100-render", "recorded/h100-render-spread"
    runs = {"direct": (render, "direct"), "remapped": (render, "phase_locked"),
            "steps spread, and remapped": (spread, "phase_locked")}
    for row, cells in rows(page, "| | latency | jump of hand | jump of force |").items():
        scenario, strategy = runs[row]
        latency = "played_age" if strategy == "direct" else "latency"
        wanted = (("latency", worst(scenario, "buffers", strategy, latency), 1e-3),
                  ("jump of hand", worst(scenario, "interaction", strategy, "velocity_jump"), 1e-6),
                  ("jump of force", worst(scenario, "force", strategy, "jump_max"), 1e-3))
        for (what, value, unit), cell in zip(wanted, cells):
            compare(page, row, what, cell, [(value, unit)])


def stiffness():
    """The page's tables are parts of those that the script prints: the same words in the same row and column."""
    global compared
    page = "docs/forces/stiffness.md"
    names = ("spring", "device", "quality")
    printed = subprocess.run([sys.executable, str(SOURCE / "bench/stiffness_tables.py"), PROGRAM, *names], cwd=SOURCE,
                             capture_output=True, text=True, check=True).stdout
    for table in re.findall(r"^\|.*\n\|[-|]+\|\n(?:\|.*\n)+", printed, re.MULTILINE):
        header, _, *lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
        # Where the first columns of several rows are the same, the first two name one.
        keys = 2 if len({line[0] for line in lines}) < len(lines) else 1
        said = {tuple(line[:keys]): line for line in lines}
        for first, cells in rows(page, "| " + header[0] + " |", keys).items():
            line = said.get(first)
            if line is None:
                problems.append(f"{page}: '{first}': no such row is printed")
                continue
            compared += len(cells)
            problems.extend(f"{page}: '{first}': {cell}, and the command gives {now}"
                            for cell, now in zip(cells, line[keys:]) if cell != now)


def price_of_the_remap():
    page = "docs/forces/study.md"
    table = rows(page, "| scene, hand | direct | phase_locked |")
    for row, sets in (("spring or wall, A", []),
                      ("spring or wall, H", ['device.left.motion.arm={ mass = "0.554 kg", damping = "6.45 N s/m", '
                                             'stiffness = "135 N/m" }']),
                      ("spring, A, hold emission", ['device.left.render={ kind = "force", emission = "hold" }'])):
        limits = output("study", str(SOURCE / "scenarios/closed-loop/price-study.toml"), "--json", "--out", "price",
                        *(word for one in sets for word in ("--set", one)))["limits"]
        stable = {one["strategy"]: one["stable_N_per_m"] for one in limits}
        for strategy, cell in zip(("direct", "phase_locked"), table[row]):
            compare(page, row, strategy, cell, [(stable[strategy], 1)])


irregular_timing()
if LONG:
    stiffness()
    price_of_the_remap()
    recorded_timing()
    reference_case()
else:
    what_it_reaches()
    gpu_of_today()
if compared < 3:
    problems.append("no figure was compared")
print("\n".join(problems) or f"ok: {compared} figures")
sys.exit(1 if problems else 0)
