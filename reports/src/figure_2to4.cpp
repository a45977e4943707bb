// reports/src/figure_2to4.cpp
