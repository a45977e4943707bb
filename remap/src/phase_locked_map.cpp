// remap/src/phase_locked_map.cpp
