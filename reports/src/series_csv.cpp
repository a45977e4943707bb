// reports/src/series_csv.cpp
