// reports/src/summary_json.cpp
