// A real device and the clock that it is given, which -DCLOCK= chooses.
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/device/hid/hidapi_transport.h"

void open(const evenstep::CLOCK& clock) { evenstep::HidapiTransport("/dev/hidraw0", clock); }
