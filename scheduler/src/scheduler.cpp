// scheduler/src/scheduler.cpp
