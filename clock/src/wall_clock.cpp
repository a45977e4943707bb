// clock/src/wall_clock.cpp
