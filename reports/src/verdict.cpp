// reports/src/verdict.cpp
