"""Scenarios as tests of pytest."""
import subprocess
import sys


def pytest_of(folder, *words):
    done = subprocess.run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *words], cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout


def test_a_folder_of_scenarios_is_a_folder_of_tests(spring):
    folder = spring.parent
    (folder / "late.toml").write_text("""format = 1
extends = ["spring.toml"]
name = "late"
tags = ["mine"]
[remap]
latency = "11 ms"
""")
    (folder / "wrong.toml").write_text('format = 1\nextends = ["spring.toml"]\nname = "wrong"\n[timing]\nsteps = 0\n')
    (folder / "long.toml").write_text('format = 1\nextends = ["spring.toml"]\nname = "long"\ntags = ["long"]\n')
    (folder / "pyproject.toml").write_text('[project]\nname = "mine"\n')
    (folder / "a").mkdir()
    (folder / "a" / "summary.json").write_text("{}")
    (folder / "a" / "resolved.toml").write_text(spring.read_text())  # a run has left it
    code, out = pytest_of(folder)
    assert code == 1 and "2 failed, 1 passed, 1 skipped" in out
    assert "spring.toml:26:1: left.force.phase_locked underruns: 132, limit = 0: late first at step 120, 0.278 s" in out
    assert "again: evenstep run late.toml" in out
    assert "wrong.toml:5:9: error: 'steps'" in out
    assert pytest_of(folder, "-m", "mine")[1].count("FAILED late.toml::run") == 1
    assert "1 passed" in pytest_of(folder, "long.toml")[1]
    code, out = pytest_of(folder, "spring.toml", "--evenstep-set", "expect=[]")
    assert code == 1 and "nothing was asserted" in out
