"""What a step of a solver costs beside its own work: evenstep's own spring, one in a shared object, in Python and in a process
of Python, taking turns in one run. docs/parts/engines.md has its table.

    PYTHONPATH=build/apps/python python3 tests/python/cost_per_step.py [BUILD_DIR]
"""
import statistics
import sys
import tempfile
from pathlib import Path

import evenstep

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build").resolve()
SCENES = {"own": 'solver = "cpu-double"\nkind = "spring"\nstiffness = "200 N/m"',
          "library": f'library = "{BUILD}/tests/plugins/modules/my_spring.so"\noptions = {{ stiffness = 200 }}',
          "process": f'command = ["{sys.executable}", "{ROOT}/examples/process/my_solver.py"]\noptions = {{ stiffness = 200 }}'}
SCENARIO = """format = 1
name = "a spring"
[run]
duration = "20 s"
warmup = "8 segments"
strategies = ["direct"]
[timing]
segment = "30 Hz"
visualization = "11.1 ms"
steps = 15
[scene]
SCENE
[[device]]
name = "left"
motion = { kind = "constant-velocity", velocity = ["0.1 m/s", "0 m/s", "0 m/s"] }
"""


class Arrays:
    def step(self, positions_m, step_s):
        return -200 * positions_m


class Lists:
    def step(self, positions_m, step_s):
        return [[-200 * x for x in positions_m[0].tolist()]]


KINDS = {"own": ("own", None), "library": ("library", None), "Python, numpy": ("own", Arrays()),
         "Python, a list": ("own", Lists()), "process": ("process", None)}
with tempfile.TemporaryDirectory() as folder:
    for name, scene in SCENES.items():
        Path(folder, f"{name}.toml").write_text(SCENARIO.replace("SCENE", scene), encoding="utf-8")
    cost_us = {kind: [] for kind in KINDS}
    for _ in range(9):
        for kind, (name, solver) in KINDS.items():
            run = evenstep.run(Path(folder, f"{name}.toml"), solver=solver, threads=1)
            cost_us[kind].append(1e6 * run.metrics["direct"]["solver"]["solver_seconds"] / len(run.series["direct"].steps))
for kind, costs in cost_us.items():
    ratio = statistics.median(a / b for a, b in zip(costs, cost_us["library"]))
    print(f"{kind:<16}{statistics.median(costs):8.3f} us  {ratio:7.2f} of a library's")
