#!/usr/bin/env python3
"""The tables of README.md and of docs/ whose figures a command gives, and that docs_test.py does not compare: the command
runs, and each cell must be what it gives, rounded as it is printed there.

    figures_test.py PROGRAM SOURCE_DIR BUILD_DIR            what takes less than a second a row
    figures_test.py PROGRAM SOURCE_DIR BUILD_DIR --long     the others; of the recordings a third, another one each day
    figures_test.py PROGRAM SOURCE_DIR BUILD_DIR --all      all rows
    figures_test.py ENGINES SOURCE_DIR BUILD_DIR --engines  of docs/parts/engines.md, with the program of tests/engines
"""
import csv
import datetime
import json
import re
import statistics
import subprocess
import sys
import tempfile
from functools import lru_cache
from pathlib import Path

PROGRAM, SOURCE, BUILD = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve(), Path(sys.argv[3]).resolve()
ALL = "--all" in sys.argv[4:]
LONG = ALL or "--long" in sys.argv[4:]
ENGINES = "--engines" in sys.argv[4:]
PLACE = tempfile.TemporaryDirectory(prefix="evenstep figures ")
SLOT_M = 0.1 / 450  # of the spring that scenarios/timing extends: the hand's way from one step to the next

problems, compared = [], 0


def output(*words):
    done = subprocess.run([PROGRAM, *words], cwd=PLACE.name, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        sys.exit(f"evenstep {' '.join(words)}: exit {done.returncode}\n{done.stderr[-2000:]}")
    return json.loads(done.stdout)


def printed(*words):
    """What another program than evenstep prints: one of the tests, or a script."""
    return subprocess.run([str(word) for word in words], cwd=SOURCE, capture_output=True, text=True, check=True).stdout


@lru_cache(maxsize=None)
def metrics(scenario, *sets):
    return output("run", str(SOURCE / "scenarios" / (scenario + ".toml")), "--json",
                  *(word for one in sets for word in ("--set", one)))["metrics"]


@lru_cache(maxsize=None)
def size(recording, *options):
    ending = "" if "." in recording else ".csv"
    return output("size", str(SOURCE / "scenarios/recorded" / (recording + ending)), "--json", *options)


def worst(scenario, signal, strategy, metric, *sets):
    """The largest of all devices; None if it is infinite."""
    values = [values[metric] for name, values in metrics(scenario, *sets).items()
              if re.fullmatch(rf"\w+\.{signal}\.{strategy}", name)]
    return None if None in values else max(values)


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
    """`cell` has numbers among its words; `values` are (value, unit), as many as there are numbers or the first of them."""
    global compared
    numbers = re.findall(r"(?<![\w.])\d[\d.]*(?:e-?\d+)?(?!\w)", cell)
    if len(numbers) < len(values):
        problems.append(f"{page}: '{row}', {what}: {len(values)} numbers are expected in '{cell}'")
    for number, (value, unit) in zip(numbers, values):
        compared += 1
        if not same(number, value, unit):
            problems.append(f"{page}: '{row}', {what}: {number}, and the command gives {value / unit:.4g}")


def said(page, expression, *values):
    """The groups of the expression are the numbers of a sentence; `values` are (value, unit)."""
    found = re.search(expression, " ".join((SOURCE / page).read_text(encoding="utf-8").split()))
    if found is None:
        problems.append(f"{page}: does not say '{expression}'")
    for number, value in zip(found.groups() if found else (), values):
        compare(page, found[0], "in the sentence", number, [value])


def table_after(lines, beginning, whole=False):
    """(head, {first cell: all cells}) of the first table below the line that begins so, or that is this `whole` one."""
    at = next((i for i, line in enumerate(lines) if (line == beginning if whole else line.startswith(beginning))), None)
    at = next((i for i, line in enumerate(lines) if at is not None and i > at and line.startswith("|")), None)
    if at is None:
        sys.exit(f"no table below '{beginning}'")
    found = []
    while at < len(lines) and lines[at].startswith("|"):
        found.append([cell.strip() for cell in lines[at].strip("|").split("|")])
        at += 1
    return found[0], {line[0]: line for line in found[2:]}


def compare_printed(page, text, places):
    """The page's tables are parts of those that a command prints: the same words in the same row and column. `places` maps
    how the line before the page's table begins to the line before the printed one."""
    global compared
    lines = (SOURCE / page).read_text(encoding="utf-8").split("\n")
    for on_page, in_text in places.items():
        head, table = table_after(lines, on_page)
        printed_head, printed_table = table_after(text.split("\n"), in_text, whole=True)
        for first, cells in table.items():
            for name, cell in zip(head[1:], cells[1:]):
                compared += 1
                there = first in printed_table and name in printed_head
                now = printed_table[first][printed_head.index(name)] if there else "nothing"
                if cell != now:
                    problems.append(f"{page}: '{first}', {name}: {cell}, and the command gives {now}")


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


def is_its_day(number):
    return ALL or (number + datetime.date.today().toordinal()) % 3 == 0


def recorded_timing():
    page = "README.md"
    for number, (row, cells) in enumerate(rows(page, "| recording | direct | paper | phase_locked |").items()):
        if not is_its_day(number):
            continue
        scenario = "recorded/" + row.split()[0]
        for strategy, cell in zip(("direct", "paper", "phase_locked"), cells):
            compare(page, row, strategy, cell, [(worst(scenario, "interaction", strategy, "velocity_jump"), 1e-6),
                                                (worst(scenario, "force", strategy, "jump_max"), 1e-3)])


def latency_of(scenario, strategy):
    """What the table of a run has in its column of that name."""
    return worst(scenario, "buffers", strategy, "played_age" if strategy == "direct" else "latency"), 1e-3


def fitted_models():
    page = "docs/timings/timing.md"
    for row, cells in rows(page, "| recording | 250 ms, p50 | 250 ms, p99 | whole | phase_locked |").items():
        needs = output("fit", str(SOURCE / f"scenarios/recorded/{row}.csv"), "--json")["latency"]
        for need, cell in zip(("window_p50_ns", "window_p99_ns", "whole_ns", "phase_locked_ns"), cells):
            compare(page, row, need, cell, [(needs["recording"][need], 1e6)] + [
                (statistics.median(one[need] for one in needs[kind]), 1e6) for kind in ("model", "shuffled")])


def two_commands():
    """What ./run.sh prints of figure 1, in a block of text."""
    page, columns = "README.md", (("interaction", "velocity_jump", 1e-6), ("force", "jump_max", 1e-3), ("force", "late", 1),
                                  ("interaction", "underruns", 1), ("force", "saturated", 1))
    lines = re.findall(r"^(ideal|direct|paper|phase_locked) +~?(\d.*)$", (SOURCE / page).read_text(encoding="utf-8"),
                       re.MULTILINE)
    if len(lines) != 4:
        problems.append(f"{page}: {len(lines)} of 4 strategies")
    for strategy, line in lines:
        compare(page, "./run.sh", strategy, line, [latency_of("paper/figure-1", strategy)] +
                [(worst("paper/figure-1", signal, strategy, metric), unit) for signal, metric, unit in columns])


def reference_case():
    page, spring, step_N = "README.md", "paper/figure-1-spring", 200 * SLOT_M
    table = rows(page, "| | direct | remapped |")
    for row, scenario, signal, metric, of_direct, of_maps in (
            ("interaction, velocity jump", spring, "interaction", "velocity_jump", SLOT_M, SLOT_M),
            ("force at the device's ticks, linear emission, velocity jump", spring, "force", "velocity_jump", step_N, None),
            ("tissue, force against the ideal twin, worst device", "paper/figure-1", "force", "deviation_from_ideal", 1e-3,
             1e-6),
            ("tissue, largest force change from one tick to the next", "paper/figure-1", "force", "jump_max", 1e-3, 1e-3)):
        if scenario != spring and not LONG:
            continue
        direct, maps = table[row]
        compare(page, row, "direct", direct, [(worst(scenario, signal, "direct", metric), of_direct)])
        found = [(worst(scenario, signal, strategy, metric), of_maps) for strategy in ("phase_locked", "paper")]
        if of_maps is None:
            if max(value for value, _ in found) > 1e-11 * of_direct:
                problems.append(f"{page}: '{row}': more than rounding is left: {found}")
        elif "(paper)" in maps:  # a number for each
            compare(page, row, "both maps", maps, found)
        else:
            for one in found:
                compare(page, row, "both maps", maps, [one])
    needs = [output("size", str(SOURCE / "scenarios/paper" / (name + ".toml")), "--json")["strategies"]["phase_locked"]
             ["latency_any_phase_ns"] for name in ("figure-1-spring-hold", "figure-1-spring")]
    compare(page, "least latency", "held, interpolated", table["least latency from hand to force"][1],
            [(one, 1e6) for one in needs])


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
    said(page, r"Whatever knows the past only needs (\S+) ms there at the same jump",
         (size("concurrent-paced30-basic-sub9")["strategies"]["phase_locked"]["pauses_bound_at_this_jump_ns"], 1e6))


def gpu_of_today():
    page, render, spread = "README.md", "recorded/h100-render", "recorded/h100-render-spread"
    runs = {"direct": (render, "direct"), "remapped": (render, "phase_locked"),
            "steps spread, and remapped": (spread, "phase_locked")}
    for row, cells in rows(page, "| | latency | jump of hand | jump of force |").items():
        scenario, strategy = runs[row]
        wanted = (("latency", *latency_of(scenario, strategy)),
                  ("jump of hand", worst(scenario, "interaction", strategy, "velocity_jump"), 1e-6),
                  ("jump of force", worst(scenario, "force", strategy, "jump_max"), 1e-3))
        for (what, value, unit), cell in zip(wanted, cells):
            compare(page, row, what, cell, [(value, unit)])


def stiffness():
    """The page's tables are parts of those that the script prints: the same words in the same row and column."""
    global compared
    page = "docs/forces/stiffness.md"
    names = ("spring", "device", "quality", "lattice-error", "slide-error", *(("delay", "mode", "lattice") if ALL else ()))
    text = printed(sys.executable, "bench/stiffness_tables.py", PROGRAM, *names)
    lines_of_page = (SOURCE / page).read_text(encoding="utf-8").split("\n")
    for table in re.findall(r"^\|.*\n\|[-|]+\|\n(?:\|.*\n)+", text, re.MULTILINE):
        header, _, *lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
        # Where the first columns of several rows are the same, the first two name one.
        keys = 2 if len({line[0] for line in lines}) < len(lines) else 1
        printed_now = {tuple(line[:keys]): line for line in lines}
        heading = "| " + header[0] + " |" if header[0] else "| | " + header[1] + " |"
        columns = range(keys, len(header))
        shown = [cell.strip() for line in lines_of_page if line.startswith(heading) for cell in line.strip("|").split("|")]
        if len(shown) < len(header) and set(shown) <= set(header):
            columns = [header.index(name) for name in shown[keys:]]
        for first, cells in rows(page, heading, keys).items():
            line = printed_now.get(first)
            if line is None:
                problems.append(f"{page}: '{first}': no such row is printed")
                continue
            compared += len(cells)
            problems.extend(f"{page}: '{first}': {cell}, and the command gives {now}"
                            for cell, now in zip(cells, (line[column] for column in columns)) if cell != now)


def three_dimensions():
    """The page against its CSV; with --all the CSV against searches of now, three minutes of processor time."""
    global compared
    page, script, file = "docs/forces/stiffness.md", SOURCE / "bench/stiffness_3d.py", SOURCE / "docs/forces/stiffness-3d.csv"
    renders = ("force", "local, instantaneous", "local, settled")
    head, table = table_after(["", *printed(sys.executable, script, "tables", file).split("\n")], "")
    for row, cells in rows(page, "| scene | `force` | `local` instantaneous |").items():
        line = table[row.split(",")[0]]
        for render, cell in zip(renders, cells):
            compared += 1
            now = line[head.index(f"{render}, phase_locked")]
            if cell != now:
                problems.append(f"{page}: '{row}', {render}: {cell}, and {file.name} has {now}")
    with open(file, encoding="utf-8") as lines:
        held = list(csv.DictReader(lines))

    def bears(scene, render, column="N_per_m_of_a_spring", strategy="phase_locked"):
        return next((float(one[column]), 1) for one in held
                    if (one["scene"], one["render"], one["strategy"]) == (scene, render, strategy))

    near, apart = "hands side by side", "hands 48 mm apart"
    said(page, r"the lumps side by side bear k = (\S+) instead of (\S+), and 48 mm apart (\S+) instead of (\d+)",
         bears(near, "local, settled, coupled"), bears(near, "local, settled"), bears(apart, "local, settled, coupled"),
         bears(apart, "local, settled"))
    said(page, r"the coupling adds little \((\S+) instead of (\d+)\)", bears(near, "local, instantaneous, coupled"),
         bears(near, "local, instantaneous"))
    said(page, r"the diagonal of K alone bears k = (\d+), and the whole matrix (\d+)", bears("corner", "local, settled, axes only"),
         bears("corner", "local, settled"))
    said(page, r"along the normal alone it bears (\d+) N/m instead of (\d+)",
         bears("probe", "local, settled, normal only", "N_per_m_at_the_tool"),
         bears("probe", "local, settled", "N_per_m_at_the_tool"))
    said(page, r"raw and remapped: `force` (\S+) and (\S+), `local` settled (\S+) and (\d+), along the normal alone (\S+) and "
         r"(\d+)", *(bears("sliding", render, "N_per_m_at_the_tool", strategy)
                     for render in ("force", "local, settled", "local, settled, normal only")
                     for strategy in ("direct", "phase_locked")))
    if ALL:
        now = Path(PLACE.name) / "now.csv"
        printed(sys.executable, script, "run", PROGRAM, now)
        with open(now, encoding="utf-8") as lines:
            fresh = list(csv.DictReader(lines))
        compared += len(fresh)
        problems.extend(f"{file.name} has {old}, and a search of now gives {new}" for old, new in zip(held, fresh) if old != new)
        if len(held) != len(fresh):
            problems.append(f"{file.name} has {len(held)} rows, and searches of now give {len(fresh)}")


def price_of_the_remap():
    page = "docs/forces/study.md"
    table = rows(page, "| scene, hand | direct | phase_locked |")
    for row, sets in (("spring, A", []),
                      ("spring, H", ['device.left.motion.arm={ mass = "0.554 kg", damping = "6.45 N s/m", '
                                             'stiffness = "135 N/m" }']),
                      ("spring, A, hold emission", ['device.left.render={ kind = "force", emission = "hold" }'])):
        limits = output("study", str(SOURCE / "scenarios/closed-loop/price-study.toml"), "--json", "--out", "price",
                        *(word for one in sets for word in ("--set", one)))["limits"]
        stable = {one["strategy"]: one["stable_N_per_m"] for one in limits}
        for strategy, cell in zip(("direct", "phase_locked"), table[row]):
            compare(page, row, strategy, cell, [(stable[strategy], 1)])


def shorter_pauses():
    compare_printed("docs/choose/pauses.md", printed(sys.executable, "scripts/pauses.py", PROGRAM), {
        "Least latency of phase_locked": "Least latency of phase_locked, ms", "Drawings a second;": "Drawings a second",
        "Longest time without a drawing": "Longest time without a drawing, ms",
        "Simulated over real time;": "Simulated over real time"})


def other_sources():
    global compared
    page, text = "docs/choose/sources.md", printed(BUILD / "tests/sources/test_sources", "[.table]")
    compare_printed(page, text, {f"`{name}.toml`": name for name in ("slower-clean", "slower", "chunks", "drifting-clock")})
    wakes = [table_after(text.split("\n"), "wake-" + name, whole=True)
             for name in ("absolute-grid", "from-last-update", "catch-up")]
    for strategy, cells in rows(page, "| strategy | latency `absolute-grid` |").items():
        now = [table[strategy][head.index(column)] for column in ("latency, ms", "animation error, ms")
               for head, table in wakes]
        compared += len(now)
        if cells != now:
            problems.append(f"{page}: '{strategy}' of the wakes: {cells}, and the command gives {now}")


def loops():
    page = "docs/timings/loops.md"
    found = re.findall(r"clocked slew +(\S+) ms (\S+) +jump +(\S+) ms (\S+) +phase_locked +(\S+) ms (\S+)",
                       printed(BUILD / "tests/scheduler_timing/test_loops", "[.print-loops]"))
    table = rows(page, "| frames, steps | `clocked` | `phase_locked` |")
    if len(found) != len(table):
        problems.append(f"{page}: {len(table)} rows, and the command gives {len(found)}")
    for (row, (clocked, locked)), numbers in zip(table.items(), found):
        slew, slew_jump, at_once, at_once_jump, needs, jump = ((float(number), 1) for number in numbers)
        compare(page, row, "clocked", clocked, [slew] if slew_jump[0] == 0 else [slew, slew_jump, at_once, at_once_jump])
        compare(page, row, "phase_locked", locked, [needs, jump])


def recovery():
    page = "docs/timings/recovery.md"
    units = {"s": 1, "ms": 1e-3}
    kinds = ("recovery_time", "recovery_time_underruns", "recovery_time_latency", "recovery_time_jump")
    for (row, strategy), cells in rows(page, "| scenario | strategy | `recovery_time`", 2).items():
        for kind, cell in zip(kinds, cells):
            value = worst(row, "force", strategy, kind)
            if value is None or cell == "never":
                compare(page, row, kind, "1" if cell == "never" else "0", [(0 if value is not None else 1, 1)])
            else:
                compare(page, row, kind, cell, [(value, units[(cell.split() + ["s"])[1]])])


def adaptive_latency():
    page = "docs/choose/sizing.md"
    for row, cells in rows(page, "| scenario | fixed, nothing late | adaptive").items():
        scenario = "timing/" + row.split()[0]
        def of(metric, *sets):
            return worst(scenario, "force", "phase_locked", metric, *sets)
        mean, fixed = of("schedule_latency_mean"), of("schedule_latency", "remap.latency=minimal")
        compare(page, row, "fixed", cells[0], [(fixed, 1e-3)])
        if row == "latency-adaptive-constant":  # "the same to 1 ns", "none"
            if max(abs(mean - fixed), of("schedule_latency") - mean) > 1.5e-9 or of("late") != 0:
                problems.append(f"{page}: '{row}': {mean}, and not {fixed} throughout")
            continue
        compare(page, row, "adaptive", cells[1],
                [(mean, 1e-3), (of("schedule_latency_p50"), 1e-3), (of("schedule_latency"), 1e-3)])
        compare(page, row, "late", cells[2], [(of("late"), 1)])
        compare(page, row, "late if fixed", cells[3], [(of("late", f"remap.latency={round(mean * 1e9)} ns"), 1)])


def sine_at_the_device():
    page = "docs/choose/alternatives.md"
    filters = {"One-Euro, min_cutoff 1 Hz, beta 1, on the force":
               ['remap.filter={ kind = "one-euro", on = "force" }', "expect=[]"]}
    for row, cells in rows(page, "| strategy | gain at 1, 5, 10 Hz").items():
        strategy = re.match(r"`(\w+)`", row)
        for metric, cell, unit in zip(("gain", "phase_delay", "distortion"), cells, (1, 1e-3, 1e-2)):
            compare(page, row, metric, cell,
                    [(worst(f"timing/sine-{hertz}", "force", strategy[1] if strategy else "filtered", metric,
                            *filters.get(row, [])), unit) for hertz in (1, 5, 10)])


def other_maps():
    page = "docs/choose/alternatives.md"
    columns = [("paper", []), ("phase_locked", []), ("jack_dll", []), ("lsl_dejitter", []),
               ("jack_dll", ["--set", 'remap.bandwidth="0.125 Hz"']),
               ("lsl_dejitter", ["--set", 'remap.bandwidth="0.0077 Hz"'])]
    for number, (row, cells) in enumerate(rows(page, "| recording | `paper` | `phase_locked` | `jack_dll`, 2 Hz").items()):
        for cell, (name, sets) in zip(cells, columns) if is_its_day(number) else ():
            one = size(row + ".toml", "--other-maps", *sets)["strategies"][name]
            compare(page, row, name, cell, [(one["latency_any_phase_ns"], 1e6), (one["velocity_jump"], 1)])


def growth_rates():
    """How often a series of a known kind gets its name."""
    page, found = "docs/reference/metrics.md", {}
    for kind, named, falsely in re.findall(r"^(\S.*?) +\d+ bins: .*?named +(\S+) %, falsely +(\S+) %",
                                           printed(BUILD / "tests/reports/test_reports", "[.rates]"), re.MULTILINE):
        found.setdefault(kind, []).append((float(named), float(falsely)))
    for row, (_, named, falsely) in rows(page, "| error | is | named: 20, 60, 119 bins |").items():
        compare(page, row, "named", named, [(one, 1) for one, _ in found[row]])
        compare(page, row, "falsely", falsely, [(one, 1) for _, one in found[row]])


def ages():
    page, unit = "docs/devices/ages.md", 0.01 / 450
    for heading, row, scenario in (
            ("| | time of the read | time at which", "one clock: deviation from the line, velocity jump", "report-ages"),
            ("| | time of the read | time at which", "the device's clock gains 100 ppm, after 45 s", "report-ages-clock"),
            ("| | time of the read | time of the event", "deviation from the line, velocity jump", "event-times")):
        for device, cell in zip(("arrival", "left"), rows(page, heading)[row]):
            found = metrics("timing/" + scenario)[f"{device}.interaction.phase_locked"]
            compare(page, row, device, cell, [(found["deviation_max"], unit), (found["velocity_jump"], unit)])


def in_newtons(page, row, what, cell, values):
    """`cell` ends with its unit; `values` in N."""
    compare(page, row, what, cell, [(value, {"N": 1, "mN": 1e-3, "uN": 1e-6}[cell.split()[-1]]) for value in values])


def engines():
    page, scenarios = "docs/parts/engines.md", SOURCE / "tests/engines"
    scenes = {"MuJoCo, body on sliders, weld": "mujoco-tool", "Bullet, body on a spring, 6-DoF spring": "bullet-tool",
              "MuJoCo, hook of eight links on ball joints": "mujoco-rod", "Bullet, cloth (`btSoftBody`) lifted in its middle":
              "bullet-soft", "MuJoCo, soft box on a floor, pressed by a ball": "mujoco-box"}
    for row, (_, *cells) in rows(page, "| scene | hand | direct | remapped |").items():
        found = output("run", str(scenarios / (scenes[row] + ".toml")), "--json")["metrics"]
        remapped = found["left.force.phase_locked"]
        for what, cell, value in zip(("direct", "remapped", "minus ideal"), cells,
                                     (found["left.force.direct"]["velocity_jump"], remapped["velocity_jump"],
                                      remapped["deviation_from_ideal"])):
            in_newtons(page, row, what, cell, [value])
    scenes = {"MuJoCo, tool": "mujoco-tool", "MuJoCo, hook": "mujoco-rod", "MuJoCo, box": "mujoco-box",
              "Bullet, tool": "bullet-tool", "Bullet, cloth": "bullet-soft"}
    for row, (scale, direct, *remapped) in rows(page, "| scene | force rms | direct, whatever the step |").items():
        found = output("study", str(scenarios / (scenes[row] + ".toml")), "--json", "--out", "study", *(
            word for one in ('run.duration="1 s"', 'run.strategies=["direct", "phase_locked"]', "study.repeats=1", "expect=[]",
                             'study.step_sizes=["450 Hz", "900 Hz", "1800 Hz"]') for word in ("--set", one)))
        errors = {name: [one["total"]["rms_N"] for one in found["points"] if one["strategy"] == name]
                  for name in ("direct", "phase_locked")}
        in_newtons(page, row, "force", scale, [found["reference"]["scale_N"]])
        in_newtons(page, row, "direct", direct, [min(errors["direct"]), max(errors["direct"])])
        for what, cell, value in zip(("2.22 ms", "0.56 ms"), remapped, errors["phase_locked"][::2]):
            in_newtons(page, row, what, cell, [value])


def in_sentences():
    """Figures outside of tables."""
    def of(scenario, signal, metric, unit, *strategies):
        return [(worst(scenario, signal, strategy, metric), unit) for strategy in strategies]

    jump = ("interaction", "velocity_jump", SLOT_M)
    said("docs/choose/paper.md", r"10 % jitter makes jumps of (\S+) steps",
         *of("timing/no-visualization-jitter", *jump, "direct"))
    said("docs/choose/paper.md", r"the jump is then (\S+) \((\S+) without a map, (\S+) with `paper`\)",
         *of("timing/no-cycle", *jump, "phase_locked", "direct", "paper"))
    said("docs/choose/paper.md", r"\| (\S+) ms: one visualization and the lead.*?the mean age is (\S+) ms",
         *of("paper/figure-1-spring", "interaction", "latency_max", 1e-3, "paper"),
         *of("paper/figure-1-spring", "interaction", "latency_mean", 1e-3, "paper"))
    needs = output("size", str(SOURCE / "scenarios/timing/hitch.toml"), "--json")["strategies"]["phase_locked"]
    said("docs/choose/paper.md", r"requires a latency of (\S+) ms", (needs["latency_any_phase_ns"], 1e6))
    page, latency = "docs/choose/pauses.md", ("buffers", "latency", 1e-3)
    said(page, r"as they are: (\S+) and (\S+) ms", *of("pauses/regime", *latency, "phase_locked"),
         *of("pauses/contended", *latency, "phase_locked"))
    said(page, r"small-paced30-basic, spread: (\S+) ms", *of("pauses/small-spread", *latency, "phase_locked"))
    said(page, r"in two parts: (\S+) ms, no drawing lost", *of("pauses/regime-split", *latency, "phase_locked"))
    for budget, scenario in ((21, "pauses/regime-merge"), (31, "pauses/contended-merge")):
        said(page, rf"with {budget} ms for each: (\S+) ms, (\S+) drawings a second", *of(scenario, *latency, "phase_locked"),
             (metrics(scenario)["solver.phase_locked"]["drawing_rate"], 1))
    page = "docs/choose/alternatives.md"
    said(page, r"the force jumps by (\S+) mN from tick to tick, compared with (\S+) mN for `direct` and (\S+) mN for",
         *of("timing/variable-step-substeps", "force", "jump_max", 1e-3, "variable_step", "direct", "phase_locked"))
    said(page, r"(\S+) ms with `paper` and (\S+) ms with `phase_locked` in 12 s",
         *of("timing/gate", "buffers", "gate_wait", 1e-3, "paper", "phase_locked"))
    said(page, r"\| `direct` \| (\S+) mm \|.*?`predict` \| (\S+) mm.*?Butterworth 10 Hz on the interaction \| (\S+) mm",
         *of("timing/dead-stop", "interaction", "error_at_stop", 1e-3, "direct", "predict", "filtered"))


if ENGINES:
    engines()
else:
    irregular_timing()
    reference_case()
if LONG:
    stiffness()
    price_of_the_remap()
    recorded_timing()
    two_commands()
    other_maps()
if ALL or not (LONG or ENGINES):
    what_it_reaches()
    fitted_models()
    gpu_of_today()
    shorter_pauses()
    other_sources()
    loops()
    recovery()
    adaptive_latency()
    sine_at_the_device()
    ages()
    three_dimensions()
    in_sentences()
if ALL:
    growth_rates()
if compared < 3:
    problems.append("no figure was compared")
print("\n".join(problems) or f"ok: {compared} figures")
sys.exit(1 if problems else 0)
