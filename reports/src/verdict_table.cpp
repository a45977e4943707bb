// reports/src/verdict_table.cpp
