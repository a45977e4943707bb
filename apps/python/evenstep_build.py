"""The build backend of pyproject.toml (PEP 517). It builds the target evenstep_python with CMake and packs what is then in
the build folder, so a wheel is what the program is made of and needs nothing from a network.

    pip wheel . --config-settings build-dir=build    takes a build folder that is built already
"""
import base64
import hashlib
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def _built(settings):
    """The folder apps/python of a build folder in which the package is built."""
    if settings and "build-dir" in settings:
        return Path(settings["build-dir"]).resolve() / "apps/python"
    build = ROOT / "build/wheel"
    options = ["-D", "EVENSTEP_BUILD_TESTS=OFF", "-D", "EVENSTEP_BUILD_BENCH=OFF",
               "-D", "EVENSTEP_PYTHON=ON", "-D", f"Python3_EXECUTABLE={sys.executable}"]
    subprocess.run(["cmake", "--preset", "release", "-B", str(build), *options], cwd=ROOT, check=True, stdout=sys.stderr)
    subprocess.run(["cmake", "--build", str(build), "--target", "evenstep_python"], check=True, stdout=sys.stderr)
    return build / "apps/python"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    built = _built(config_settings)
    info, = built.glob("evenstep-*.dist-info")
    version = info.name.removeprefix("evenstep-").removesuffix(".dist-info")
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
    ending = sysconfig.get_config_var("EXT_SUFFIX")
    files = {f"evenstep/{path.name}": path.read_bytes() for path in sorted((built / "evenstep").iterdir())
             if path.suffix in (".py", ".pyi", ".typed") or path.name in ("py.typed", "_core" + ending)}
    if f"evenstep/_core{ending}" not in files:
        raise FileNotFoundError(f"{built}/evenstep/_core{ending} is not built; cmake --build … --target evenstep_python")
    files |= {f"{info.name}/{path.name}": path.read_bytes() for path in sorted(info.iterdir())}
    files[f"{info.name}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    files[f"{info.name}/WHEEL"] = (f"Wheel-Version: 1.0\nGenerator: evenstep {version}\nRoot-Is-Purelib: false\n"
                                   f"Tag: {tag}\n").encode()
    record = "".join(f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()},"
                     f"{len(data)}\n" for name, data in files.items())
    files[f"{info.name}/RECORD"] = f"{record}{info.name}/RECORD,,\n".encode()
    name = f"evenstep-{version}-{tag}.whl"
    with zipfile.ZipFile(Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():  # without dates, so that the same files give the same wheel
            member = zipfile.ZipInfo(path)
            member.external_attr = 0o644 << 16
            wheel.writestr(member, data, zipfile.ZIP_DEFLATED)
    return name


def build_sdist(sdist_directory, config_settings=None):
    version = next(line.split()[2] for line in (ROOT / "CMakeLists.txt").read_text().splitlines()
                   if line.startswith("project(evenstep VERSION"))
    metadata = (ROOT / "apps/python/metadata.in").read_text().replace("@PROJECT_VERSION@", version)
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    name = f"evenstep-{version}"
    with tarfile.open(Path(sdist_directory) / f"{name}.tar.gz", "w:gz", format=tarfile.PAX_FORMAT) as archive:
        for path in filter(None, listed.split("\0")):
            archive.add(ROOT / path, f"{name}/{path}", recursive=False)
        about = Path(sdist_directory) / "PKG-INFO"
        about.write_text(metadata)
        archive.add(about, f"{name}/PKG-INFO")
        about.unlink()
    return f"{name}.tar.gz"
