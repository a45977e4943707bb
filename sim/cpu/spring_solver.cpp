// sim/cpu/spring_solver.cpp
