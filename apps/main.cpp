#include "evenstep/apps/command_line.h"

int main(int argc, char** argv) { return evenstep::command_line(argc, argv); }
