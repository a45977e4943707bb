// device/src/force_guard.cpp
