"""The scenario that most tests here run: figure 1 on a spring, for a second."""
import pytest

SPRING = """
format = 1
name = "Figure 1 on a spring, for a second"
[run]
duration = "1 s"
warmup = "8 segments"
strategies = ["direct", "phase_locked"]
[timing]
segment = "30 Hz"
visualization = "11.1 ms"
steps = 15
step = "fill"
[scene]
solver = "cpu-double"
kind = "spring"
stiffness = "200 N/m"
step_size = "450 Hz"
[[device]]
name = "left"
driver = "reference"
rate = "1 kHz"
motion = { kind = "constant-velocity", velocity = ["0.1 m/s", "0 m/s", "0 m/s"] }
render = { kind = "force", emission = "linear" }
[remap]
latency = "minimal"
[[expect]]
signal = "left.force.phase_locked"
metric = "underruns"
equals = 0
"""


@pytest.fixture
def spring(tmp_path):
    file = tmp_path / "spring.toml"
    file.write_text(SPRING)
    return file
