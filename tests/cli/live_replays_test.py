"""Every live run replays: live runs of all kinds, each recorded, are replayed to the trace that they had: in another
folder, where no driver of OpenGL is, and after the process was killed.

    live_replays_test.py PROGRAM"""
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

program = pathlib.Path(sys.argv[1]).resolve()
# Seconds of a run: some drawings, on a loaded machine too.
DURATION = 0.4
ROWS = 30

DRIVERS = {"reference": "", "pid": 'pid = { travel = ["200 mm", "200 mm", "0 mm"] }',
           "evdev": 'evdev = { travel = ["200 mm", "200 mm", "0 mm"] }',
           "inverse3": 'inverse3 = { origin = ["0 mm", "-120 mm", "150 mm"] }'}
COLUMNS = {
    "timing.visualization": ["5 ms", "render", "render 5 ms", "burn 3 ms"],
    "timing.step": ["1 ms", "real", "fill"],
    "timing.order": ["visualization-first", "steps-first"],
    "timing.governor": [None, '{ split = 2 }', '{ steps = "spread" }', '{ split = 2, steps = "spread" }', '{ budget = "4 ms" }',
                        '{ pace = "40 Hz" }'],
    "driver": list(DRIVERS),
    "render": ['{ kind = "force" }', '{ kind = "force", emission = "hold" }', '{ kind = "local" }'],
    "remap.latency": ["40 ms", "adaptive"],
    "scene.solver": ["cpu", "opencl"],
}
SCENARIO = """format = 1
name = "live"
[run]
duration = "{duration} s"
warmup = "0.1 s"
strategies = ["phase_locked"]
live = "phase_locked"
[timing]
segment = "30 Hz"
visualization = "{visualization}"
steps = 8
step = "{step}"
order = "{order}"
{governor}
[scene]
solver = "{solver}"
kind = "tissue"
lattice = [6, 6, 6]
particles = 216
spacing = "8 mm"
mass = "0.5 g"
stiffness = "20 N/m"
damping = "10e-3 N s/m"
fixed = "bottom"
substeps = "auto"
step_size = "240 Hz"
[[device]]
name = "left"
{driver}
rate = "1 kHz"
grab = {{ center = ["20 mm", "20 mm", "40 mm"], radius = "10 mm" }}
motion = {{ kind = "sine", amplitude = ["1 mm", "0 mm", "0 mm"], frequency = "2 Hz" }}
render = {render}
[remap]
lead = "{lead}"
{latency}
"""


def rows():
    """Values drawn independently of each other, the same ones each time."""
    state = 1
    for _ in range(ROWS):
        row = {}
        for name, values in COLUMNS.items():
            state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
            row[name] = values[(state >> 33) % len(values)]
        yield row


def scenario_of(row, duration=DURATION):
    adaptive = row["remap.latency"] == "adaptive"
    return SCENARIO.format(
        duration=duration, visualization=row["timing.visualization"], step=row["timing.step"], order=row["timing.order"],
        governor="" if row["timing.governor"] is None else "governor = " + row["timing.governor"],
        solver=row["scene.solver"], driver='driver = "' + row["driver"] + '"\n' + DRIVERS[row["driver"]], render=row["render"],
        lead="40 ms" if row["timing.order"] == "steps-first" else "4 ms",
        latency='latency = "adaptive"\nadapt = { start = "40 ms", max = "90 ms" }' if adaptive else 'latency = "90 ms"')


def run(arguments, folder, **environment):
    return subprocess.run([program, *arguments], cwd=folder, env={**os.environ, **environment}, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=120)


def trace_of(output):
    found = re.search(r"^trace ([0-9a-f]{16}) ", output, re.M)
    return found and found.group(1)


