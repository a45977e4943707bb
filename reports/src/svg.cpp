// reports/src/svg.cpp
