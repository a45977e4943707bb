// The same program in C, as C++ takes it.
#include "remap_c_calls.c"
