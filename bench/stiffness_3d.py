"""Largest stable stiffness on the lattice tissue, in three dimensions and for two hands: docs/forces/stiffness.md.

stiffness_3d.py run EVENSTEP docs/forces/stiffness-3d.csv [RENDER ...]    searches (some minutes) and writes the table
stiffness_3d.py scene EVENSTEP docs/forces/stiffness-3d.csv SCENE         only this scene, such as sliding
stiffness_3d.py tables docs/forces/stiffness-3d.csv                       the tables of the page that the CSV holds
stiffness_3d.py plot docs/forces/stiffness-3d.csv docs/images/stiffness-3d.svg
"""
import csv
import json
import math
import os
import subprocess
import sys
import tempfile

# For each scene: its file; the largest eigenvalue of the settled stiffness of all tools together, per N/m of a spring
# (printed by test_study "[.print-stiffness]"; for a probe the slope of its force at 0.1 N); further settings.
SCENES = {
    "middle": ("block-grab", 8.590, []),
    "corner": ("block-corner", 6.311, []),
    "hands 48 mm apart": ("hands-far", 9.569, []),
    "hands side by side": ("hands-near", 26.03, []),
    "probe": ("block-probe", 3.949, ['run.duration="8 s"']),
    "sliding": ("slide-hand", 3.949, []),
}
PID = '{ travel = ["40 mm", "40 mm", "40 mm"], full_scale = "40 N", full_slope = "20 kN/m", ' \
      'gain = 1.0, springs = ["x", "y", "z"], firmware_rate = "4 kHz" }'
# For each way to render: its setting, and the law for a spring, raw and remapped, in N/m at the tool.
RENDERS = {
    "force": ('{ kind = "force" }', (188.3, 64.25)),
    "local, instantaneous": ('{ kind = "local" }', (2000, 2000)),
    "local, settled": ('{ kind = "local", stiffness = "settled" }', (2000, 2000)),
    "local, settled, alpha 1.1": ('{ kind = "local", stiffness = "settled", alpha = 1.1 }', (None, 3735)),
    "local, settled, axes only": ('{ kind = "local", stiffness = "settled", directions = "axes" }', (2000, 2000)),
    "local, settled, normal only": ('{ kind = "local", stiffness = "settled", directions = "normal" }', (2000, 2000)),
    "local, settled, coupled": ('{ kind = "local", stiffness = "settled", coupled = true }', (2000, 2000)),
    "local, instantaneous, coupled": ('{ kind = "local", coupled = true }', (2000, 2000)),
    # Each stiffness above 1800 N/m is played softer, and then the law says nothing about the tissue.
    "local, settled, own caps": ('{ kind = "local", stiffness = "settled", cap = "law" }', (None, None)),
    "local, settled, coupled, one cap": ('{ kind = "local", stiffness = "settled", coupled = true, cap = "law" }',
                                         (None, None)),
    "device_spring, settled": ('{ kind = "device_spring", stiffness = "settled" }', (8000, 8000)),
    "device_spring, settled, coupled": ('{ kind = "device_spring", stiffness = "settled", coupled = true }', (8000, 8000)),
}


SLIDING = ["force", "local, instantaneous", "local, settled", "local, settled, normal only"]


def makes_sense(scene, render):
    hands, probe = scene.startswith("hands"), scene == "probe"
    if scene == "sliding":
        return render in SLIDING
    if "normal" in render:
        return probe
    if "axes" in render:
        return scene in ("corner", "probe")
    if "coupled" in render or "cap" in render:
        return hands
    return not (render == "device_spring, settled" and scene == "hands side by side")


def keeps_contact(evenstep, strategy, render, k, folder):
    """Whether the hand that slides feels a force at every tick of the last second."""
    sets = [f'scene.stiffness="{k} N/m"', f"device.left.render={render}", f'run.strategies=["{strategy}"]', "expect=[]",
            'device.left.grab={ coupling = "probe", center = ["20 mm", "20 mm", "60 mm"], radius = "20 mm", '
            f'stiffness = "{5 * k} N/m" }}']
    command = [evenstep, "run", "scenarios/closed-loop/slide-hand.toml", "--allow-no-expectations", "--out", folder]
    for setting in sets:
        command += ["--set", setting]
    subprocess.run(command, check=True, capture_output=True)
    with open(os.path.join(folder, "series.csv"), encoding="utf-8") as file:
        lines = csv.DictReader(line for line in file if not line.startswith("#"))
        forces = [[float(row[axis]) for axis in ("fx[N]", "fy[N]", "fz[N]")] for row in lines
                  if row["kind"] == "tick" and float(row["t[s]"]) >= 3]
    assert len(forces) > 900, len(forces)
    return all(any(force) for force in forces)


