// device/src/motion.cpp
