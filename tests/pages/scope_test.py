#!/usr/bin/env python3
"""A live run while it runs: its status line on a terminal, its page in a browser, and what hostile clients can do to it.

    scope_test.py PROGRAM SOURCE_DIR

Without a browser it tests what needs none, says so and exits with 77. No test depends on how long anything takes: a run goes
on until the test has seen what it waits for, and is then interrupted.
"""
import fcntl
import json
import os
import pty
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import termios
import unittest
import urllib.error
import urllib.request
from pathlib import Path

import browser

PROGRAM, SOURCES = sys.argv[1:3]
FOLDER = Path(tempfile.mkdtemp(prefix="evenstep-scope-"))
HOSTILE = "</title><script>window.hacked = 1</script> ' & <img src=x onerror=hacked>"


class LiveRun:
    """A run on the wall clock with --scope."""

    def __init__(self, duration):
        scenario = FOLDER / "live.toml"
        scenario.write_text(f'format = 1\nextends = ["{SOURCES}/scenarios/live/figure-1-spring.toml"]\nname = "{HOSTILE}"\n'
                            f'[run]\nduration = "{duration} s"\n', encoding="utf-8")
        self.process = subprocess.Popen([PROGRAM, "run", "--clock", "wall", "--scope", scenario, "--set", "expect=[]",
                                         "--allow-no-expectations", "--out", FOLDER / "out"],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        said = "?"
        while said and not said.startswith("scope: "):
            said = self.process.stderr.readline()
        if not said:
            raise RuntimeError("the run has ended: " + self.process.stdout.read())
        self.url = said.split()[1]
        self.port = int(re.search(r":(\d+)/", self.url)[1])

    def end(self, interrupt=True):
        """(exit status, stdout, stderr)"""
        if interrupt:
            self.process.send_signal(signal.SIGINT)
        out, err = self.process.communicate(timeout=90)
        return self.process.returncode, out, err

    def connect(self, request):
        client = socket.create_connection(("127.0.0.1", self.port))
        client.sendall(request.encode())
        return client


class StatusLine(unittest.TestCase):
    def test_on_a_terminal_one_line_is_rewritten_within_its_width_and_the_last_one_stays(self):
        ours, theirs = pty.openpty()
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 60, 0, 0))
        process = subprocess.Popen([PROGRAM, "run", "--clock", "wall", f"{SOURCES}/scenarios/live/figure-1-spring.toml",
                                    "--set", "run.duration=\"2.5 s\"", "--set", "expect=[]", "--out", FOLDER / "line"],
                                   stdout=subprocess.DEVNULL, stderr=theirs,
                                   env={**os.environ, "TERM": "xterm", "NO_COLOR": "1"})
        os.close(theirs)
        written = b""
        try:
            while more := os.read(ours, 65536):
                written += more
        except OSError:  # the other end is closed
            pass
        process.wait(timeout=60)
        live = written[:written.index(b"ended") + len(b"ended\r\n")].decode()
        self.assertTrue(live.endswith("ended\r\n"), live)
        lines = live[:-2].split("\r\033[K")
        self.assertEqual(lines[0], "")
        self.assertGreaterEqual(len(lines), 3)  # one in each second, and the last
        for line in lines[1:]:
            self.assertRegex(line, r"^(ARMED|WAITING|CUT \(.*\)) \| .*(\d s left, Ctrl-C|ended)$")
            self.assertLessEqual(len(line), 59)
            self.assertNotIn("\033", line)