def largest_stiffness(keeps):
    """The largest k for which keeps(k), up from 5 in steps of 1.25 until it is lost, then bisected to 2 %: 0 if none keeps.
    And whether it is only known to be above that, because the search ends at 3000."""
    stable, lost = 0, 5
    while lost < 3000 and keeps(lost):
        stable, lost = lost, lost * 1.25
    while stable and lost < 3000 and lost > 1.02 * stable:
        middle = math.sqrt(stable * lost)
        stable, lost = (middle, lost) if keeps(middle) else (stable, middle)
    return stable, lost >= 3000


def search_sliding(evenstep, render):
    limits = []
    with tempfile.TemporaryDirectory() as folder:
        for strategy in ("direct", "phase_locked"):
            stable, above = largest_stiffness(lambda k: keeps_contact(
                evenstep, strategy, RENDERS[render][0], float(f"{k:.4g}"), os.path.join(folder, "out")))
            state = "below" if not stable else "above" if above else "found"
            limits.append({"strategy": strategy, "state": state, "stable_N_per_m": stable})
    return limits


def search(evenstep, scene, render):
    if scene == "sliding":
        return search_sliding(evenstep, render)
    file, _, more = SCENES[scene]
    least = 5 if scene == "probe" else 1
    sets = [f'study.stiffness_limit={{ from = "{least} N/m", to = "3000 N/m" }}', "expect=[]", *more]
    for hand in ("left", "right") if scene.startswith("hands") else ("left",):
        sets.append(f"device.{hand}.render={RENDERS[render][0]}")
        if "device_spring" in render:
            sets += [f'device.{hand}.driver="pid"', f"device.{hand}.pid={PID}"]
    with tempfile.TemporaryDirectory() as folder:
        command = [evenstep, "study", f"scenarios/closed-loop/{file}.toml", "--json", "--out", os.path.join(folder, "out")]
        for setting in sets:
            command += ["--set", setting]
        return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)["limits"]


COLUMNS = ["scene", "render", "strategy", "state", "N_per_m_of_a_spring", "N_per_m_at_the_tool", "law_N_per_m", "ratio"]


def rows_of(path):
    if not os.path.exists(path):
        return []
    with open(path, encoding="utf-8") as file:
        return list(csv.DictReader(file))


def write(path, rows):
    order = [(scene, render) for scene in SCENES for render in RENDERS]
    rows.sort(key=lambda row: (order.index((row["scene"], row["render"])), row["strategy"]))
    with open(path, "w", encoding="utf-8", newline="") as file:
        out = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        out.writeheader()
        out.writerows(rows)


def run(evenstep, path, *only, scenes=tuple(SCENES)):
    """`only`: renders to search again; the rows of the others stay."""
    for scene in scenes:
        largest = SCENES[scene][1]
        for render, (_, laws) in RENDERS.items():
            if not makes_sense(scene, render) or (only and render not in only):
                continue
            rows = [row for row in rows_of(path) if (row["scene"], row["render"]) != (scene, render)]
            for limit, law in zip(search(evenstep, scene, render), laws):
                stable, found = limit.get("stable_N_per_m", 0), limit["state"] == "found"
                at_tool = stable * largest if largest else None
                rows.append(dict(zip(COLUMNS, [
                    scene, render, limit["strategy"], limit["state"], f"{stable:.4g}", f"{at_tool:.4g}" if at_tool else "",
                    law or "", f"{at_tool / law:.3g}" if at_tool and law and found else ""])))
                print(scene, "|", render, "|", limit["strategy"], limit["state"], f"{stable:.4g}", flush=True)
            write(path, rows)


