#!/usr/bin/env python3
"""report.html as its reader meets it: in a browser, and as a file.

    report_test.py PROGRAM SOURCE_DIR

Without a browser it tests what needs none, says so and exits with 77.
"""
import base64
import csv
import json
import re
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

import browser

PROGRAM, SOURCES = sys.argv[1:3]
FOLDER = Path(tempfile.mkdtemp(prefix="evenstep-report-"))
HOSTILE = r"</title></style><script>window.hacked = 1</script>]]>--> \u202Egnp.exe \u001b[31m ' & <img src=x onerror=hacked>"
LATE = f"""format = 1
extends = ["{SOURCES}/scenarios/paper/figure-1-spring.toml"]
name = "{HOSTILE}"
because = "{HOSTILE}"
[run]
duration = "2 s"
[remap]
latency = "12 ms"
[[expect]]
signal = "left.force.phase_locked"
metric = "underruns"
equals = 0
because = "{HOSTILE}"
"""
LONG = f"""format = 1
extends = ["{SOURCES}/scenarios/timing/jitter-10.toml"]
[run]
duration = "223 s"
keep = "summary"
"""


def run(name, text):
    """The page of a run of this scenario."""
    scenario = FOLDER / f"{name}.toml"
    scenario.write_text(text, encoding="utf-8")
    done = subprocess.run([PROGRAM, "run", scenario, "--out", FOLDER / name], capture_output=True, text=True, check=False)
    page = FOLDER / name / "report.html"
    if not page.exists():
        sys.exit(done.stdout + done.stderr)
    return page


def charts_of(page):
    text = page.read_text(encoding="utf-8")
    return json.loads(re.search(r'<script type="application/json" id="charts">(.*?)</script>', text, re.S)[1])


def columns_of(charts):
    """The columns, decoded as report.js does it."""
    data = base64.b64decode(charts["columns"]["bytes"])
    if charts["columns"]["packed"]:
        data = zlib.decompress(data)
    at, columns = 0, []
    for column in charts["columns"]["list"]:
        count, values, value, slope = column["count"], [], column["first"], 0
        planes = [data[at + i * count:at + (i + 1) * count] for i in range(4)]
        for parts in zip(*planes):
            difference = struct.unpack("<i", bytes(parts))[0]
            slope = slope + difference if column["order"] == 2 else difference
            value += slope
            values.append(value * column["quantum"])
        at += 4 * count
        columns.append((values, column["quantum"]))
    return columns


