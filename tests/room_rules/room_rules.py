"""room_rules.py ROOT : tests what each room may contain, as far as the compiler cannot refuse it.

It prints every violation as file:line: [rule] text, and exits with 1 if there is any. First every rule is tried on a planted
violation and on the same text in a place where it is allowed. If a rule does not notice the first or complains about the
second, the test fails, too.
"""
import posixpath
import re
import sys
from collections import Counter, defaultdict
from pathlib import Path
from typing import NamedTuple

# A room that is inside another one comes before it.
PRODUCT = ("clock remap scheduler sim/catalogue sim/draw sim device scenarios/reader/text scenarios/reader/recordings "
           "scenarios/reader/plugins scenarios/reader/format harness/loop harness/campaigns harness reports/pages reports "
           "apps").split()
TOPS = sorted({room.split("/")[0] for room in PRODUCT} | set("tests bench examples cmake docs scripts CMakeLists.txt "
                                                            "CMakePresets.json README.md".split()))
SOURCE = r"\.(h|hpp|cpp|cl)$"
HASHED = f"^({'|'.join(room for room in PRODUCT if room not in ('clock', 'apps'))})/.*{SOURCE}"
NOWHERE = "^$"
SIDE_BY_SIDE = 25


class Rule(NamedTuple):
    """All are regular expressions; the first two are about a file's path below the root."""
    name: str
    files: str
    allowed: str
    forbidden: str
    comments: bool = False   # whether it looks at line comments, too


RULES = {
    "OpenCL": Rule("OpenCL only in sim/opencl", SOURCE, "^sim/opencl/", r'# *include *[<"]CL/'),
    "hidapi": Rule("hidapi only in its transport", SOURCE, "^(device/src/hid/hidapi_library|tests/fake_hidapi/)",
                   r'# *include *[<"]hidapi/'),
    # A clock of evenstep has a sleep_until(), too (scheduler/blocking_clock.h), so those of std are recognized by their
    # namespace.
    "clock": Rule("OS clock only in clock", SOURCE, "^(clock/|tests/|examples/|bench/device_tick)",
                  r"\b(clock_gettime|clock_nanosleep|nanosleep|usleep|steady_clock|system_clock|high_resolution_clock)\b"
                  r"|\bthis_thread::sleep_(for|until)\b|\bnamespace\b.*\bthis_thread\b"),
    "threads": Rule("threads only in live lanes, parallel loops, row files, senders and two benchmarks", SOURCE,
                    "^(scheduler/src/(live_lanes|parallel_for)|reports/src/rows/row_files|bench/(device_tick|own_lane)"
                    "|device/src/live_sender|device/src/inverse3/inverse3_socket|tests/|examples/)",
                    r"\b(std::(jthread|thread|async)|pthread_create)\b"),
    "random": Rule("own random numbers", SOURCE, NOWHERE, r"\bstd::([a-z_]+_distribution|random_device)\b|\brand *\("),
    "unordered": Rule("no unordered containers where things are hashed", HASHED, NOWHERE, r"\bstd::unordered_"),
    "headers": Rule("public headers keep foreign libraries out", "^[a-z/]*include/evenstep/", NOWHERE,
                    r'# *include *[<"](CL/|hidapi/|toml|spdlog|boost/)'),
    "fast math": Rule("no fast math", rf"(CMakeLists\.txt|\.cmake|CMakePresets\.json|\.sh)$|^sim/.*{SOURCE}", NOWHERE,
                      "-ffast-math|-Ofast|-funsafe-math|-fassociative-math|-cl-fast-relaxed-math|-cl-unsafe-math"),
    "loaders": Rule("own loaders only", SOURCE, "^(clock/time/src/library_on_demand|scenarios/reader/plugins/src/library|tests/)",
                    r"\bdlopen *\("),
    "processes": Rule("processes only in plugins and of pairs", SOURCE,
                      "^(scenarios/reader/plugins/src/child|harness/campaigns/src/cost/pairs|tests/)",
                      r"\b(v?fork|posix_spawnp?|exec[vl][pe]*|popen|std::system) *\("),
    "sockets": Rule("sockets only in the link to a service and the scope", SOURCE,
                    "^(device/src/inverse3/inverse3_socket|apps/src/live/scope_server|tests/)",
                    r'# *include *[<"](boost/(asio|beast)|sys/socket)'),
    "unfinished": Rule("no unfinished work", "", NOWHERE, r"\b(TODO|FIXME|XXX)\b", comments=True),
    "Python": Rule("Python only in apps/python", SOURCE, "^apps/python/src/", r'# *include *[<"](pybind11/|Python\.h)'),
    "OpenGL": Rule("OpenGL only in draw", SOURCE, "^sim/draw/src/", r'# *include *[<"](EGL|GLES[0-9]|GL)/'),
    "Catch2": Rule('Catch2 only as #include "catch.h", which has what versions 2 and 3 share', SOURCE, r"^tests/catch\.h$",
                   r'# *include *[<"]catch2/|\bCatch::Matchers::'),
}


