// harness/src/schema.cpp
