// reports/src/junit_xml.cpp