def read_tree(root):
    """Path and text of each file that the rules look at. This folder is left out, as it names what it forbids."""
    paths = [path for top in TOPS for path in [root / top, *(root / top).rglob("*")] if path.is_file()]
    texts = {str(path.relative_to(root)): path.read_bytes() for path in paths}
    return {name: text.decode(errors="replace") for name, text in sorted(texts.items())
            if b"\0" not in text and not name.startswith("tests/room_rules/")}


def without_comments(path, text):
    if re.search(SOURCE, path):
        return re.sub("//.*", "", text)
    if re.search(r"(/|^)CMakeLists\.txt$|\.(cmake|sh)$", path):
        return re.sub("#.*", "", text)
    return text


def violations(rule, tree):
    forbidden = re.compile(rule.forbidden)
    for path, text in tree.items():
        if not re.search(rule.files, path) or re.search(rule.allowed, path) or not forbidden.search(text):
            continue
        for number, line in enumerate((text if rule.comments else without_comments(path, text)).split("\n"), 1):
            if forbidden.search(line):
                yield f"{path}:{number}: [{rule.name}] {line}"


def headers_without_opening(tree):
    """A public header says what it is before anything else."""
    for path, text in tree.items():
        if re.search(r"^[a-z/]*include/evenstep/.*\.h$", path):
            first, second, *_ = text.split("\n") + [""]
            if first != "#pragma once":
                yield f"{path}:1: [header opening] must be #pragma once"
            if not second.startswith("/// "):
                yield f"{path}:2: [header opening] must be a /// comment that says what this is"


def room_of(path):
    return next((room for room in PRODUCT if path.startswith(room + "/")), None)


def rooms_too_large(tree):
    """Rooms with more than a fifth of the lines of the product's sources, because such a room is several rooms in one."""
    held = defaultdict(int)
    for path, text in tree.items():
        if re.search(SOURCE, path):
            held[room_of(path)] += text.count("\n")
    total = sum(lines for room, lines in held.items() if room)
    for room in PRODUCT:
        if 5 * held[room] > total:
            yield f"{room}:1: [size of a room] {held[room]} of {total} lines: more than a fifth"


def names_in_two_rooms(tree):
    """Headers that have the name of a header in another room, the folders below the room included. A reader of `#include
    "src/name.h"` should not have to ask which header that is."""
    rooms = defaultdict(set)
    for path in tree:
        if path.endswith(".h") and room_of(path):
            rooms[re.sub(r"^(src/|include/evenstep/\w+/)", "", path[len(room_of(path)) + 1:])].add(room_of(path))
    for name, found in rooms.items():
        if len(found) > 1:
            yield f"{min(found)}:1: [one name, one header] {name} is in {', '.join(sorted(found))}"