class Clients(unittest.TestCase):
    def test_clients_that_never_read_change_nothing(self):
        run = LiveRun(2)
        token = run.url.split("?")[1]
        host = f"Host: 127.0.0.1:{run.port}\r\n"
        requests = [f"GET /events?{token} HTTP/1.1\r\n{host}\r\n", f"GET /events?token={'0' * 32} HTTP/1.1\r\n{host}\r\n",
                    f"GET /?{token} HTTP/1.1\r\n{host}X: {'x' * 20000}\r\n\r\n", "GET"]
        clients = [run.connect(requests[i % 4]) for i in range(40)]
        status, out, err = run.end(interrupt=False)
        self.assertEqual(status, 0, out + err)
        self.assertIn("the recorded inputs replay to the same trace", out)
        self.assertNotIn("\033", err)
        line = next(line for line in err.splitlines() if "ended after" in line)
        judged = int(re.search(r"(\d+) ticks missed", out)[1])
        self.assertGreaterEqual(int(re.search(r"ticks missed \(run (\d+)\)", line)[1]), judged)
        for client in clients:
            client.close()

    def test_the_stream_has_what_ran_in_order_and_the_page_needs_its_token(self):
        run = LiveRun(60)
        for url in (run.url.split("?")[0], run.url[:-1] + ("1" if run.url[-1] == "0" else "0")):
            with self.assertRaises(urllib.error.HTTPError) as refused:
                urllib.request.urlopen(url)
            self.assertEqual(refused.exception.code, 403)
        seen = {"rows": [], "figures": []}
        with urllib.request.urlopen(run.url.replace("/?", "/events?")) as stream:
            while not seen["figures"] or sum(len(rows["devices"][0]["ticks"]["at"]) for rows in seen["rows"]) < 500:
                name = stream.readline().decode()[7:-1]
                if name in seen:
                    seen[name].append(json.loads(stream.readline().decode()[6:]))
        run.end()
        at = [t for rows in seen["rows"] for t in rows["devices"][0]["ticks"]["at"]]
        simulated = [t for rows in seen["rows"] for t in rows["devices"][0]["steps"]["simulated"]]
        self.assertEqual(at, sorted(set(at)))
        self.assertEqual(simulated, sorted(set(simulated)))
        for rows in seen["rows"]:
            steps, ticks = rows["devices"][0]["steps"], rows["devices"][0]["ticks"]
            columns = steps["hand"] + steps["direct"] + [steps["force"], steps["sample"], steps["end"]]
            self.assertEqual({len(column) for column in columns}, {len(steps["simulated"])})
            self.assertEqual({len(axis) for axis in ticks["force"] + ticks["direct"]}, {len(ticks["at"])})


@unittest.skipUnless(browser.program(), "there is no browser")
class InBrowser(unittest.TestCase):
    def test_the_page_shows_the_run_while_it_lasts_and_says_when_it_has_ended(self):
        with browser.Browser() as page:
            run = LiveRun(120)
            page.own = run.url.split("?")[0]
            page.open(run.url)
            page.wait_for("document.querySelector('#states dd')?.textContent === 'ARMED'")
            page.wait_for("document.querySelectorAll('#figures dd').length === 11")
            page.wait_for("scope.devices[0].steps.end.length > 300 && scope.devices[0].ticks.at.length > 600")
            self.assertEqual(page.run("document.getElementById('connection').textContent"), "Connected.")
            self.assertEqual(page.run("document.querySelector('h1').textContent"), HOSTILE)
            self.assertIsNone(page.run("window.hacked ?? null"))
            self.assertEqual(page.run("document.querySelectorAll('.plot canvas').length"), 4)
            self.assertEqual(page.run("[...document.querySelectorAll('.toggle')].map((e) => e.textContent).join()"),
                             3 * "phase_locked,direct (shadow)," + "force,sample")
            self.assertRegex(page.run("document.getElementById('figures').textContent"),
                             r"Time left\d+ s.*Rates[\d.]+ ticks/s, [\d.]+ steps/s.*Force, left[\d.]+ of 100 N")
            # The hand moves evenly, so without the remap its path jumps from step to step.
            mapped, direct = page.run("""(() => {
              const s = scope.devices[0].steps;
              const spread = (x) => {
                const d = x.slice(-200).map((v, i, all) => i ? Math.abs(v - all[i - 1]) : 0).slice(1).sort((a, b) => a - b);
                return d[Math.floor(0.9 * d.length)] - d[Math.floor(0.1 * d.length)];
              };
              return [spread(s.hand[0]), spread(s.direct[0])];
            })()""")
            self.assertLess(mapped, direct)
            page.run("document.getElementById('hold').click()")
            self.assertEqual(page.run("document.getElementById('hold').getAttribute('aria-pressed')"), "true")
            page.look(1200, 900, dark=True)
            status, out, _ = run.end()
            self.assertEqual(status, 130, out)
            page.wait_for("document.getElementById('connection').textContent.startsWith('The run has ended.')")
            self.assertEqual(page.faults, [])


if __name__ == "__main__":
    result = unittest.main(argv=sys.argv[:1], exit=False, verbosity=2).result
    subprocess.run(["rm", "-rf", FOLDER], check=False)
    if not result.wasSuccessful():
        sys.exit(1)
    if not browser.program():
        print("skipped: there is no chromium-headless-shell")
        sys.exit(77)
