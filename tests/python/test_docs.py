"""The blocks of docs/parts/python.md: those of Python run one after the other, and the commands print what the page says."""
import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

PAGE = Path("docs/parts/python.md")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.M | re.S)


def test_every_block_is_one_of_these():
    assert {kind for kind, _ in BLOCKS} == {"python", "console"} and len(BLOCKS) > 6


def test_the_blocks_of_python_run():
    names = {}
    for number, (kind, text) in enumerate(BLOCKS):
        if kind == "python":
            assert "assert " in text or number == 0, text
            exec(compile(text, f"{PAGE}, block {number}", "exec"), names)  # pylint: disable=exec-used


def test_the_commands_print_what_the_page_says(tmp_path):
    (tmp_path / "python3").symlink_to(sys.executable)
    environment = dict(os.environ, PATH=f"{tmp_path}:{os.environ['PATH']}")
    for kind, text in BLOCKS:
        if kind != "console":
            continue
        command, *expected, asked, status = text.splitlines()
        assert command.startswith("$ ") and asked == "$ echo $?"
        done = subprocess.run(command[2:], shell=True, capture_output=True, text=True, env=environment, check=False)
        pattern = "".join(r"(?:.*\n)*?" if line == "..." else re.escape(line).replace(r"\.\.\.", ".*") + r"\n"
                          for line in expected)
        assert re.fullmatch(pattern, done.stdout), done.stdout + done.stderr
        assert done.returncode == int(status)


def test_the_options_of_size_are_those_of_the_page_of_the_command():
    """Every option of size() is one of `evenstep size`, or a key of a list there."""
    helped = subprocess.run([os.environ["EVENSTEP_PROGRAM"], "size", "--help"], capture_output=True, text=True, check=True).stdout
    evenstep = importlib.util.find_spec("evenstep")
    source = Path(evenstep.origin).with_name("_runs.py").read_text(encoding="utf-8")
    said = source[source.index("options: those of `evenstep size --help`"):source.index("of a scenario set=")]
    options = set(re.findall(r"\b(\w+)=", said)) | set("segment visualization step step_begin process preset steps".split())
    assert len(options) > 15
    for option in options:
        assert "--" + option.replace("_", "-") in helped, option
