"""Checks a trace.json against the rules of the Trace Event Format that a viewer relies on. Then it breaks each rule in a copy,
which must be refused. The rules are taken from the description of the format, not from our writer."""
import copy
import json
import sys
from collections import defaultdict
from decimal import Decimal

NUMBER = (int, Decimal)


def is_number(value):
    return isinstance(value, NUMBER) and not isinstance(value, bool)


def slices_of(events):
    tracks = defaultdict(list)
    for event in events:
        if event["ph"] == "X":
            tracks[event["pid"], event["tid"]].append((event["ts"], event["ts"] + event["dur"]))
    return tracks


def faults(document):
    """The names of the rules that a document breaks."""
    found = set()
    events = document.get("traceEvents") if isinstance(document, dict) else None
    if not isinstance(events, list) or not events:
        return {"list"}
    for event in events:
        if event.get("ph") not in ("M", "X", "C", "s", "t", "f"):
            return {"phase"}
        if not isinstance(event.get("pid"), int) or not isinstance(event.get("name"), str):
            return {"identity"}
        if event["ph"] != "M" and not is_number(event.get("ts")):
            return {"time"}
        if event["ph"] in "Xstf" and not isinstance(event.get("tid"), int):
            return {"identity"}
        if event["ph"] == "X" and (not is_number(event.get("dur")) or event["dur"] < 0):
            return {"duration"}
        for key in ("ts", "dur"):
            if key in event and event[key] * 1000 != int(event[key] * 1000):
                found.add("nanoseconds")
    check_names(events, found)
    check_nesting(events, found)
    check_counters(events, found)
    check_flows(events, found)
    return found


def check_names(events, found):
    threads, processes = {}, {}
    for event in events:
        if event["ph"] == "M" and event["name"] == "thread_name":
            threads[event["pid"], event["tid"]] = event["args"]["name"]
        if event["ph"] == "M" and event["name"] == "process_name":
            processes[event["pid"]] = event["args"]["name"]
    used = {(event["pid"], event["tid"]) for event in events if event["ph"] in "Xstf"}
    if not used <= set(threads) or not {event["pid"] for event in events} <= set(processes):
        found.add("names")
    if len({(pid, name) for (pid, _), name in threads.items()}) != len(threads):
        found.add("names")


def check_nesting(events, found):
    for track in slices_of(events).values():
        open_ends = []
        for begin, end in sorted(track, key=lambda slice: (slice[0], -slice[1])):
            while open_ends and open_ends[-1] <= begin:
                open_ends.pop()
            if open_ends and end > open_ends[-1]:
                found.add("nesting")
            open_ends.append(end)


def check_counters(events, found):
    last, series = {}, {}
    for event in events:
        if event["ph"] != "C":
            continue
        values = event.get("args")
        if not values or not all(is_number(value) for value in values.values()):
            found.add("counters")
            continue
        key = event["pid"], event["name"]
        if key in last and event["ts"] <= last[key]:
            found.add("monotony")
        if series.setdefault(key, set(values)) != set(values):
            found.add("counters")
        last[key] = event["ts"]


def check_flows(events, found):
    tracks = {key: sorted(track) for key, track in slices_of(events).items()}
    flows = defaultdict(list)
    for event in events:
        if event["ph"] in ("s", "t", "f"):
            flows[event["id"]].append(event)
            if not has_slice(tracks.get((event["pid"], event["tid"]), []), event["ts"]):
                found.add("flow without a slice")
    for flow in flows.values():
        phases = "".join(event["ph"] for event in flow)
        if phases[0] + phases[-1] != "sf" or phases.count("s") + phases.count("f") != 2:
            found.add("flow ends")
        times = [event["ts"] for event in flow]
        if times != sorted(times) or len({(event["cat"], event["name"]) for event in flow}) != 1:
            found.add("flow order")


def has_slice(track, at):
    low, high = 0, len(track)
    while low < high:  # the first that begins after `at`
        middle = (low + high) // 2
        low, high = (middle + 1, high) if track[middle][0] <= at else (low, middle)
    return any(begin <= at <= end for begin, end in track[max(0, low - 8):low])


def mutated(document, change):
    copied = copy.deepcopy(document)
    change(copied["traceEvents"])
    return copied


def first(events, phase, skip=0):
    return [event for event in events if event["ph"] == phase][skip]


def drop(events, event):
    events.remove(event)


MUTATIONS = {
    "list": lambda events: events.clear(),
    "phase": lambda events: first(events, "X").update(ph="Q"),
    "identity": lambda events: first(events, "X").update(pid="1"),
    "time": lambda events: first(events, "C").update(ts="0"),
    "duration": lambda events: first(events, "X").update(dur=-1),
    "nanoseconds": lambda events: first(events, "X", 3).update(ts=first(events, "X", 3)["ts"] + Decimal("0.0001")),
    "names": lambda events: drop(events, next(e for e in events if e["name"] == "thread_name")),
    "nesting": lambda events: first(events, "X", 2).update(dur=first(events, "X", 2)["dur"] + 10),
    "counters": lambda events: first(events, "C").update(args={"x": None}),
    "monotony": lambda events: events.append(copy.deepcopy(first(events, "C"))),
    "flow without a slice": lambda events: first(events, "f").update(ts=Decimal(10**12)),
    "flow ends": lambda events: drop(events, first(events, "f")),
    "flow order": lambda events: first(events, "t").update(cat="other"),
}


def main(path):
    with open(path, encoding="utf-8") as file:
        document = json.load(file, parse_float=Decimal)
    assert not faults(document), faults(document)
    events = document["traceEvents"]
    # The mutations need only a few hundred events that belong together, those of one strategy and device.
    small = {"traceEvents": excerpt(events)}
    assert not faults(small), faults(small)
    for rule, change in MUTATIONS.items():
        assert rule in faults(mutated(small, change)), f"a mutation of '{rule}' was not found"
    count = defaultdict(int)
    for event in events:
        count[event["ph"]] += 1
    assert all(count[phase] > 100 for phase in "XCstf"), dict(count)
    print(f"{len(events)} events keep the rules, and {len(MUTATIONS)} mutations do not")


def excerpt(events):
    limit = Decimal(500_000)  # us
    pid = next(event["pid"] for event in reversed(events))
    chosen = [e for e in events if e["pid"] == pid and (e["ph"] == "M" or e["ts"] < limit)]
    whole = {e["id"] for e in chosen if e["ph"] == "s"} & {e["id"] for e in chosen if e["ph"] == "f"}
    return [e for e in chosen if e["ph"] not in "stf" or e["id"] in whole]


if __name__ == "__main__":
    main(sys.argv[1])
