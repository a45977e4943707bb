"""Google Benchmark's JSON as a table: least and median over the repetitions.

table.py FILE    CPU time of one iteration; of one event where the benchmark counts them (s_per_event)
"""
import json
import statistics
import sys

def order_of(run):
    return run["family_index"], run["per_family_instance_index"]


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        taken = [run for run in json.load(file)["benchmarks"] if run["run_type"] == "iteration"]
    runs = {}
    for run in sorted(taken, key=order_of):
        runs.setdefault(run["run_name"], []).append(run)

    print(f"{'':34}{'least ns':>10}{'median ns':>11}")
    for name, group in runs.items():
        times = [run["s_per_event"] * 1e9 if "s_per_event" in run else run["cpu_time"] for run in group]
        kept = max(run.get("bytes_per_event", 0) for run in group)
        note = f"  {kept:.0f} bytes/event kept" if kept else ""
        print(f"{name:34}{min(times):>10.1f}{statistics.median(times):>11.1f}{note}")


main()