class AsFile(unittest.TestCase):
    def test_the_page_has_the_numbers_of_series_csv(self):
        charts = charts_of(LATE_PAGE)
        columns = columns_of(charts)
        with open(LATE_PAGE.parent / "series.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        for strategy in charts["strategies"]:
            steps = [r for r in rows if r["strategy"] == strategy["name"] and r["kind"] == "step"]
            begin, run_time, read, emission = (columns[strategy["steps"][c]][0] for c in ("begin", "run", "read", "emission"))
            position, quantum = columns[strategy["devices"][0]["position"]]
            self.assertEqual(len(steps), len(begin))
            for i, row in enumerate(steps):
                self.assertEqual(round(float(row["t[s]"]) * 1e9), begin[i])
                self.assertEqual(round(float(row["end[s]"]) * 1e9), begin[i] + run_time[i])
                self.assertEqual(round(float(row["read[s]"]) * 1e9), begin[i] + read[i])
                self.assertEqual(round(float(row["emission[s]"]) * 1e9), begin[i] + read[i] + emission[i])
                self.assertLessEqual(abs(float(row["x[m]"]) - position[i]), 0.51 * quantum)
            ticks = [r for r in rows if r["strategy"] == strategy["name"] and r["kind"] == "tick"]
            force, quantum = columns[strategy["devices"][0]["ticks"]["force"]]
            self.assertEqual(len(ticks), len(force))
            for row, value in zip(ticks, force):
                self.assertLessEqual(abs(float(row["fx[N]"]) - value), 0.51 * quantum)

    def test_the_page_says_what_summary_json_says(self):
        summary = json.loads((LATE_PAGE.parent / "summary.json").read_text(encoding="utf-8"))
        text = LATE_PAGE.read_text(encoding="utf-8")
        self.assertIn(f'<span class="verdict {summary["verdict"]}">', text)
        self.assertIn(summary["trace_hash"], text)
        self.assertEqual(len(re.findall(r'<td class="words"><span class="verdict', text)), len(summary["expectations"]))
        failed = [e for e in summary["expectations"] if e["verdict"] == "fail"]
        self.assertTrue(failed)
        self.assertEqual(len(re.findall(r'<li id="[^"]*" class="failed">', text)), len({(e["file"], e["line"]) for e in failed}))

    def test_the_same_run_writes_the_same_page(self):
        self.assertEqual(LATE_PAGE.read_bytes(), run("late", LATE).read_bytes())

    def test_a_hundred_thousand_steps_fit_in_a_megabyte(self):
        charts = charts_of(LONG_PAGE)
        self.assertGreater(charts["strategies"][0]["total_steps"], 100_000)
        self.assertLess(LONG_PAGE.stat().st_size, 1_000_000)


@unittest.skipUnless(browser.program(), "there is no browser")
class InBrowser(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.browser = browser.Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()

    def open(self, page=None, **how):
        self.browser.faults.clear()
        self.browser.open(page or LATE_PAGE, **how)
        if how.get("scripts", True):
            self.browser.wait_for("document.documentElement.dataset.drawnMs")

    def value(self, expression):
        return self.browser.run(expression)

    def shown(self):
        return self.value("document.getElementById('window').textContent")

    def segment(self):
        return self.value("document.getElementById('segment-text').textContent")

    def click(self, text):
        self.value(f"[...document.querySelectorAll('button')].find((b) => b.textContent === {json.dumps(text)}).click()")

    def test_it_opens_without_an_error_and_asks_for_nothing(self):
        for how in ({}, {"dark": True}, {"width": 390}, {"scripts": False}):
            with self.subTest(how):
                self.open(**how)
                self.assertEqual(self.browser.faults, [])

    def test_a_narrow_page_is_not_wider_than_its_window(self):
        self.open(width=390)
        self.assertLessEqual(self.value("document.documentElement.scrollWidth"), 390)

    def test_dragging_zooms_all_charts_to_the_same_part(self):
        self.open()
        self.click("All of the run")
        before = self.shown()
        x, y, width = self.value("""(() => {
            const over = document.querySelector('[data-chart="force"] .u-over');
            over.scrollIntoView({ block: "center" });
            const box = over.getBoundingClientRect();
            return [box.left, box.top + 50, box.width]; })()""")
        self.browser.drag(x + 0.25 * width, y, x + 0.5 * width, y)
        self.assertNotEqual(self.shown(), before)
        from_s, to_s = map(float, re.findall(r"([\d.]+) s\b", self.shown())[:2])
        self.assertAlmostEqual(to_s - from_s, (2 - 0.4) / 4, delta=0.1)
        self.browser.call("Input.dispatchKeyEvent", type="rawKeyDown", key="Escape")
        self.value("document.querySelector('[data-chart=\"force\"]').focus()")
        self.browser.key("Escape")
        self.assertEqual(self.shown(), before)

    def test_charts_are_moved_by_keys(self):
        self.open()
        self.value("document.querySelector('[data-chart=\"interaction\"]').focus()")
        before = self.shown()
        self.browser.key("ArrowRight")
        right = self.shown()
        self.assertNotEqual(right, before)
        self.browser.key("+")
        self.assertNotEqual(self.shown(), right)

    def test_a_strategy_can_be_taken_out_of_the_charts(self):
        self.open()
        names = "[...document.querySelectorAll('[data-chart=\"force\"] .u-series .u-label')].map((l) => l.textContent)"
        self.assertIn("direct", self.value(names))
        self.value("[...document.querySelectorAll('.toggle')].find((t) => t.textContent.includes('direct'))"
                   ".querySelector('input').click()")
        self.assertNotIn("direct", self.value(names))
        self.assertIn("phase_locked", self.value(names))

    def test_segments_are_stepped_by_buttons_and_keys(self):
        self.open()
        at = int(re.match(r"Segment (\d+)", self.segment())[1])
        self.click("Next →")
        self.assertTrue(self.segment().startswith(f"Segment {at + 1}"))
        self.value("document.querySelector('[data-stepper]').focus()")
        self.browser.key("ArrowLeft")
        self.assertTrue(self.segment().startswith(f"Segment {at}"))
        self.browser.key("Home")
        self.assertTrue(self.segment().startswith("Segment 0"))
        self.assertGreater(self.value("document.querySelectorAll('svg.segment rect.step').length"), 10)

    def test_the_first_and_the_worst_late_force_are_found(self):
        self.open()
        summary = json.loads((LATE_PAGE.parent / "summary.json").read_text(encoding="utf-8"))
        failed = next(e for e in summary["expectations"] if e["verdict"] == "fail" and "force.phase_locked" in e["signal"])
        for button, place in (("First late force", "first"), ("Worst late force", "worst")):
            self.click(button)
            self.assertIn("late, by at most", self.segment())
            from_s, to_s = map(float, re.findall(r"([\d.]+) s\b", self.segment())[:2])
            self.assertLessEqual(from_s, failed[place]["time_ns"] * 1e-9)
            self.assertGreaterEqual(to_s, failed[place]["time_ns"] * 1e-9)
        self.assertGreater(self.value("document.querySelectorAll('svg.segment rect.late').length"), 0)

    def test_an_expectation_shows_where_it_fails(self):
        self.open()
        self.click("All of the run")
        before = self.shown()
        self.value("document.querySelector('button.jump').click()")
        self.assertNotEqual(self.shown(), before)

    def test_a_hostile_name_is_only_a_name(self):
        self.open()
        self.assertIsNone(self.value("window.hacked ?? null"))
        self.assertEqual(self.value("document.querySelectorAll('img, iframe, script[src]').length"), 0)
        name = self.value("document.querySelector('h1').textContent")
        self.assertIn("<script>window.hacked = 1</script>]]>-->", name)
        self.assertIn("⟨U+202E⟩gnp.exe ⟨U+001B⟩[31m", name)
        everything = self.value("document.documentElement.outerHTML")
        self.assertNotRegex(everything, "[\u202a-\u202e\u2066-\u2069\x1b]")

    def test_the_policy_stops_a_script_that_got_in(self):
        self.open()
        self.value("(() => { const s = document.createElement('script'); s.textContent = 'window.hacked = 1';"
                   "document.body.append(s); })()")
        self.assertIsNone(self.value("window.hacked ?? null"))
        self.assertTrue(any("Content Security Policy" in fault for fault in self.browser.faults))

    def test_it_prints(self):
        self.open(dark=True)
        pdf = FOLDER / "report.pdf"
        self.browser.pdf(pdf)
        self.assertGreater(pdf.stat().st_size, 20_000)
        self.assertEqual(self.browser.faults, [])

    def test_a_hundred_thousand_steps_are_drawn(self):
        self.open(LONG_PAGE)
        self.assertEqual(self.browser.faults, [])
        drawn = int(self.value("document.documentElement.dataset.drawnMs"))
        print(f"100,000 steps are drawn in {drawn} ms", file=sys.stderr)
        self.assertLess(drawn, 5000)  # a loaded machine; a quiet one takes a quarter of a second


if __name__ == "__main__":
    LATE_PAGE, LONG_PAGE = run("late", LATE), run("long", LONG)
    result = unittest.main(argv=sys.argv[:1], exit=False, verbosity=2).result
    subprocess.run(["rm", "-rf", FOLDER], check=False)
    if not result.wasSuccessful():
        sys.exit(1)
    if not browser.program():
        print("skipped: there is no chromium-headless-shell")
        sys.exit(77)
