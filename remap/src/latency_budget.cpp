// remap/src/latency_budget.cpp
