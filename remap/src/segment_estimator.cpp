// remap/src/segment_estimator.cpp
