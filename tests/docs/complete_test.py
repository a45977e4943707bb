#!/usr/bin/env python3
"""What can be typed or read by a program is in the docs: every option, environment variable, option of the build, exit
code and key of JSON. Both ways: what the docs name exists.

    complete_test.py PROGRAM SOURCE_DIR

The names are taken from the program and the sources, so that a new one fails here until a page says what it is for.
"""
import re
import subprocess
import sys
from pathlib import Path

PROGRAM, SOURCE = sys.argv[1], Path(sys.argv[2]).resolve()

# Options of other programs that pages name.
OTHERS_OPTIONS = set("""--allow-empty --array --build --cap-add --cflags --component --config --config-settings --coverage
--exclude --exclude-throw-branches --exclude-unreachable-branches --install --libs
--no-deps --no-install-recommends --output-on-failure --prefix --preset --requeue --resume-failed --sshlogin
--target --test-dir
--type --ulimit""".split())
# Of the repository's own scripts, test programs and examples.
OWN_OPTIONS = {"--benchmark", "--busy", "--evenstep-long", "--evenstep-set", "--svg", "--update"}
# Names in EVENSTEP_... that are no variables: ends with _ or … in the text, or what a C header defines.
NO_VARIABLES = re.compile(r"EVENSTEP_(REMAP|CL|OLDEST)_|EVENSTEP_\w*_$")

# The sections of docs/reference/json.md, and the sources whose keys they have. Keys of `json_of(PauseParts)` are in all.
JSON_OF = {
    "check": ["apps/src/commands/check.cpp", "harness/campaigns/src/cost/text.cpp",
              "reports/writers/include/evenstep/reports/json.h"],
    "list": ["apps/src/commands/list.cpp"],
    "size": ["reports/writers/files/size_json.cpp", "reports/writers/texts/size_within.cpp"],
    "advise": ["reports/writers/files/advice_json.cpp"],
    "fit": ["harness/campaigns/src/fit/json.cpp"],
    "study": ["reports/writers/texts/study.cpp", "reports/writers/texts/felt_study.cpp",
              "reports/writers/stiffness_limits.cpp", "reports/writers/texts/study_table.cpp"],
    "compare": ["reports/writers/texts/comparison.cpp"],
    "sweep": ["reports/writers/texts/sweep.cpp"],
    "catalogue": ["apps/src/commands/catalogue.cpp"],
    "devices": ["apps/src/commands/devices.cpp", "apps/src/commands/devices_opencl.cpp"],
}
# Keys that all sections may have; the head of the page says what they are.
COMMON = {"format", "file", "line", "column", "message", "signal", "metric", "value", "unit", "min", "max", "why", "name"}
# What looks like a key in a source, and is a word for a value, or of an error.
NO_KEYS = {"skip", "catalogue"}
# Words in backticks that are no keys of the section they stand in: values that other sources name, metrics, commands.
OTHER_WORDS = {"recovery_time", "stop_after", "phase_locked", "recording", "programmed", "step", "size"}
# Another page explains these keys of a section.
ELSEWHERE = {"advise": "docs/choose/advise.md"}

problems = []


def wrong(what):
    problems.append(what)


def read(path):
    return (SOURCE / path).read_text(encoding="utf-8")


def helped(*words):
    return subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=True).stdout


PAGES = {str(page.relative_to(SOURCE)): page.read_text(encoding="utf-8")
         for page in [SOURCE / "README.md", SOURCE / "CONTRIBUTING.md", *sorted(SOURCE.glob("docs/**/*.md"))]}
ALL = "\n".join(PAGES.values())


def whole(name, text):
    return re.search(r"(?<![\w-])" + re.escape(name) + r"(?![\w-])", text) is not None


