"""The tables of docs/forces/stiffness.md (some have fewer rows and columns there), and others like them, computed anew.

stiffness_tables.py EVENSTEP [TABLE ...]          prints them; without a name all of them (some minutes of CPU time)
stiffness_tables.py EVENSTEP --into PAGE TABLE ...  puts them in the place of those of the page that begin with the same line

TABLE: spring, delay, device, mode, quality, lattice, lattice-error, lattice-ripple, block-sine, slide-error, sliding,
sliding-swing, sliding-laws. A search is one `evenstep study`, everything else one `evenstep run`, with the settings below.
The tables of the limits in three dimensions are those of stiffness_3d.py.
"""
import csv
import json
import math
import os
import re
import subprocess
import sys
import tempfile

from stiffness_3d import largest_stiffness

FOLDER = "scenarios/closed-loop"
LATE_S, TICK_S, MASS_KG, FRICTION = 0.0155644, 0.001, 0.2, 1.0  # L_e and h of the reference timing; the hand
RAW_LATE_S = 0.00531
JITTER = ['timing.jitter={ visualization = "lognormal 10 %", step = "lognormal 10 %" }',
          'study.stiffness_limit={ from = "20 N/m", to = "30000 N/m", seeds = 3 }']
PID = '{{ travel = ["40 mm", "40 mm", "0 mm"], full_scale = "1000 N", full_slope = "{}", gain = 1.0, ' \
      'springs = ["x", "y"], firmware_rate = "{}" }}'
FORCE = 'device.left.render={ kind = "force" }'
INSTANTANEOUS = 'device.left.render={ kind = "local" }'
SETTLED = 'device.left.render={ kind = "local", stiffness = "settled" }'
BOTH = 'run.strategies=["direct", "phase_locked"]'


def local(alpha, more=""):
    return f'device.left.render={{ kind = "local", alpha = {alpha}{more} }}'


