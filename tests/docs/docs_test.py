#!/usr/bin/env python3
"""Every fenced block of README.md, ARCHITECTURE.md and the pages of docs/, run or checked.

    docs_test.py PROGRAM SOURCE_DIR BUILD_DIR PAGE          one page, without what exceptions.txt calls long
    docs_test.py PROGRAM SOURCE_DIR BUILD_DIR PAGE --long   its long commands, with their output
    docs_test.py PROGRAM SOURCE_DIR BUILD_DIR --exceptions  that each exception is needed, how many there are, and
                                                            how many words a page has

The word after the fence says what a block is:
    console   lines with "$ " are commands of one shell; the lines after a command are its stdout or its stderr, never a
              mixture. "..." stands for any lines.
              A command must exit with 0, unless the next one is "echo $?".
    sh        commands, one a line, each by itself. They must exit with 0; their comments are not compared.
    toml      a scenario; with "format" missing, a part that is added to one. `evenstep check` must accept it. A word after
              "toml" is the file it is written to, for the commands below it.
    cpp, c, python, csharp   lines that stand somewhere in the sources as they are here; the first one may name the file.
    cmake     a call whose functions exist in cmake/.
    json      lines of JSON.
    text      a picture, or the format of a file: nothing to run.
exceptions.txt lists the commands that are treated in another way, each with its reason:
    parsed     it is not run; its command, options and files must exist. A block of toml, named by its first line, is only
               parsed.
    long       it runs in a test of its own.
    fails      it runs, and must exit with 1.
    elsewhere  another test runs the blocks of this page. The command is *, the reason is the file of that test.
The page * means all pages, and then the command means all commands that begin with it.
"""
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
KINDS = {"parsed", "long", "fails", "elsewhere"}
MOST_WORDS, MOST_WORDS_OF_ALL = 4000, 85000
LOOKED_UP = ("docs/reference/scenario-format.md", "docs/reference/metrics.md")
EXPECTED_EXCEPTIONS = 70  # a new one needs a reason and this number


def fenced_blocks(page):
    """(line, info, lines) of each block."""
    lines = page.read_text(encoding="utf-8").split("\n")
    at = 0
    while at < len(lines):
        fence = re.match(r"^( *)```(.*)$", lines[at])
        if fence:
            end = next(i for i in range(at + 1, len(lines)) if lines[i].strip() == "```")
            yield at + 1, fence[2].strip(), [line[len(fence[1]):] for line in lines[at + 1:end]]
            at = end
        at += 1


def exceptions():
    """{(page, command): (kind, reason)}; the file has "page | kind | command | reason" on each line."""
    known = {}
    for line in (HERE / "exceptions.txt").read_text(encoding="utf-8").splitlines():
        if line.strip() and not line.startswith("#"):
            page, kind, command, reason = (part.strip() for part in line.split(" | "))
            if kind not in KINDS or not reason:
                sys.exit(f"exceptions.txt: '{line}' needs a kind of {KINDS}, and a reason")
            known[page, command] = kind, reason
    return known


def commands_of(info, lines):
    """[(command, expected output)] of a console or sh block; of toml the first line, which may be an exception."""
    found = []
    for line in lines:
        if info == "sh":
            command = re.sub(r"\s+#\s.*$", "", line).strip()
            if command and not command.startswith("#"):
                found.append((command, None))
        elif info == "toml":
            return [(line, None)]
        elif line.startswith("$ "):
            found.append((line[2:], []))
        elif found:
            found[-1][1].append(line)
    return found


