"""The types of the package, and of a program that uses it, as mypy sees them."""
import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

USER = """
import evenstep

class Spring:
    def step(self, positions_m: evenstep._parts.Vector, step_s: float) -> evenstep._parts.Vector:
        return -200.0 * positions_m

run: evenstep.Run = evenstep.run("a.toml", solver=Spring, seed=3)
jump: float = run.metrics["paper"]["left.force"]["velocity_jump"]
solver: evenstep.Solver = Spring()
async def lane(clock: evenstep.VirtualClock) -> None:
    now: int = await clock.until(5)
"""
WRONG = USER + """
evenstep.run("a.toml", sed=3)
name: str = evenstep.size("a.csv")
class Spoon:
    def step(self, positions_m: int) -> int: return 0
bad: evenstep.Solver = Spoon()
"""


def mypy(*words):
    environment = dict(os.environ, MYPYPATH=str(Path(os.environ["EVENSTEP_BUILD"]) / "apps/python"))
    if importlib.util.find_spec("mypy") is None:
        pytest.skip("mypy is not installed (Debian: mypy)")
    options = ["--strict", "--cache-dir", f"{os.environ['EVENSTEP_BUILD']}/mypy-cache", "--python-version", "3.11"]
    return subprocess.run([sys.executable, "-m", "mypy", *options, *map(str, words)], capture_output=True, text=True,
                          env=environment, check=False)


def test_mypy_accepts_the_package_and_its_user_and_sees_what_is_wrong(tmp_path):
    (tmp_path / "user.py").write_text(USER)
    (tmp_path / "wrong.py").write_text(WRONG)
    done = mypy("apps/python/evenstep", tmp_path / "user.py", tmp_path / "wrong.py")
    *lines, last = done.stdout.splitlines()
    assert [line for line in lines if " error: " in line and "wrong.py" not in line] == [] and "in 1 file" in last, done.stdout + done.stderr
    for what in ('Unexpected keyword argument "sed"', "Incompatible types in assignment", '"Solver"'):
        assert what in done.stdout, done.stdout