def check_options():
    commands = re.findall(r"^  ([a-z]+)  ", helped("--help"), re.M)
    if len(commands) < 20:
        wrong(f"only {len(commands)} commands in --help")
    known = {"--help", "--version", "--all"}
    for command in commands:
        for option in re.findall(r"^  (?:-\w,)?(--[a-z][a-z-]*)", helped(command, "--help"), re.M):
            known.add(option)
            names_both = (page for page, text in PAGES.items()
                          if whole(option, text) and re.search(rf"(evenstep|run\.sh|`) ?{command}\b", text))
            if option != "--help" and next(names_both, None) is None:
                wrong(f"{command} {option}: no page has it together with '{command}'; say what it is for")
    for page, text in PAGES.items():
        for option in sorted(set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", text))):
            if option not in known | OTHERS_OPTIONS | OWN_OPTIONS:
                wrong(f"{page}: no command of evenstep has {option}; mend it, or add it to OTHERS_OPTIONS of this test")


def tracked(*patterns):
    out = subprocess.run(["git", "ls-files", *patterns], cwd=SOURCE, capture_output=True, text=True, check=False).stdout
    return [name for name in out.splitlines() if name]


def check_variables():
    of_program = set()
    for name in tracked("apps/*.cpp", "harness/*.cpp", "scenarios/*.cpp", "device/*.cpp", "sim/*.cpp"):
        text = read(name)
        of_program |= set(re.findall(r'(?:getenv|variable)\([^"()]*"([A-Z][A-Z_]+)"', text))
        if "getenv" in text or "nvironment" in text:
            of_program |= set(re.findall(r'"([A-Z]+(?:_[A-Z]+)+)"', text))
    of_scripts = set()
    for name in ("run.sh", "test.sh", ".ci/run", *tracked("scripts/*.sh")):
        of_scripts |= set(re.findall(r"\$\{([A-Z][A-Z0-9_]*)(?::-|:\+|-)", read(name)))
    of_build = set()
    for name in tracked("CMakeLists.txt", "cmake/*.cmake"):
        of_build |= set(re.findall(r"option\((EVENSTEP_\w+)|set\((EVENSTEP_\w+) [^\n]*CACHE", read(name)))
    of_build = {name for pair in of_build for name in pair if name}
    if len(of_program) < 15 or len(of_scripts) < 5 or len(of_build) < 9:
        wrong(f"too few variables found: {sorted(of_program)} {sorted(of_scripts)} {sorted(of_build)}")
    for name in sorted(of_program | of_scripts | of_build):
        if not whole(name, ALL):
            wrong(f"{name}: the program, a script or the build reads it, and no page says what it is for")
    kinds = "*.cpp *.h *.c *.sh *.py *.cmake *CMakeLists.txt *.in *.yml *.json .ci/run"
    sources = "\n".join(read(name) for name in tracked(*kinds.split()))
    for page, text in PAGES.items():
        for name in sorted(set(re.findall(r"\bEVENSTEP_[A-Z0-9_]+", text))):
            if not NO_VARIABLES.match(name) and not re.search(rf"\b{name}\b", sources):
                wrong(f"{page}: nothing reads {name}")


def section(title):
    found = re.search(rf"^## {title}\n(.*?)(?=^## |\Z)", PAGES["docs/reference/json.md"], re.M | re.S)
    if found is None:
        wrong(f"docs/reference/json.md has no section '{title}'")
    return found[1] if found else ""


def check_exit_codes():
    enumerators = re.search(r"enum class ExitCode[^{]*\{(.*?)\}", read("harness/include/evenstep/harness/run.h"), re.S)[1]
    codes = re.findall(r"= (\d+)", enumerators)
    in_help = re.findall(r"(?:Exit:|,) (\d+)", helped("--help").replace("\n", " "))
    in_table = re.findall(r"^\| (\d+) \|", section("Exit codes"), re.M)
    sentence = re.search(r"^Exit codes:.*?\.", read("README.md"), re.M | re.S)[0].replace("\n", " ")
    in_readme = re.findall(r"(?:Exit codes:|,) (\d+)", sentence)
    for where, found in (("--help", in_help), ("docs/reference/json.md", in_table), ("README.md", in_readme)):
        if found != codes:
            wrong(f"exit codes: {where} has {found}, the program {codes}")


def keys_of(text):
    """What a source puts into an object of JSON."""
    keys = set(re.findall(r'\{"([a-z]\w*)",\s', text))                        # {"key", value}
    keys |= set(re.findall(r'\["([a-z]\w*)"\](?:\[[^]]*\])*\s*=', text))      # out["key"] = value
    keys |= set(re.findall(r'\["([a-z]\w*)"\](?:\[[^]]*\])*\.(?:push_back|emplace)', text))
    keys |= set(re.findall(r'\bfacts\.add(?:_to_list)?\(\s*"([a-z]\w*)"', text))
    keys |= {a + b for a, b in re.findall(r'\["([a-z]\w*)" \+ suffix(?: \+ "(_ns)")?\]', text)}
    return keys - NO_KEYS


def check_json():
    head = PAGES["docs/reference/json.md"].split("\n## ")[0]
    for command, files in JSON_OF.items():
        text = section("`evenstep sweep` and `merge`" if command == "sweep" else f"`evenstep {command}`")
        sources = "\n".join(read(file) for file in files)
        keys = keys_of(sources)
        if len(keys) < 5:
            wrong(f"{command}: only the keys {sorted(keys)} are found in {files}")
        explained = set(re.findall(r"`([^`\n]+)`", text))
        also = set(re.findall(r"`([^`\n]+)`", PAGES[ELSEWHERE[command]])) if command in ELSEWHERE else set()
        common = {key for key in COMMON if key in head or key in ("format", "name", "why")}
        for key in sorted(keys - explained - also - common):
            wrong(f"docs/reference/json.md, {command}: `{key}` is printed by {' or '.join(files)}; say what it is")
        for word in sorted(explained - keys):
            if re.fullmatch(r"[a-z]\w*", word) and f'"{word}"' not in sources and word not in OTHER_WORDS:
                wrong(f"docs/reference/json.md, {command}: nothing prints `{word}`")


check_options()
check_variables()
check_exit_codes()
check_json()
print("\n".join(problems) or "ok")
sys.exit(1 if problems else 0)
