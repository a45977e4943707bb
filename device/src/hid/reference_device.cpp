// device/src/hid/reference_device.cpp
