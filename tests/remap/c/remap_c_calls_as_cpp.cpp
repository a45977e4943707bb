// The same C program, compiled as C++.
#include "remap_c_calls.c"
