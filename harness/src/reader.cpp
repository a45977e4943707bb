// harness/src/reader.cpp
