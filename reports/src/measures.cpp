// reports/src/measures.cpp
