// scheduler/src/random.cpp