def call(evenstep, command, file, sets, folder):
    arguments = [evenstep, command, f"{FOLDER}/{file}.toml", "--out", os.path.join(folder, "out")]
    if not any(setting.startswith("expect=") for setting in sets):
        sets = [*sets, "expect=[]"]
    arguments += ["--json"] if command == "study" else ["--allow-no-expectations"]
    for setting in sets:
        arguments += ["--set", setting]
    result = subprocess.run(arguments, capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{' '.join(arguments)}\n{result.stdout}{result.stderr}")
    return result.stdout


def search(evenstep, file, sets):
    """strategy -> the limit that `evenstep study` found."""
    with tempfile.TemporaryDirectory() as folder:
        return {one["strategy"]: one for one in json.loads(call(evenstep, "study", file, sets, folder))["limits"]}


def metrics(evenstep, file, sets):
    with tempfile.TemporaryDirectory() as folder:
        call(evenstep, "run", file, sets, folder)
        with open(os.path.join(folder, "out", "summary.json"), encoding="utf-8") as summary:
            return json.load(summary)["metrics"]


def number(value):
    """Three significant digits, but always all digits before the point."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


def three(value):
    """Three significant digits, without zeros at the end."""
    return f"{float(format(value, '.3g')):g}"


def stable(limit):
    return ("above " if limit["state"] == "above" else "") + number(limit["stable_N_per_m"])


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return [re.sub(r"\|  (?=\|)", "| ", line) for line in lines + ["| " + " | ".join(row) + " |" for row in rows]]


def damping_law(alpha, late_s=LATE_S, friction=FRICTION):
    return friction / ((1 - alpha) * late_s + alpha * TICK_S / 2)


def overshoot_law(alpha):
    return 0.55 * MASS_KG * (math.pi / LATE_S) ** 2 / (2 * alpha - 1)


def spring(evenstep):
    def row(name, file, sets, law):
        found = search(evenstep, file, sets)
        return [name, stable(found["direct"]), stable(found["phase_locked"]), number(law) if law else ""]

    rows = [row("`force`", "price-study", [], FRICTION / LATE_S)]
    for alpha, law in (("0.8", damping_law(0.8)), ("0.9", damping_law(0.9)), ("1", damping_law(1)), ("1.0332", None),
                       ("1.1", overshoot_law(1.1)), ('"auto"', None), ("1.2", overshoot_law(1.2)),
                       ("1.5", overshoot_law(1.5)), ("2", overshoot_law(2))):
        name = {"1.0332": "1.0332 (alpha\\*)", '"auto"': '`"auto"` (raw 1.17, remapped 1.10)'}.get(alpha, alpha)
        rows.append(row(f"`local` alpha {name}", "price-local-study", [local(alpha)], law))
    predicted = search(evenstep, "price-study", ['run.strategies=["predict"]'])["predict"]
    rows.append(["`force`, and the strategy `predict`", "", stable(predicted), ""])
    return table(["spring", "raw", "remapped", "law, remapped"], rows)


def delay(evenstep):
    alphas = ("0.9", "1", "1.1", "1.2", '"auto"')
    plans = [("device delay 0", [], alphas), ("device delay 1 ms", ['device.left.delay="1 ms"'], alphas),
             ("device delay 2 ms", ['device.left.delay="2 ms"'], alphas),
             ("friction 2 N s/m", ['device.left.motion.damping="2 N s/m"'], ("1", "1.1")),
             ("friction 5 N s/m", ['device.left.motion.damping="5 N s/m"'], ("1", "1.1")),
             ("10 % jitter (L = 19.3 ms, three seeds)", JITTER, ("0.9", "1", "1.1", '"auto"'))]
    cell = lambda alpha, sets: stable(search(evenstep, "price-local-study", [local(alpha), *sets])["phase_locked"])
    rows = [[row] + [cell(alpha, sets) if alpha in given else "" for alpha in alphas] for row, sets, given in plans]
    force = search(evenstep, "price-local-study", [FORCE, *JITTER])["phase_locked"]
    rows[-1][0] = f"10 % jitter (L = 19.3 ms, three seeds; `force`: {stable(force)})"
    return table(["spring, remapped", "alpha 0.9", "1.0", "1.1", "1.2", '`"auto"`'], rows)


def device(evenstep):
    rows = []
    for rate, slope, own_s in (("1 kHz", 20000, 1e-3), ("4 kHz", 20000, 0.25e-3), ("8 kHz", 20000, 0.125e-3),
                               ("4 kHz", 1000, 0.25e-3), ("4 kHz", 2000, 0.25e-3), ("4 kHz", 4000, 0.25e-3)):
        slope_text = f"{slope // 1000} kN/m" if slope > 9999 else f"{slope} N/m"
        found = search(evenstep, "price-device-spring-study", [f"device.left.pid={PID.format(slope_text, rate)}",
                                                               'device.left.force_limit="1000 N"'])
        one = found["phase_locked"]
        assert found["direct"]["stable_N_per_m"] == one["stable_N_per_m"], "the page says that raw forces give the same"
        law = min(2 * FRICTION / own_s, 2 * FRICTION / TICK_S + (1 - own_s / TICK_S) * slope)
        rows.append([rate, slope_text, f"{stable(one)} to {number(one['unstable_N_per_m'])}", number(law)])
    return table(["`firmware_rate`", "its slope", "measured", "law"], rows)


def mode(evenstep):
    def cell(frequency, render):
        sets = [f'scene.frequency="{frequency} Hz"', f"device.left.render={render}", 'run.strategies=["phase_locked"]',
                'study.stiffness_limit={ from = "10 N/m", to = "30000 N/m" }']
        return stable(search(evenstep, "tissue-static", sets)["phase_locked"])

    rows = []
    for frequency in (3, 7, 15, 30, 60):
        cells = [cell(frequency, render) for render in (
            '{ kind = "force" }', '{ kind = "local" }', '{ kind = "local", stiffness = "settled" }',
            '{ kind = "local", stiffness = "settled", alpha = 1.1 }', '{ kind = "smith", factor = 1.0 }',
            '{ kind = "smith", factor = 1.1 }', '{ kind = "smith", factor = 0.8 }')]
        rows.append([f"{frequency} Hz", f"{frequency * LATE_S:.2f}", *cells[:4], " / ".join(cells[4:])])
    return table(["f0", "f0 L_e", "`force`", "`local` instantaneous", "`local` settled", "settled, alpha 1.1",
                  "`smith` exact / 10 % too stiff / 20 % too soft"], rows)


def quality(evenstep):
    def get(file, signal, metric, *sets):
        return metrics(evenstep, file, sets)[signal][metric]

    loop, right = "closed_loop.left.phase_locked", "right.force.phase_locked"
    force = "left.force.phase_locked"
    milli = lambda value: number(abs(value) * 1e3) if abs(value) >= 5e-5 else "0"
    sine = lambda *sets: f"{get('price-sine', loop, 'rendered_damping', *sets) + 0.0:.2f}"
    star = f"{abs(get('price-local-alpha-star', loop, 'rendered_damping')):.2f}"
    push = {name: (metrics(evenstep, "wall-push", [])[signal]) for name, signal in (("local", force), ("force", right))}
    percent = lambda name: f"{1e2 * push[name]['error_share']:.1f} %"
    ramp = metrics(evenstep, "wall-ramp", [])
    released = metrics(evenstep, "free-release-local", [])
    stop = metrics(evenstep, "dead-stop-local", [])
    rows = [
        ["damping rendered by 300 N/m at 3 Hz, N s/m", sine(), f"{sine(local(1.0))}; {star} at alpha\\*", "",
         "price-sine, price-local-alpha-star"],
        ["energy given back of 0.625 mJ stored (50 N/m)",
         f"{get('free-release', loop, 'energy_released'):.2f} times", f"{released[loop]['energy_released']:.2f}",
         f"{released['closed_loop.right.phase_locked']['energy_released']:.2f}", "free-release, free-release-local"],
        ["push into a wall: error", percent("force"), percent("local"), "", "wall-push"],
        ["the touch is felt late by", f"{push['force']['onset_delay'] * 1e3:.0f} ms",
         f"{push['local']['onset_delay'] * 1e3:.0f} ms", "", "wall-push"],
        ["the wall pulls after the tool has left: largest force", f"{milli(push['force']['ghost_force'])} mN",
         f"{milli(push['local']['ghost_force'])} mN", "", "wall-push"],
        ["ramp into a wall: largest step (ideal 30 mN)", "",
         f"{milli(ramp[force]['jump_max'])} mN; without the gap {milli(ramp[right]['jump_max'])} mN", "", "wall-ramp"],
        ["sudden stop at 0.1 m/s, 300 N/m: largest error",
         f"{milli(get('dead-stop-predict', 'left.force.predict', 'error_at_stop'))} mN (`predict`)",
         f"{milli(stop[force]['error_at_stop'])} mN", f"{milli(stop[right]['error_at_stop'])} mN",
         "dead-stop-local, dead-stop-predict"],
        ["push into ringing tissue, settled stiffness: error", "", "",
         f"{1e2 * get('tissue-static-push', force, 'error_share'):.2f} %", "tissue-static-push"],
    ]
    return table(["what", "`force`", "`local` alpha 1", "alpha 1.1", "scenario"], rows)


def lattice(evenstep):
    at_tool = {"grab": 10.85, "probe": 3.9}
    rows = {}
    for tool in ("grab", "probe"):
        for render in (FORCE, INSTANTANEOUS, SETTLED):
            for strategy, one in search(evenstep, f"lattice-{tool}-study", [render]).items():
                cell = stable(one)
                if one["state"] == "found":
                    cell += f" ({three(at_tool[tool] * one['stable_N_per_m'])})"
                rows.setdefault(f"{tool}, {'raw' if strategy == 'direct' else 'remapped'}", []).append(cell)
    gapless = search(evenstep, "lattice-probe-study", ['device.left.render={ kind = "local", gap = false }'])["phase_locked"]
    rows["probe, remapped, without the gap"] = [
        "", f"{stable(gapless)} ({three(at_tool['probe'] * gapless['stable_N_per_m'])})", ""]
    return table(["largest stable k", "`force`", "`local` instantaneous", "`local` settled"],
                 [[name, *cells] for name, cells in rows.items()])


WAYS = (("raw `force`", "direct", FORCE), ("raw, `local` settled", "direct", SETTLED),
        ("remapped `force`", "phase_locked", FORCE), ("remapped, `local` instantaneous", "phase_locked", INSTANTANEOUS),
        ("remapped, `local` settled", "phase_locked", SETTLED))


def compared(evenstep, file, strategy, sets):
    """The force, compared with the tissue's own answer without delay, which is computed if an expectation asks for it."""
    signal = f"left.force.{strategy}"
    asked = f'expect=[{{ signal = "{signal}", metric = "error_share", min = 0 }}]'
    return metrics(evenstep, file, [*sets, f'run.strategies=["{strategy}"]', asked])[signal]


def share(signal):
    return f"{float(format(1e2 * signal['error_share'], '.2g')):g} %"


def step(signal, metric="jump_max"):
    return f"{three(1e3 * signal[metric])} mN"


def lattice_error(evenstep):
    rows = []
    for name, strategy, render in WAYS:
        grab, probe = (compared(evenstep, f"lattice-{tool}-push", strategy, [render]) for tool in ("grab", "probe"))
        jump, late = step(probe), f"{1e3 * probe['onset_delay']:.0f} ms"
        if "local" in render and strategy == "phase_locked":
            gapless = compared(evenstep, "lattice-probe-push", strategy, [render.replace(" }", ", gap = false }")])
            jump += f"; without the gap {step(gapless)}"
            late += f"; without the gap {1e3 * gapless['onset_delay']:.0f} ms"
        rows.append([name, share(grab), step(grab), share(probe), jump, late])
    return table(["", "grab: error", "largest step", "probe: error", "largest step", "the touch is felt late by"], rows)


def lattice_ripple(evenstep):
    rows = []
    for k in (20, 200):
        cells = []
        for render in (FORCE, INSTANTANEOUS):
            found = metrics(evenstep, "lattice-grab-ripple", [render, f'scene.stiffness="{k} N/m"', BOTH])
            cells.append([found[f"left.force.{strategy}"]["residual_20_500_hz"] for strategy in ("direct", "phase_locked")])
        rows.append([str(k)] + [f"{1e3 * cells[render][strategy]:.3g} mN" for strategy in (0, 1) for render in (0, 1)])
    return table(["ripple of a lump pushed evenly, k", "raw `force`", "raw, `local`", "remapped `force`",
                  "remapped, `local`"], rows)


def block_sine(evenstep):
    grabs = {"middle": "20 mm", "corner": "4 mm"}
    # Downwards and sideways at k = 1, printed by test_study "[.print-stiffness]".
    per_spring = {("middle", "down"): 8.59, ("middle", "sideways"): 3.42, ("corner", "down"): 5.235,
                  ("corner", "sideways"): 2.78}
    rows = []
    for (place, way), one in per_spring.items():
        at = grabs[place]
        amplitude = '["0 mm", "0 mm", "4 mm"]' if way == "down" else '["4 mm", "0 mm", "0 mm"]'
        sets = [f'device.left.grab={{ center = ["{at}", "{at}", "40 mm"], radius = "11 mm" }}',
                f'device.left.motion={{ kind = "sine", amplitude = {amplitude}, frequency = "3 Hz" }}', BOTH]
        damping = lambda render, strategy: metrics(evenstep, "block-sine", [render, *sets])[
            f"closed_loop.left.{strategy}"]["rendered_damping"]
        stiffness = 20 * one
        late = damping(FORCE, "phase_locked")
        law, raw_law = -stiffness * LATE_S, -stiffness * RAW_LATE_S
        rows.append([f"{place}, {way}", f"{stiffness:.1f}", f"{raw_law:.2f}, {damping(FORCE, 'direct'):+.2f}",
                     f"{law:.2f}, {late:+.2f} ({late / law:.2f})", f"{damping(INSTANTANEOUS, 'phase_locked'):.2f}",
                     f"{damping(SETTLED, 'phase_locked'):.2f}"])
    return table(["direction", "K, N/m", "raw: law, measured", "remapped: law, measured", "`local` instantaneous",
                  "`local` settled"], rows)


def slide_error(evenstep):
    more = (("the same, alpha 0.5", "phase_locked", SETTLED.replace(" }", ", alpha = 0.5 }")),
            ("the same, `directions = \"normal\"` (`slide-normal`)", "phase_locked",
             SETTLED.replace(" }", ', directions = "normal" }')))
    files = {"remapped `force`": "remapped `force` (`slide-force`)",
             "remapped, `local` settled": "remapped, `local` settled (`slide`)"}
    rows = []
    for name, strategy, render in WAYS + more:
        one = compared(evenstep, "slide", strategy, [render])
        rows.append([files.get(name, name), share(one), step(one), f"{1e3 * one['ghost_force']:.0f} mN",
                     f"{1e3 * one['onset_delay']:.0f} ms", f"{1e3 * one['residual_20_500_hz']:.1f} mN"])
    return table(["", "error", "largest step", "pulls after leaving", "the touch is felt late by", "ripple, 20 to 500 Hz"],
                 rows)


# The hand that slides. The names say what varies; everything else is as in slide-hand.toml.
SLIDES = {
    "as `slide-hand`": {},
    "L = 20 ms": {"more": ['remap.latency="20 ms"'], "late_s": 0.0205},
    "L = 30 ms": {"more": ['remap.latency="30 ms"'], "late_s": 0.0305},
    "30 steps": {"more": ["timing.steps=30"], "late_s": None},
    "15 mm/s": {"speed": 0.015},
    "60 mm/s": {"speed": 0.06, "cells": 40},
    "0.4 kg": {"mass": 0.4},
    "0.1 kg": {"mass": 0.1},
    "2 N s/m": {"friction": 2.0},
    "0.5 N s/m": {"friction": 0.5},
    "leans with 0.14 N": {"lean": 0.14},
    "leans with 0.07 N": {"lean": 0.07},
}
AT_TOOL = 3.949  # the slope of the probe's force at 0.1 N, for each N/m of a spring
NORMAL = 'device.left.render={ kind = "local", stiffness = "settled", directions = "normal" }'


def slide(evenstep, strategy, render, k, speed=0.03, mass=0.2, friction=1.0, lean=0.1, cells=20, more=(), late_s=None):
    """(t, z, felt anything) of each tick, the mean speed of the last two seconds, and L_e."""
    sets = [f'scene.stiffness="{k} N/m"', f"scene.lattice=[{cells}, 6, 6]", render, f'run.strategies=["{strategy}"]',
            'device.left.grab={ coupling = "probe", center = ["20 mm", "20 mm", "60 mm"], radius = "20 mm", '
            f'stiffness = "{5 * k} N/m" }}',
            f'device.left.motion={{ kind = "hand", mass = "{mass} kg", damping = "{friction} N s/m", velocity = ['
            f'"{speed} m/s", "0 m/s", "0 m/s"], push = ["{round(speed * friction, 9)} N", "0 N", "{-lean} N"] }}', *more]
    with tempfile.TemporaryDirectory() as folder:
        call(evenstep, "run", "slide-hand", sets, folder)
        with open(os.path.join(folder, "out", "series.csv"), encoding="utf-8") as file:
            lines = csv.DictReader(line for line in file if not line.startswith("#"))
            ticks = [(float(row["t[s]"]), float(row["x[m]"]), float(row["z[m]"]),
                      any(float(row[axis]) for axis in ("fx[N]", "fy[N]", "fz[N]")))
                     for row in lines if row["kind"] == "tick"]
        with open(os.path.join(folder, "out", "summary.json"), encoding="utf-8") as summary:
            delay_s = json.load(summary)["metrics"][f"closed_loop.left.{strategy}"]["loop_delay"]
    assert len(ticks) > 3900, len(ticks)
    return ticks, (ticks[-1][1] - ticks[-2001][1]) / 2, delay_s


def swing(ticks, begin_s):
    """The RMS of the vertical speed over 10 ms, in the second that begins there."""
    z = [tick[2] for tick in ticks if begin_s <= tick[0] < begin_s + 1]
    speeds = [(later - sooner) / 0.01 for sooner, later in zip(z, z[10:])]
    mean = sum(speeds) / len(speeds)
    return math.sqrt(sum((one - mean) ** 2 for one in speeds) / len(speeds))


def keeps_contact(ticks):
    return all(felt for t, _, _, felt in ticks if t >= 3)


def slide_limit(evenstep, strategy, render, **how):
    """The largest k that keeps contact, as a stiffness at the tool; whether it is above that; how the hand then slides."""
    ran = {}

    def stays(k):
        ran[k] = slide(evenstep, strategy, render, float(f"{k:.4g}"), **how)
        return keeps_contact(ran[k][0])

    least, above = largest_stiffness(stays)
    assert least, "it hops with the least stiffness already"
    return AT_TOOL * least, above, ran[least]


def sliding(evenstep):
    rows = []
    for name, render in (("`force`", FORCE), ("`local` instantaneous", INSTANTANEOUS), ("`local` settled", SETTLED),
                         ('settled, `directions = "normal"`', NORMAL)):
        cells = []
        for strategy, law in (("direct", FRICTION / RAW_LATE_S), ("phase_locked", FRICTION / LATE_S)):
            law = law if "force" in name else 2 * FRICTION / TICK_S
            limit, above, _ = slide_limit(evenstep, strategy, render)
            cells.append(f"{'above ' if above else ''}{number(limit)} ({limit / law:.2f})")
        rows.append([name, *cells])
    return table(["largest lambda k that keeps contact, N/m; to the law of one spring", "raw", "remapped"], rows)


def sliding_swing(evenstep):
    """The swing of each second, below and above the limit of contact: does it decay?"""
    rows = []
    for name, render, stiffnesses in (("`force`", FORCE, (16, 18, 19, 24)),
                                      ("`local` settled", SETTLED, (100, 115, 125, 250, 500))):
        for k in stiffnesses:
            ticks, _, _ = slide(evenstep, "phase_locked", render, k)
            felt = [tick[3] for tick in ticks if tick[0] >= 3]
            rows.append([name, number(AT_TOOL * k), *(f"{1e3 * swing(ticks, second):.2f}" for second in (1, 2, 3)),
                         f"{100 * felt.count(False) / len(felt):.1f} %"])
    return table(["remapped, sliding", "lambda k, N/m", "swing in the second s, mm/s", "third", "fourth",
                  "without a force in the fourth"], rows)


def exact_limit(late_s, mass, friction):
    """m s^2 + b s + K exp(-s L_e) on the imaginary axis: w tan(w L_e) = b / m, K = b w / sin(w L_e)."""
    low, high = 0.0, math.pi / 2 / late_s
    for _ in range(100):
        w = (low + high) / 2
        low, high = (w, high) if w * math.tan(w * late_s) < friction / mass else (low, w)
    return friction * low / math.sin(low * late_s)


def sliding_laws(evenstep):
    """The force alone against the exact limit of one spring; the local model against a record that is v L_e old."""
    rows, base = [], {}
    for name, how in SLIDES.items():
        measured, _, (_, _, late_s) = slide_limit(evenstep, "phase_locked", FORCE, **how)
        law = exact_limit(late_s, how.get("mass", MASS_KG), how.get("friction", FRICTION))
        cells = [name, number(law), f"{number(measured)} ({measured / law:.2f})"]
        for render in (INSTANTANEOUS, NORMAL):
            limit, above, (_, speed, late_s) = slide_limit(evenstep, "phase_locked", render, **how)
            stale = how.get("lean", 0.1) / (speed * late_s)
            first = base.setdefault(render, (limit, stale))
            cells += [f"{stale / first[1]:.2f}", f"{limit / first[0]:.2f}{' or more' if above else ''}"]
            if render == INSTANTANEOUS:
                cells[-1] += f" ({number(limit)} N/m, {1e3 * speed:.0f} mm/s)"
        rows.append(cells)
    return table(["varied", "`force`: law", "`force`: measured", "`local`: predicted", "measured",
                  "normal only: predicted", "measured"], rows)


TABLES = {"spring": spring, "delay": delay, "device": device, "mode": mode, "quality": quality, "lattice": lattice,
          "lattice-error": lattice_error, "lattice-ripple": lattice_ripple, "block-sine": block_sine,
          "slide-error": slide_error, "sliding": sliding, "sliding-swing": sliding_swing,
          "sliding-laws": sliding_laws}


def put_into(page, lines):
    """In place of the table of the page with the same header."""
    with open(page, encoding="utf-8") as file:
        text = file.read()
    mended, count = re.subn(r"(?m)^" + re.escape(lines[0]) + r"\n(\|.*\n)+", lambda _: "\n".join(lines) + "\n", text)
    if count != 1:
        sys.exit(f"{page} has {count} tables that begin with {lines[0]}")
    with open(page, "w", encoding="utf-8") as file:
        file.write(mended)


def main(evenstep, *names):
    page = names[1] if names[:1] == ("--into",) else None
    for name in names[2 if page else 0:] or TABLES:
        lines = TABLES[name](evenstep)
        print("\n".join(lines), end="\n\n", flush=True)
        if page:
            put_into(page, lines)


if __name__ == "__main__":
    main(*sys.argv[1:])