def folders_too_full(tree):
    """Folders with so many sources side by side that a reader does not find one any more: they are several things."""
    held = Counter(posixpath.dirname(path) for path in tree if re.search(r"\.(h|c|cpp|cl)$", path))
    for folder, sources in sorted(held.items()):
        if sources > SIDE_BY_SIDE:
            yield f"{folder}:1: [size of a folder] {sources} sources side by side: more than {SIDE_BY_SIDE}"


def headers_of_other_rooms(tree):
    """A room inside another one has its private headers to itself, although the compiler would find them from outside."""
    for path, text in tree.items():
        if room_of(path) and re.search(SOURCE, path):
            for number, line in enumerate(text.split("\n"), 1):
                if re.search(r'# *include *"[^"]+/src/', line):
                    yield f"{path}:{number}: [private headers] {line}"


def sources_that_nothing_builds(tree):
    """A test in a file that no CMake list names would never run."""
    built = []
    for path, text in tree.items():
        if path.endswith(("CMakeLists.txt", ".cmake")):
            for word in re.findall(r'[^\s()"]+\.cpp\b', text):
                word = re.sub(r"\$\{(CMAKE|PROJECT)_SOURCE_DIR\}", "", word.replace("${CMAKE_CURRENT_SOURCE_DIR}/", ""))
                folder = "" if word.startswith("/") else posixpath.dirname(path)
                word = posixpath.normpath(posixpath.join(folder, word.lstrip("/")))
                built.append(re.sub(r"\\\$\\\{\w+\\\}", "[^/]*", re.escape(word)))   # a variable may be anything
    built = re.compile("|".join(built) or "$.")
    for path in tree:
        if path.endswith(".cpp") and not built.fullmatch(path):
            yield f"{path}:1: [every source is built] no CMake list names it"


# What proves a rule: a text; paths where it is seen; paths where it is not.
CLOCK = ("scheduler/src/scheduler.cpp",), ("clock/src/wall_clock.cpp", "tests/clock/wall_test.cpp",
                                           "examples/embed/embed.cpp")
THREADS = ("harness/src/run.cpp",), ("scheduler/src/parallel_for.cpp", "scheduler/src/live_lanes.cpp",
                                     "device/src/live_sender.h", "tests/scheduler/lanes_test.cpp",
                                     "examples/embed/embed.cpp")
