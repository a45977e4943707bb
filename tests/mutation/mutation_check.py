"""mutation_check.py SOURCE_DIR WORK_DIR [CMAKE_ARGUMENT...] : breaks the sources on purpose, by one mutation of
mutations.txt at a time, builds the test program that is expected to notice, runs its named cases, and reports killed or
survived. Exit 1 if a mutation survived, does not compile, or no longer matches the source, or if the cases fail on the
unbroken source.

mutation_check.py SOURCE_DIR --texts [BUILD_DIR] : builds nothing; checks in a second whether each mutation still matches the
source, and whether the tests that are named with it are among those of the build.

Environment: MUTATION=PATTERN: only mutations whose names match (such as 'judge-*'). JOBS=N: N jobs at a time (default: one
per core).

Each job has a copy of the source tree under WORK_DIR with a build folder in it. Both are kept, so that nothing is built
twice. A later run writes only files that differ from the source.
"""
import filecmp
import fnmatch
import os
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

SECONDS_PER_TEST = 300


class Mutation(NamedTuple):
    name: str
    edits: list   # (file, text that occurs there exactly once, text in its place)
    test: str     # the part after test_ in the name of the program
    cases: str    # patterns of Catch2, separated by commas


def read_list(text):
    """The mutations in a list: blocks that are separated by blank lines; the first line of each is its name."""
    text = re.sub("(?m)^#.*\n", "", text)
    for name, *lines in (block.split("\n") for block in re.split("\n{2,}", text.strip("\n"))):
        found = {}
        edits = []
        for line in lines:
            key, colon, value = line.partition(":")
            if not colon or key not in ("file", "from", "to", "test", "case"):
                sys.exit(f"{name}: unknown line '{line}'")
            found[key] = value[1:]
            if key == "to":
                edits.append((found["file"], found["from"], found["to"]))
        yield Mutation(name, edits, found["test"], found["case"])


class Unfit(Exception):
    """Why a mutation does not fit the sources or the tests"""


def mutated_files(mutation, source):
    """The text of each file that the mutation changes"""
    texts = {}
    for file, old, new in mutation.edits:
        text = texts.get(file) or (source / file).read_text(encoding="utf-8")
        if text.count(old) != 1:
            raise Unfit(f"{'more than one' if old in text else 'no'} such text in {file}: {old}")
        texts[file] = text.replace(old, new)
    return texts


def check_texts(mutations, source, build):
    failed = False
    listed = None
    if build:
        listing = subprocess.run(["ctest", "--test-dir", build, "-N"], capture_output=True, text=True, check=True).stdout
        listed = re.findall(r"(?m)^ *Test *#\d+: (.*)$", listing)
    for mutation in mutations:
        try:
            mutated_files(mutation, source)
            for case in mutation.cases.split(","):
                pattern = re.compile(f"{re.escape(mutation.test)}: ?" + ".*".join(map(re.escape, case.split("*"))))
                if listed is not None and not any(map(pattern.fullmatch, listed)):
                    raise Unfit(f"no such case in {mutation.test}: {case}")
        except Unfit as why:
            print(f"ERROR {mutation.name}: {why}")
            failed = True
    print(len(mutations), "mutations")
    return 1 if failed else 0


def copy_tree(source, work, tree):
    """Makes the tree equal to the source again. Only files that differ are written, and so are built again."""
    files = set()
    for folder, folders, names in os.walk(source):
        top = Path(folder) == source
        folders[:] = [name for name in folders if name != ".git" and not (top and name.startswith("build")) and
                      Path(folder, name) != work]
        files.update(os.path.relpath(os.path.join(folder, name), source) for name in names)
    tree.mkdir(parents=True, exist_ok=True)
    record = tree / "files"
    if record.exists():
        for gone in set(record.read_text(encoding="utf-8").split("\n")) - files:
            (tree / gone).unlink(missing_ok=True)
    record.write_text("\n".join(sorted(files)), encoding="utf-8")
    for file in files:
        if not (tree / file).exists() or not filecmp.cmp(source / file, tree / file, shallow=False):
            (tree / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source / file, tree / file)