def live_then_replay(kind, scenario):
    """True if it was refused, for a reason and without a recording."""
    (here / "live.toml").write_text(scenario)
    log = here / "run.rec"
    log.unlink(missing_ok=True)
    live = run(["run", "--clock", "wall", "live.toml", "--record", "run.rec", "--allow-no-expectations"], here)
    if live.returncode == 2:  # what cannot be together says so, and nothing was recorded
        print(kind, [line for line in live.stdout.splitlines() if "error: " in line])
        if "error: " not in live.stdout or log.exists():
            problems.append((kind, "refused without a reason", live.stdout))
        return True
    # In another folder, and without a driver of OpenGL.
    replay = run(["replay", str(log)], elsewhere, __EGL_VENDOR_LIBRARY_DIRS="/nowhere")
    if live.returncode not in (0, 1) or replay.returncode not in (0, 1) or trace_of(live.stdout) is None or \
            trace_of(live.stdout) != trace_of(replay.stdout):
        problems.append((kind, f"exit {live.returncode}, then {replay.returncode}", live.stdout + replay.stdout))
    return False


def with_foreign_solver(row):
    """Its force is all that such a solver has, and its command is found from the folder of the replay, too."""
    scenario = scenario_of({**row, "render": '{ kind = "force" }'})
    before, _, scene = scenario.partition("[scene]\n")
    solver = pathlib.Path(__file__).resolve().parents[2] / "examples/process/my_solver.py"
    return (before + f'[scene]\ncommand = ["python3", "{solver}"]\noptions = {{ stiffness = 200 }}\nstep_size = "240 Hz"\n'
            + re.sub(r"grab = .*\n", "", scene[scene.index("[[device]]"):]))


def with_loop(row, loop):
    """The timing of a loop that counts its own steps, or that draws beside them."""
    scenario = scenario_of({**row, "timing.step": "1 ms", "timing.order": "steps-first", "timing.governor": None})
    return scenario.replace("steps = 8\n", "").replace('order = "steps-first"\n', loop)


problems, refused = [], 0
with tempfile.TemporaryDirectory() as name:
    here, elsewhere = pathlib.Path(name) / "here", pathlib.Path(name) / "elsewhere"
    here.mkdir()
    elsewhere.mkdir()
    for row in rows():
        refused += live_then_replay(row, scenario_of(row))
    for step in ("1 ms", "real"):
        row = {**next(rows()), "timing.step": step, "timing.visualization": "5 ms"}
        if live_then_replay("foreign solver, step " + step, with_foreign_solver(row)):
            problems.append((row, "a foreign solver was refused", ""))
    row = {**next(rows()), "render": '{ kind = "force" }', "driver": "reference", "remap.latency": "90 ms"}
    if not live_then_replay("[source]", scenario_of(row) + '[source]\ndelay = "5 ms"\n'):
        problems.append(("[source]", "it runs on the virtual clock only, and was not refused", ""))
    for visualization in COLUMNS["timing.visualization"]:
        row = {**next(rows()), "timing.visualization": visualization}
        for loop in ('loop = "accumulator"\n', 'loop = "accumulator"\nmax_steps = 3\norder = "visualization-first"\n'):
            if live_then_replay(loop, with_loop(row, loop)):
                problems.append((row, "an accumulator was refused", ""))
        loop = 'order = "concurrent"\npaced = true\n'
        if not live_then_replay(loop, with_loop(row, loop)):
            problems.append((row, "drawings beside steps are on the virtual clock only, and were not refused", ""))
    # A run that is killed leaves what it had recorded, and that replays, for each kind of visualization.
    for visualization in COLUMNS["timing.visualization"]:
        row = {**next(rows()), "timing.visualization": visualization, "driver": "reference"}
        (here / "live.toml").write_text(scenario_of(row, 60))
        log = here / "killed.rec"
        log.unlink(missing_ok=True)
        with subprocess.Popen([program, "run", "--clock", "wall", "live.toml", "--record", "killed.rec"], cwd=here,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            until = time.monotonic() + 20
            while time.monotonic() < until and (not log.exists() or log.stat().st_size < 40_000):
                time.sleep(0.05)
            process.send_signal(signal.SIGKILL)
        replay = run(["replay", str(log)], elsewhere, __EGL_VENDOR_LIBRARY_DIRS="/nowhere")
        if replay.returncode not in (0, 1) or trace_of(replay.stdout) is None:
            problems.append((row, f"killed; replay exits with {replay.returncode}", replay.stdout))

for row, what, output in problems:
    print(f"{row}\n{what}\n{output[-1500:]}\n")
print(f"{ROWS} kinds of live runs, {refused} refused, {len(problems)} problems")
if refused > 6:
    problems.append("too many are refused to tell anything")
sys.exit(1 if problems else 0)
