// scheduler/src/event.cpp
