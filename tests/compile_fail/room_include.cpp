// One include, chosen by -DHEADER=<...>, with the include directories of one room.
#include HEADER

int main() {}
