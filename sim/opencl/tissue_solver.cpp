// sim/opencl/tissue_solver.cpp
