// reports/src/figure_1.cpp
