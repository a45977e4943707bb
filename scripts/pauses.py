#!/usr/bin/env python3
"""Tables and plot of docs/choose/pauses.md: what each what-if of `evenstep size` gives on the recordings that are shipped.

  scripts/pauses.py PROGRAM [--svg FILE] [RECORDING.csv ...]     default: all of scenarios/recorded

A row per recording and a column per what-if. "x / y": x if the simulator knew how long its drawings will take, y if it looks
back. The budget b is the median drawing, rounded up to a whole ms.
"""
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent


def budget_of(median_ms):
    """The budget that is tried: the median drawing, rounded up to a whole ms."""
    return int(-(-median_ms // 1))


def median_drawing_ms(file):
    lengths = []
    for line in file.read_text().splitlines():
        cells = line.split(",")
        if len(cells) == 5 and cells[1] == "visualization":
            lengths.append(int(cells[4]) - int(cells[3]))
    lengths.sort()
    return lengths[len(lengths) // 2] / 1e6 if lengths else 1


def what_ifs(file):
    budget = budget_of(median_drawing_ms(file))
    return ["split 2", "split 5", f"budget {budget} ms merge", f"budget {budget} ms hold", f"budget {budget} ms skip",
            f"split 2, budget {-(-budget // 2)} ms merge", "pace 90 %", "spread",
            "spread, own-lane 1", "spread, own-lane 1.3"]


def rows_of(program, file):
    command = [program, "size", str(file), "--json"]
    for text in what_ifs(file):
        command += ["--what-if", text]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return json.loads(done.stdout)["what_ifs"]


def latency(row):
    return row["strategies"]["phase_locked"]["latency_ns"] / 1e6


def number(value, digits=3):
    return f"{value:.{digits}g}" if value < 1000 else f"{value:.0f}"


def pair(row, back, value):
    """The value of the row that knows the future. If the row that looks back has another one, that follows."""
    if row is None or "refused" in row:
        return "-"
    return value(row) if back is None else f"{value(row)} / {value(back)}"


def columns(rows):
    """The row of each what-if, with the row that looks back if there is one."""
    out = []
    for at, row in enumerate(rows):
        if not row["looks_back"]:
            back = rows[at + 1] if at + 1 < len(rows) and rows[at + 1]["looks_back"] else None
            out.append((row, back))
    return out


HEADS = ["as it is", "split 2", "split 5", "budget b, merge", "budget b, hold", "budget b, skip",
         "split 2, budget b/2, merge", "pace 90 %", "spread", "own-lane 1, spread", "own-lane 1.3, spread"]


def table(results, title, value):
    out = [f"{title}", "", "| recording | b, ms | " + " | ".join(HEADS) + " |", "|---" * (len(HEADS) + 2) + "|"]
    for name, budget, rows in results:
        cells = " | ".join(pair(row, back, value) for row, back in columns(rows))
        out.append(f"| {name} | {budget} | {cells} |")
    return "\n".join(out) + "\n"


def tables(results):
    of_map = lambda row: row["strategies"]["phase_locked"]
    return "\n".join([
        table(results, "Least latency of phase_locked, ms", lambda row: number(latency(row))),
        table(results, "Its velocity jump, steps", lambda row: number(of_map(row)["velocity_jump"], 2)),
        table(results, "Pause bound, ms", lambda row: number(row["pause_bound_ns"] / 1e6)),
        table(results, "Drawings a second", lambda row: number(row["drawings_per_s"])),
        table(results, "Longest time without a drawing, ms", lambda row: number(row["longest_without_drawing_ns"] / 1e6)),
        table(results, "Simulated over real time", lambda row: f"{row['simulated_against_real']:.2f}")])


def svg(results):
    """A row per recording, a mark per what-if: its latency as a multiple of that of the recording as it is."""
    kinds = [(1, "#1f77b4", "split 2"), (2, "#0b3d66", "split 5"), (3, "#2ca02c", "budget, merge"),
             (6, "#d62728", "split 2, half the budget, merge"), (4, "#ff7f0e", "budget, hold (knows)"),
             (-4, "#8c510a", "budget, hold (looks back)"), (7, "#7f7f7f", "pace 90 %"), (8, "#17becf", "spread"),
             (10, "#9467bd", "own lane, 1.3, spread")]
    left, top, width, step = 235, 74, 560, 34
    height = top + step * len(results) + 46
    most = 1.6
    x = lambda share: left + width * min(share, most) / most
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{left + width + 40}" height="{height}" font-family="sans-serif" '
           f'font-size="12"><rect width="100%" height="100%" fill="white"/>',
           '<text x="12" y="20" font-size="14">Least latency of phase_locked with shorter pauses, as a multiple of the recording '
           'as it is</text>']
    at = 12
    for n, (_, colour, label) in enumerate(kinds):
        if n == 4:
            at = 12
        y = 38 if n < 4 else 56
        out.append(f'<circle cx="{at + 5}" cy="{y - 4}" r="5" fill="{colour}"/><text x="{at + 15}" y="{y}">{label}</text>')
        at += 36 + 7 * len(label)
    for share in (0, 0.25, 0.5, 0.75, 1, 1.25, 1.5):
        out.append(f'<line x1="{x(share):.1f}" y1="{top - 8}" x2="{x(share):.1f}" y2="{height - 34}" stroke="'
                   f'{"black" if share == 1 else "#dddddd"}"/><text x="{x(share):.1f}" y="{height - 16}" '
                   f'text-anchor="middle">{share:g}</text>')
    for n, (name, _, rows) in enumerate(results):
        y = top + step * n + step / 2
        out.append(f'<text x="{left - 10}" y="{y + 4:.1f}" text-anchor="end">{name}</text>')
        base = latency(rows[0])
        given = columns(rows)
        for at, (key, colour, _) in enumerate(kinds):
            row = given[abs(key)][1 if key < 0 else 0]
            if row is None or "refused" in row:
                continue
            share, mark = latency(row) / base, y + 2 * (at - 3.5)
            out.append(f'<circle cx="{x(share):.1f}" cy="{mark:.1f}" r="4.5" fill="{colour}" fill-opacity="0.85"/>')
            if share > most:
                out.append(f'<text x="{x(share) + 8:.1f}" y="{mark + 4:.1f}" fill="{colour}">{share:.1f}</text>')
        if "refused" in rows[1]:
            out.append(f'<text x="{left + 8}" y="{y + 4:.1f}" fill="#555555">drawings have a lane of their own</text>')
    return "\n".join(out + ["</svg>"]) + "\n"


def main():
    arguments = sys.argv[1:]
    picture = None
    if "--svg" in arguments:
        at = arguments.index("--svg")
        picture = arguments[at + 1]
        del arguments[at:at + 2]
    if not arguments:
        sys.exit(__doc__)
    program, files = arguments[0], [pathlib.Path(name) for name in arguments[1:]]
    files = files or sorted((ROOT / "scenarios/recorded").glob("*.csv"))
    results = [(file.stem, budget_of(median_drawing_ms(file)), rows_of(program, file)) for file in files]
    print(tables(results), end="")
    if picture:
        pathlib.Path(picture).write_text(svg(results))


if __name__ == "__main__":
    main()