RANDOM = ("scheduler/src/random.cpp", "tests/sim/solver_test.cpp"), ()
HEADERS = ("harness/include/evenstep/harness/a.h", "clock/time/include/evenstep/time/a.h"), ("harness/src/a.cpp",)
PROCESSES = ("harness/src/run.cpp",), ("scenarios/reader/plugins/src/child_start.cpp",)
SOCKETS = ("device/src/hid/hidapi_transport.cpp",), ("device/src/inverse3/inverse3_socket.cpp",)
WORDS = ("sim/src/solver.cpp", "docs/reference/metrics.md"), ()
PROOFS = [
    ("OpenCL", "#include <CL/cl.h>", ["sim/src/solver.cpp"], ["sim/opencl/tissue_solver.cpp"]),
    ("OpenCL", '#  include "CL/opencl.hpp"', ["harness/src/run.cpp"], []),
    ("OpenCL", "// as #include <CL/cl.h> would", [], ["sim/src/solver.cpp"]),
    ("hidapi", "#include <hidapi/hidapi.h>", ["device/src/hid/reference_driver.cpp"], ["device/src/hid/hidapi_library.h"]),
    *(("clock", call, *CLOCK) for call in [
        "clock_gettime(CLOCK_MONOTONIC, &t);", "clock_nanosleep(0, 0, &t, 0);", "nanosleep(&t, 0);",
        "std::chrono::steady_clock::now();", "std::chrono::system_clock::now();",
        "std::chrono::high_resolution_clock::now();", "std::this_thread::sleep_for(t);",
        "std::this_thread::sleep_until(t);", "using std::this_thread::sleep_for;", "using namespace std::this_thread;",
        "namespace here = std::this_thread;", "usleep(1);"]),
    ("clock", "clock.sleep_until(at);", [], ["scheduler/src/stepped_thread.cpp"]),
    *(("threads", call, *THREADS) for call in [
        "std::thread t(f);", "std::jthread t(f);", "std::async(f);", "pthread_create(&t, 0, f, 0);"]),
    ("threads", "std::this_thread::get_id();", [], ["scheduler/src/scheduler.cpp"]),
    *(("random", call, *RANDOM) for call in [
        "std::normal_distribution<double> d;", "std::uniform_int_distribution<int> d;", "std::random_device d;",
        "int i = rand();"]),
    ("random", "int i = my_rand();", [], ["scheduler/src/random.cpp"]),
    ("unordered", "std::unordered_map<int, int> m;",
     [f"{room}/src/a.cpp" for room in PRODUCT if room not in ("clock", "apps")] + ["remap/include/evenstep/remap/a.h",
                                                                                  "sim/cpu/a.cpp"], []),
    ("unordered", "std::unordered_set<int> s;", [], ["apps/main.cpp"]),
    *(("headers", f"#include <{name}>", *HEADERS) for name in [
        "CL/cl.h", "hidapi/hidapi.h", "toml++/toml.h", "spdlog/spdlog.h", "boost/asio.hpp"]),
    ("fast math", "add_compile_options(-O2 -ffast-math)", ["CMakeLists.txt"], []),
    ("fast math", 'set(CMAKE_CXX_FLAGS "-Ofast")', ["cmake/Options.cmake"], []),
    ("fast math", 'program.build("-cl-fast-relaxed-math");', ["sim/opencl/tissue_solver.cpp"], []),
    ("fast math", "# without -ffast-math", [], ["CMakeLists.txt"]),
    ("loaders", 'void* library = dlopen("x.so", RTLD_NOW);', ["harness/src/run.cpp"], ["scenarios/reader/plugins/src/library.cpp"]),
    *(("processes", call, *PROCESSES) for call in [
        "pid_t child = fork();", "execve(program, words, environ);", "posix_spawn(&child, path, 0, 0, 0, 0);",
        'popen("ls", "r");', 'std::system("ls");']),
    *(("sockets", f"#include <{name}>", *SOCKETS) for name in [
        "boost/asio/ip/tcp.hpp", "boost/beast/websocket.hpp", "sys/socket.h"]),
    ("sockets", "#include <boost/math/distributions/beta.hpp>", [], ["reports/src/a.cpp"]),
    *(("unfinished", f"// {word}: later", *WORDS) for word in ["TODO", "FIXME", "XXX"]),
    ("unfinished", "// MAXXXX", [], ["sim/src/solver.cpp"]),
    ("Python", "#include <pybind11/numpy.h>", ["harness/src/run.cpp", "apps/src/output.cpp"], ["apps/python/src/runs.cpp"]),
    ("Python", "#include <Python.h>", ["sim/src/solver.cpp"], []),
    ("OpenGL", "#include <GLES3/gl3.h>", ["harness/src/parts/visualization.cpp"], []),
    ("OpenGL", "#include <EGL/egl.h>", [], ["sim/draw/src/gl_library.h"]),
    *(("Catch2", line, ["tests/sim/solver_test.cpp", "tests/scheduler/rig.h"], ["tests/catch.h"]) for line in [
        "#include <catch2/catch.hpp>", "#include <catch2/catch_all.hpp>", "using Catch::Matchers::Contains;"]),
    ("Catch2", '#include "catch.h"', [], ["tests/sim/solver_test.cpp"]),
]


