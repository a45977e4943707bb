// scheduler/src/step_timing.cpp
