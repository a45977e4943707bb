"""The scripts of examples/python."""
import importlib.util
import shutil
import subprocess
import sys
from pathlib import Path

import pytest


def run(script, *words, folder):
    done = subprocess.run([sys.executable, str(Path("examples/python", script).resolve()), *words], cwd=folder,
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_masses_and_springs_in_numpy_are_felt_evenly(tmp_path):
    direct, remapped, verdict = run("mass_spring.py", folder=tmp_path).splitlines()
    assert float(direct.split()[1]) > 1000 * float(remapped.split()[1])
    assert verdict.startswith("pass, trace ")


def test_a_mass_in_mujoco_is_felt_evenly(tmp_path):
    if not Path("/usr/include/mujoco/mujoco.h").exists() or shutil.which("cc") is None:
        pytest.skip("MuJoCo or a C compiler is not installed (Debian: libmujoco-dev, gcc)")
    direct, remapped, verdict = run("mujoco_mass.py", folder=tmp_path).splitlines()
    assert float(direct.split()[1]) > 1000 * float(remapped.split()[1])
    assert verdict.startswith("pass, trace ")


def test_two_loops_with_a_remapper(tmp_path):
    out = run("two_threads.py", folder=tmp_path)
    assert out == run("two_threads.py", folder=tmp_path)
    assert "velocity jump: 4.5e-07 step in" in out and "0 late forces" in out
    assert "velocity jump: " in run("two_threads.py", "wall", folder=tmp_path)  # how even depends on the machine


def test_figure_1_is_drawn(tmp_path):
    if importlib.util.find_spec("matplotlib") is None:
        pytest.skip("matplotlib is not installed (Debian: python3-matplotlib)")
    scenario = Path("scenarios/paper/figure-1-spring.toml").resolve()
    assert run("figure_1.py", str(scenario), folder=tmp_path).endswith(": pass, figure-1.png\n")
    assert (tmp_path / "figure-1.png").read_bytes().startswith(b"\x89PNG") and \
        (tmp_path / "figure-1.png").stat().st_size > 20_000
