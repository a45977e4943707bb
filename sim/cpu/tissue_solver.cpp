// sim/cpu/tissue_solver.cpp
