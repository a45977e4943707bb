// harness/src/timing_csv.cpp
