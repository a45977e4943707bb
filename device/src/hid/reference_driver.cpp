// device/src/hid/reference_driver.cpp
