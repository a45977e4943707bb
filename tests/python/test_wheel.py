"""The wheel of pyproject.toml, made and installed by pip without a network."""
import importlib.metadata
import os
import subprocess
import sys
import zipfile

import pytest


def test_pip_makes_and_installs_a_wheel_without_a_network(tmp_path, spring):
    def pip(*words):
        return subprocess.run([sys.executable, "-m", "pip", "--no-input", "--disable-pip-version-check", *words],
                              capture_output=True, text=True, check=False)

    if pip("--version").returncode != 0:
        pytest.skip("pip is not installed (Debian: python3-pip)")
    made = pip("wheel", ".", "--no-index", "--no-deps", "--no-build-isolation", "--wheel-dir", str(tmp_path),
               "--config-settings", f"build-dir={os.environ['EVENSTEP_BUILD']}")
    assert made.returncode == 0, made.stdout + made.stderr
    wheel, = tmp_path.glob("evenstep-*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert {"evenstep/__init__.py", "evenstep/py.typed", "evenstep/_core.pyi"} < set(names)
    assert not [name for name in names if "__pycache__" in name]
    place = tmp_path / "site"
    done = pip("install", "--no-index", "--no-deps", "--target", str(place), str(wheel))
    assert done.returncode == 0, done.stdout + done.stderr
    told = importlib.metadata.distribution("evenstep")
    code = f"import evenstep; print(evenstep.__file__, evenstep.__version__, evenstep.run({str(spring)!r}).verdict)"
    ran = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True,
                         env=dict(os.environ, PYTHONPATH=str(place)))
    assert ran.stdout.split() == [str(place / "evenstep/__init__.py"), told.version, "pass"]
    collected = subprocess.run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(spring)], cwd=tmp_path,
                               capture_output=True, text=True, check=False, env=dict(os.environ, PYTHONPATH=str(place)))
    assert "1 passed" in collected.stdout  # the plugin is found by its entry point
