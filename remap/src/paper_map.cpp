// remap/src/paper_map.cpp
