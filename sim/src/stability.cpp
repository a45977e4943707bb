// sim/src/stability.cpp
