// harness/src/diagnostic.cpp
