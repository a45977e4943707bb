"""Reads the sample files with other people's parsers and compares the values with those that were written."""
import csv
import json
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

folder = pathlib.Path(sys.argv[1])


def refuse(name):
    raise ValueError(f"{name} is not JSON")


summary = json.loads((folder / "summary.json").read_text("utf-8"), parse_constant=refuse)
nasty = (folder / "nasty.txt").read_text("utf-8")
assert summary["format"] == 1 and summary["evenstep"] == "0.1.0" and summary["verdict"] == "error"
assert summary["scenario"] == nasty and summary["left_out"][1] == nasty
assert summary["seed"] == 2**64 - 1 and summary["trace_hash"] == "0000000000000abc"
first, second, third, _ = summary["expectations"]
assert first["value"] == 4.995 and first["min"] == 4 and first["max"] is None and first["verdict"] == "pass"
assert second["because"] == nasty and second["verdict"] == "fail" and second["line"] == 20
assert third["value"] is None and third["verdict"] == "error"
assert summary["metrics"]["left.interaction.direct"]["velocity_jump"] is None   # a NaN position
assert 0 < summary["metrics"]["left.interaction.paper"]["velocity_jump"] < 1e-9
assert summary["latency"]["paper"]["latency_ns"] == 12842223
assert len(summary["bins"]["left.interaction.paper"]) == 22   # segments judged

with open(folder / "series.csv", newline="", encoding="utf-8") as file:
    rows = list(csv.reader(file))
header, rows = rows[0], rows[1:]
assert header[0] == "t[s]" and all(len(row) == len(header) for row in rows)
kinds = {}
for row in rows:
    float(row[0])
    kinds.setdefault((row[1], row[3]), []).append(dict(zip(header, row)))
assert len(kinds["paper", "step"]) == 450 and len(kinds["paper", "tick"]) == 1000
assert kinds["paper", "step"][200]["read[s]"] == "0.444184444"   # floor(200 / 450 s) - 0.26 ms
assert float(kinds["paper", "tick"][500]["x[m]"]) == 0.05
assert kinds["paper", "interaction_bin"][0]["underruns"] == "0" and kinds["paper", "force_bin"][0]["late"] == "0"

with open(folder / "underruns.csv", newline="", encoding="utf-8") as file:
    underruns = list(csv.DictReader(file))
assert underruns[0] == {"strategy": "paper", "device": "left", "side": "interaction", "step": "200", "lateness_ns": "1234567",
                        "policy": "gate"}
assert len(underruns) == 2 and underruns[1]["side"] == "force" and underruns[1]["policy"] == "hold"

# A hostile name stays one value in every format. XML 1.0 has no control characters: each is shown as U+FFFD.
with open(folder / "hostile.csv", newline="", encoding="utf-8") as file:
    assert {(row["strategy"], row["device"]) for row in csv.DictReader(file) if row["strategy"] == nasty} == {(nasty, nasty)}
with open(folder / "trace.json", encoding="utf-8") as file:
    events = json.load(file)["traceEvents"]
assert nasty in {event["args"]["name"] for event in events if event["name"] == "process_name"}
assert nasty + ": ticks" in {event["args"]["name"] for event in events if event["name"] == "thread_name"}
suite = ElementTree.parse(folder / "junit.xml").getroot()[0]
shown = "".join("\N{REPLACEMENT CHARACTER}" if ord(c) < 32 and c not in "\t\n\r" else c for c in nasty)
assert suite.get("name") == shown and suite.find("testcase/error").get("message") == shown