class Job:
    """One copy of the tree with a build in it"""

    def __init__(self, source, tree, configure, build_jobs):
        self.source = source
        self.tree = tree
        self.configure = configure
        self.build_jobs = build_jobs

    def run(self, mutations):
        """The verdict of each; one that does not begin with "killed" is a failure"""
        if not (self.tree / "build/build.ninja").exists():
            failed, output = self.call("cmake", "-S", ".", "-B", "build", "-G", "Ninja", *self.configure)
            if failed:
                return [self.say(f"ERROR cannot configure: {output[-300:]}")]
        verdicts = []
        for test, cases in sorted({(mutation.test, mutation.cases) for mutation in mutations}):
            verdicts += self.unbroken(test, cases)
        return verdicts + [self.say(self.mutate(mutation)) for mutation in mutations]

    def unbroken(self, test, cases):
        """The source itself must pass every case, and every case must exist."""
        failed, output = self.build_test(test)
        if failed:
            return [self.say(f"ERROR test_{test} is not built: {output[-300:]}")]
        failed, output = self.run_test(test, cases)
        if failed or re.search("No test cases matched|No tests ran", output):
            return [self.say(f"ERROR the unbroken source fails, or has not, {test}: {cases}: {first_failure(output)}")]
        return []

    def mutate(self, mutation):
        name, test, cases = mutation.name, mutation.test, mutation.cases
        try:
            changed = mutated_files(mutation, self.source)
        except Unfit as why:
            return f"ERROR {name}: {why}"
        try:
            for file, text in changed.items():
                (self.tree / file).write_text(text, encoding="utf-8")
            failed, output = self.build_test(test)
            if failed and re.search("static(_assert| assertion) failed", output):
                return f"killed {name}: {test}: a static assertion"
            if failed:
                return f"ERROR {name} is not built: {re.findall('.*error.*', output)[:2] or output[-300:]}"
            failed, output = self.run_test(test, cases)
            return f"killed {name}: {test}: {first_failure(output)}" if failed else f"SURVIVED {name}: {test}: {cases}"
        except subprocess.TimeoutExpired:
            return f"killed {name}: {test}: does not end"
        finally:
            for file in changed:
                shutil.copy(self.source / file, self.tree / file)

    def build_test(self, test):
        return self.call("ninja", "-C", "build", "-j", str(self.build_jobs), f"test_{test}")

    def run_test(self, test, cases):
        inputs = self.call("ninja", "-C", "build", "-t", "query", f"test_{test}")[1].partition("input:")[2]
        return self.call("build/" + inputs.split("\n")[1].strip(), "--abort", cases, timeout=SECONDS_PER_TEST)

    def call(self, *words, timeout=None):
        """Whether it failed, and what it said. That goes into a file, because a test may leave children that hold a pipe."""
        with open(self.tree / "output.log", "w+", encoding="utf-8", errors="replace") as log:
            status = subprocess.run(words, cwd=self.tree, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT,
                                    env={**os.environ, "POCL_CACHE_DIR": str(self.tree / "build/pocl-cache")},
                                    timeout=timeout, check=False).returncode
            log.seek(0)
            return status != 0, log.read()

    @staticmethod
    def say(verdict):
        print(verdict, flush=True)
        return verdict


def first_failure(output):
    found = re.search("(?:.*tests/)?(.*FAILED:.*)", output)
    return found[1] if found else ""


def main():
    source = Path(sys.argv[1]).resolve()
    wanted = os.environ.get("MUTATION", "*")
    listed = read_list((source / "tests/mutation/mutations.txt").read_text(encoding="utf-8"))
    mutations = [mutation for mutation in listed if fnmatch.fnmatchcase(mutation.name, wanted)]
    if not mutations:
        sys.exit(f"no mutation is called {wanted}")
    if sys.argv[2] == "--texts":
        return check_texts(mutations, source, sys.argv[3] if len(sys.argv) > 3 else None)

    work = Path(sys.argv[2]).resolve()
    processors = os.cpu_count() or 1
    jobs = min(int(os.environ.get("JOBS", processors)), len(mutations))

    def run_job(number):
        # Neighbours in the list share a test program, so each job takes a contiguous part of the list.
        part = mutations[len(mutations) * number // jobs:len(mutations) * (number + 1) // jobs]
        tree = work / f"job-{number}"
        copy_tree(source, work, tree)
        return Job(source, tree, sys.argv[3:], -(-processors // jobs)).run(part)

    with ThreadPoolExecutor(jobs) as pool:
        verdicts = [verdict for job in pool.map(run_job, range(jobs)) for verdict in job]
    killed = sum(verdict.startswith("killed") for verdict in verdicts)
    print(f"{killed} of {len(mutations)} mutations killed")
    return 0 if killed == len(mutations) == len(verdicts) else 1


sys.exit(main())