def tables(path):
    rows = {(row["scene"], row["render"], row["strategy"]): row for row in rows_of(path)}

    def cell(scene, render, strategy):
        row = rows.get((scene, render, strategy))
        if row is None:
            return ""
        value = f"{float(format(float(row['N_per_m_at_the_tool']), '.3g')):g}"
        ratio = f" ({float(row['ratio']):.2f})" if row["ratio"] else ""
        return ("above " if row["state"] == "above" else "") + value + ratio

    for columns in ([("force", "direct"), ("force", "phase_locked"), ("local, instantaneous", "direct"),
                     ("local, instantaneous", "phase_locked"), ("local, settled", "direct"),
                     ("local, settled", "phase_locked"), ("local, settled, alpha 1.1", "phase_locked")],
                    [(render, "phase_locked") for render in (
                        "local, settled, axes only", "local, settled, normal only", "local, instantaneous, coupled",
                        "local, settled, coupled", "device_spring, settled", "device_spring, settled, coupled")]):
        print("| scene | " + " | ".join(f"{render}, {strategy}" for render, strategy in columns) + " |")
        print("|" + "---|" * (len(columns) + 1))
        for scene in SCENES:
            print(f"| {scene} | " + " | ".join(cell(scene, *column) for column in columns) + " |")
        print()


def plot(path, svg):
    """Dots on a logarithmic scale: the limit at the tool; a line where the law of one spring has it."""
    rows = [row for row in rows_of(path) if row["N_per_m_at_the_tool"]]
    left, right, line, top = 250, 760, 16, 46
    x = lambda value: left + (math.log10(value) - 1) / 4 * (right - left)
    y = top
    body = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        body.append(f'<text x="10" y="{y + 4}" font-weight="bold">{scene}</text>')
        y += line
        for render in dict.fromkeys(row["render"] for row in rows if row["scene"] == scene):
            body.append(f'<text x="20" y="{y + 4}">{render}</text>')
            body.append(f'<line x1="{left}" y1="{y}" x2="{right}" y2="{y}" stroke="#e4e4e4"/>')
            for row in rows:
                if row["scene"] != scene or row["render"] != render:
                    continue
                value, raw = float(row["N_per_m_at_the_tool"]), row["strategy"] == "direct"
                color = "#c0504d" if raw else "#1f6fb4"
                if row["law_N_per_m"]:
                    at = x(float(row["law_N_per_m"]))
                    body.append(f'<line x1="{at:.1f}" y1="{y - 6}" x2="{at:.1f}" y2="{y + 6}" stroke="{color}" '
                                'stroke-width="1.5"/>')
                fill = "white" if row["state"] == "above" else color
                body.append(f'<circle cx="{x(value):.1f}" cy="{y}" r="4" fill="{fill}" stroke="{color}" '
                            'stroke-width="1.5"/>')
            y += line
        y += line // 2
    for power in range(1, 6):
        at = x(10 ** power)
        body.append(f'<line x1="{at}" y1="{top - 8}" x2="{at}" y2="{y - line}" stroke="#d0d0d0" stroke-dasharray="2,3"/>')
        body.append(f'<text x="{at}" y="{y + 2}" text-anchor="middle">{10 ** power}</text>')
    body.append(f'<text x="{(left + right) / 2}" y="{y + 18}" text-anchor="middle">'
                'largest stable stiffness at the tool, N/m</text>')
    body.append('<circle cx="260" cy="16" r="4" fill="#c0504d"/><text x="270" y="20">raw</text>'
                '<circle cx="320" cy="16" r="4" fill="#1f6fb4"/><text x="330" y="20">remapped</text>'
                '<circle cx="410" cy="16" r="4" fill="white" stroke="#1f6fb4" stroke-width="1.5"/>'
                '<text x="420" y="20">or more</text>'
                '<line x1="490" y1="10" x2="490" y2="22" stroke="#1f6fb4" stroke-width="1.5"/>'
                '<text x="497" y="20">law of one spring</text>')
    with open(svg, "w", encoding="utf-8") as file:
        file.write(f'<svg xmlns="http://www.w3.org/2000/svg" width="790" height="{y + 28}" viewBox="0 0 790 {y + 28}" '
                   'font-family="sans-serif" font-size="12" fill="#222">\n<rect width="100%" height="100%" fill="white"/>\n'
                   + "\n".join(body) + "\n</svg>\n")


if __name__ == "__main__":
    one_scene = lambda evenstep, path, scene: run(evenstep, path, scenes=[scene])
    {"run": run, "scene": one_scene, "tables": tables, "plot": plot}[sys.argv[1]](*sys.argv[2:])
