// device/src/hid/simulated_transport.cpp
