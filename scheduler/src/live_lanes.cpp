// scheduler/src/live_lanes.cpp
