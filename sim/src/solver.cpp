// sim/src/solver.cpp