class Page:
    def __init__(self, program, source, build, name, long):
        self.program, self.source, self.build, self.name, self.long = program, source, build, name, long
        self.problems = []
        self.except_ = exceptions()
        self.place = Path(tempfile.mkdtemp(prefix="evenstep docs "))
        self.work = self.place / "evenstep"
        self.environment = dict(os.environ, PATH=f"{self.place / 'bin'}:{os.environ['PATH']}", NO_COLOR="1",
                                CMAKE_PREFIX_PATH=str(self.place),
                                POCL_CACHE_DIR=str(build / "pocl-cache"), XDG_CACHE_HOME=str(self.place / "cache"),
                                LC_ALL="C.UTF-8")
        for variable in ("GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY", "EVENSTEP_CALLED_AS"):
            self.environment.pop(variable, None)

    def kind_of(self, command):
        for (page, known), (kind, _) in self.except_.items():
            if (page == self.name and known == command) or (page == "*" and command.startswith(known)):
                return kind
        return "run"

    def wrong(self, line, what):
        self.problems.append(f"{self.name}:{line}: {what}")

    def set_up(self):
        """A clone in which run.sh need not build, and files that the page's reader would have."""
        (self.place / "bin").mkdir()
        (self.place / "bin" / "evenstep").symlink_to(self.program)
        self.work.mkdir()
        for name in ("scenarios", "scripts", "docs", "tests", "examples", "README.md", "cmake"):
            if (self.source / name).exists():
                (self.work / name).symlink_to(self.source / name)
        shutil.copy(self.source / "run.sh", self.work / "run.sh")
        (self.work / "run.sh").write_text('#!/bin/sh\nEVENSTEP_CALLED_AS=$0 exec evenstep "$@"\n')
        package = self.place / "lib/cmake/evenstep/evenstepConfig.cmake"  # what find_package would find
        package.parent.mkdir(parents=True)
        package.write_text(f"""add_executable(evenstep::evenstep IMPORTED)
set_target_properties(evenstep::evenstep PROPERTIES IMPORTED_LOCATION "{self.program}")
include("{self.source}/cmake/EvenstepScenarios.cmake")
""")
        (self.work / "long").mkdir()
        for name in ("timing.csv", "long/timing.csv"):  # docs/choose/advise.md has a longer second one, which takes half a minute
            shutil.copy(self.source / "scenarios/recorded/small-paced30-basic.csv", self.work / name)
        mine = next(lines for _, info, lines in fenced_blocks(self.source / "README.md") if info == "toml")
        (self.work / "my.toml").write_text("\n".join(mine) + "\n")

    # --- toml ---------------------------------------------------------------------------------------------------------

    def check_toml(self, line, info, lines):
        text = "\n".join(lines) + "\n"
        if self.kind_of(lines[0]) == "parsed":
            tomllib.loads(text)
            return
        named = info.split()[1:]
        if "format" not in re.findall(r"^\w+", text.split("[")[0], re.M):
            base = self.work / "base.toml"  # what a part of a scenario on this page belongs to
            if not base.exists():
                base = self.work / "scenarios/paper/figure-1-spring.toml"
            head = f'format = 1\nextends = ["{base}"]\nname = "a part"\n'
            text = head + text
        file = self.shell_folder() / named[0] if named else self.work / "block.toml"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        done = subprocess.run([self.program, "check", file], env=self.environment, cwd=self.work, text=True,
                              capture_output=True, check=False)
        if done.returncode > (1 if named else 0):
            self.wrong(line, f"`evenstep check` exits with {done.returncode}:\n{done.stderr}{done.stdout[-500:]}")

    # --- cpp ----------------------------------------------------------------------------------------------------------

    def check_cpp(self, line, lines):
        def bare(text):
            return re.sub(r"[\s/+]+", "", text)
        if not hasattr(Page, "sources"):
            tracked = subprocess.run(["git", "ls-files", "*.h", "*.cpp", "*.c", "*.py", "*.cs", "*.patch"], cwd=self.source, text=True,
                                     capture_output=True, check=False).stdout.split("\n")
            files = [self.source / name for name in tracked if name] or \
                [file for room in self.source.iterdir() if room.is_dir() and room.name != "build"
                 for ending in ("h", "cpp", "c", "py", "cs", "patch") for file in room.rglob("*." + ending)]
            Page.sources = "\n".join(bare(file.read_text(encoding="utf-8")) for file in files if file.exists())
        for offset, text in enumerate(lines):
            file = re.match(r"^(?://|#|/\*) ([\w/]+\.\w+)(?: \*/)?$", text)
            if file and offset == 0:
                if not (self.source / file[1]).exists():
                    self.wrong(line + 1, f"no such file: {file[1]}")
            elif bare(text) and bare(text) not in Page.sources:
                self.wrong(line + 1 + offset, f"no source has this line: {text.strip()}")

    # --- commands -----------------------------------------------------------------------------------------------------

    def start_shell(self):
        self.shell = subprocess.Popen(["bash"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                      cwd=self.work, env=self.environment, text=True, bufsize=1)

    def in_shell(self, command):
        """The status, stdout and stderr of a command, in the one shell of the page."""
        mark = "==docs=="
        self.shell.stdin.write(f"(exit ${{docs_status:-0}})\n{{ {command}\n}} </dev/null 2>'{self.place}/stderr'\n"
                               f"docs_status=$?; printf '{mark}%s\\n' $docs_status\n")
        self.shell.stdin.flush()
        output = []
        for line in self.shell.stdout:
            before, found, status = line.rstrip("\n").partition(mark)
            if before or not found:
                output.append(before)
            if found:
                return int(status), output, (self.place / "stderr").read_text(errors="replace").splitlines()
        return -1, output, []

    def shell_folder(self):
        if not hasattr(self, "shell"):
            return self.work
        return Path(self.in_shell("pwd")[1][0])

    def matches(self, expected, output):
        """Whether the output is what the page says, line by line; "..." stands for any number of lines, and in a line for
        any text. White space in a row counts as one blank."""
        def pattern(line):
            return r"\s+".join(re.escape(word).replace(r"\.\.\.", ".*") for word in line.split())
        expression = ""
        for line in expected:
            expression += r"(?:[^\n]*\n)*?" if line.strip() == "..." else r"\s*" + pattern(line) + r"[ \t]*\n"
        return re.fullmatch(expression, "".join(line + "\n" for line in output)) is not None

    def run_command(self, line, command, expected, wanted):
        status, output, errors = self.in_shell(command)
        shown = "\n".join(output[-40:] + errors[-40:])
        if wanted not in (None, status):
            self.wrong(line, f"exit {status}: {command}\n{shown}")
        elif expected is not None and expected != [] and not any(self.matches(expected, text) for text in (output, errors)):
            self.wrong(line, f"prints something else: {command}\n{shown}")

    def parse_command(self, line, command):
        """Checks that the command, its options and its files exist."""
        words = shlex.split(command, comments=True)
        while words and re.match(r"^\w+=", words[0]):
            words.pop(0)
        if words[0] in ("./run.sh", "evenstep"):
            if len(words) == 1:
                return
            done = subprocess.run([self.program, words[1], "--help"], env=self.environment, text=True, capture_output=True,
                                  check=False)
            if done.returncode != 0:
                self.wrong(line, f"no such command of evenstep: {command}")
            for option in (word.split("=")[0] for word in words[2:] if word.startswith("--")):
                if not re.search(re.escape(option) + r"\b", done.stdout):
                    self.wrong(line, f"no such option of {words[1]}: {option}")
            files = [word for word in words[2:] if re.match(r"^[\w./-]+\.(toml|csv)$|^scenarios/", word)]
        elif words[0] == "./test.sh":
            files = []
            if words[1:]:
                listed = subprocess.run(["ctest", "--test-dir", self.build, "-N", *words[1:]], text=True, capture_output=True,
                                        check=False).stdout
                if "Total Tests: 0" in listed or "Total Tests" not in listed:
                    self.wrong(line, f"ctest has no such test: {command}")
        else:
            files = [words[0]]
            if words[0] in ("cmake", "ctest", "ninja") or words[0].startswith("build/"):  # built only where its packages are
                files = [word for word in words[1:] if re.match(r"^[\w./-]+\.(toml|csv|py)$", word)]
        for file in files:
            if not (self.work / file).exists() and not (self.source / file).exists():
                self.wrong(line, f"no such file: {file}")

    def check_commands(self, line, info, lines):
        found = commands_of(info, lines)
        for i, (command, expected) in enumerate(found):
            kind = self.kind_of(command)
            wanted = 1 if kind == "fails" else None if i + 1 < len(found) and found[i + 1][0] == "echo $?" else 0
            if kind == "parsed":
                if not self.long:
                    self.parse_command(line, command)
            elif (kind == "long") == self.long:
                self.run_command(line, command, expected, wanted)
            elif kind == "long":
                self.parse_command(line, command)

    def run(self):
        elsewhere = self.except_.get((self.name, "*"))
        if elsewhere:
            test = self.source / elsewhere[1]
            if not test.exists() or Path(self.name).name not in test.read_text(encoding="utf-8"):
                self.wrong(1, f"{elsewhere[1]} is no test of this page")
            return self.problems
        self.set_up()
        self.start_shell()
        for line, info, lines in fenced_blocks(self.source / self.name):
            kind = info.split()[0] if info else ""
            if kind in ("console", "sh"):
                self.check_commands(line, kind, lines)
            elif self.long or kind == "text":
                continue
            elif kind == "json":
                for text in lines:
                    json.loads(text)
            elif kind == "toml":
                self.check_toml(line, info, lines)
            elif kind == "cmake":
                functions = "".join(file.read_text() for file in sorted((self.source / "cmake").glob("*.cmake")))
                for name in re.findall(r"\bevenstep_\w+(?=\()", "\n".join(lines)):
                    if f"function({name})" not in functions:
                        self.wrong(line, f"no such function in cmake/: {name}")
            elif kind in ("cpp", "c", "python", "csharp"):
                self.check_cpp(line, lines)
            else:
                self.wrong(line, f"a block of '{info}': write console, sh, toml, cpp, cmake or text after the fence "
                                 "(tests/docs/docs_test.py says what is checked in each)")
        self.shell.stdin.close()
        self.shell.wait()
        shutil.rmtree(self.place, ignore_errors=True)
        return self.problems


def pages(source):
    return [str(page.relative_to(source)) for glob in ("*.md", "docs/**/*.md") for page in sorted(source.glob(glob))]


def check_words(source):
    """Pages are short enough to be read: the two that are looked things up in excepted, and all of them together."""
    words = {page: len((source / page).read_text(encoding="utf-8").split()) for page in pages(source) if page.startswith("docs/")}
    problems = [f"{page}: {count} words; a page has at most {MOST_WORDS}, so split it or say it in fewer"
                for page, count in words.items() if count > MOST_WORDS and page not in LOOKED_UP]
    if sum(words.values()) > MOST_WORDS_OF_ALL:
        problems.append(f"docs/ has {sum(words.values())} words; at most {MOST_WORDS_OF_ALL}: say what is new in fewer, or "
                        "leave out what a command prints by itself or another page says")
    return problems


def check_exceptions(source):
    known = exceptions()
    there = [(page, "*") for page in pages(source)]
    there += [(page, command) for page in pages(source) for _, info, lines in fenced_blocks(source / page)
             for command, _ in commands_of(info.split()[0] if info else "", lines)]
    problems = [f"{page}: no such command any more: {command}" for page, command in known
                if not any(command == is_there[1] and page == is_there[0] or
                           page == "*" and is_there[1].startswith(command) for is_there in there)]
    if len(known) != EXPECTED_EXCEPTIONS:
        problems.append(f"{len(known)} exceptions instead of {EXPECTED_EXCEPTIONS}; a new one needs a reason, and that number")
    return problems


def main():
    program, source, build, page = Path(sys.argv[1]), Path(sys.argv[2]).resolve(), Path(sys.argv[3]), sys.argv[4]
    if page == "--exceptions":
        problems = check_exceptions(source) + check_words(source)
    else:
        problems = Page(program, source, build, page, "--long" in sys.argv[5:]).run()
    print("\n".join(problems) or "ok")
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
