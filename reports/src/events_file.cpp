// reports/src/events_file.cpp
