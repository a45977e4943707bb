// harness/src/quantity.cpp