def faults_of_rules():
    """What is wrong with the rules themselves."""
    for key, text, seen, unseen in PROOFS:
        for path in [*seen, *unseen]:
            if bool(list(violations(RULES[key], {path: text}))) != (path in seen):
                yield f"rule '{RULES[key].name}' should be {'seen' if path in seen else 'unseen'}: {path}: {text}"
    for key in RULES.keys() - {key for key, _, seen, _ in PROOFS if seen}:
        yield f"rule '{RULES[key].name}' has no planted violation"

    header = "sim/include/evenstep/sim/a.h"
    if list(headers_without_opening({header: "#pragma once\n/// A thing."})):
        yield "the header rule refuses a good header"
    for text in ["/// A thing.\n#pragma once", "#pragma once\n#include <a>", "#ifndef A_H\n/// A thing."]:
        if not list(headers_without_opening({header: text})):
            yield f"the header rule does not see: {text!r}"

    equal = {f"{room}/a.cpp": "a\nb\n" for room in PRODUCT}
    if list(rooms_too_large(equal)):
        yield "the rule on sizes refuses rooms of equal size"
    if not str(*rooms_too_large({**equal, "sim/a.cpp": "a\n" * 9})).startswith("sim:"):
        yield "the rule on sizes does not see a room of more than a fifth"

    if list(names_in_two_rooms({"sim/src/a.h": "", "sim/b.h": "", "harness/src/b.cpp": "", "tests/sim/a.h": ""})):
        yield "the rule on names refuses headers of one room"
    if not list(names_in_two_rooms({"sim/src/a.h": "", "harness/src/a.h": ""})):
        yield "the rule on names does not see two headers of one name"
    if list(names_in_two_rooms({"sim/src/a/b.h": "", "harness/src/b.h": ""})):
        yield "the rule on names refuses headers in folders of different names"

    full = {f"sim/src/{number}.cpp": "" for number in range(SIDE_BY_SIDE)}
    if list(folders_too_full({**full, "sim/src/a/b.h": "", "sim/src/a.md": ""})):
        yield "the rule on folders refuses one that is not too full"
    if not list(folders_too_full({**full, "sim/src/a.h": ""})):
        yield "the rule on folders does not see one source too many"

    if list(headers_of_other_rooms({"sim/src/a.cpp": '#include "src/b.h"', "tests/a.cpp": '#include "sim/src/b.h"'})):
        yield "the rule on private headers refuses a room's own"
    if not list(headers_of_other_rooms({"sim/src/a.cpp": '#include "draw/src/b.h"'})):
        yield "the rule on private headers does not see those of another room"

    lists = {"sim/CMakeLists.txt": "room(sim SOURCES a.cpp ../b.cpp ${CMAKE_SOURCE_DIR}/c/d.cpp ${name}_e.cpp)"}
    if list(sources_that_nothing_builds({**lists, "sim/a.cpp": "", "b.cpp": "", "c/d.cpp": "", "sim/x_e.cpp": ""})):
        yield "the rule on sources refuses one that is built"
    for path in ["sim/b.cpp", "a.cpp", "sim/c/a.cpp", "sim/x_f.cpp", "sim/aXcpp.cpp"]:
        if not list(sources_that_nothing_builds({**lists, path: ""})):
            yield f"the rule on sources does not see that nothing builds {path}"


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: room_rules.py ROOT")
    tree = read_tree(Path(sys.argv[1]))
    faults = list(faults_of_rules())
    if len(tree) < 50:
        faults.append(f"no source tree at {sys.argv[1]}")
    for rule in RULES.values():
        faults += violations(rule, tree)
    faults += [*headers_without_opening(tree), *rooms_too_large(tree), *names_in_two_rooms(tree),
               *folders_too_full(tree), *headers_of_other_rooms(tree), *sources_that_nothing_builds(tree)]
    if faults:
        sys.exit("\n".join(faults))
    print(f"room_rules: {len(RULES)} rules hold, and those on headers, on the sizes of rooms and folders, and on what is built")


main()
