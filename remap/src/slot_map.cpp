// remap/src/slot_map.cpp
