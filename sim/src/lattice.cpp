// sim/src/lattice.cpp
