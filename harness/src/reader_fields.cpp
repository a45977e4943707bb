// harness/src/reader_fields.cpp
