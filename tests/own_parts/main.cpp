#include "evenstep/apps/command_line.h"
#include "parts.h"

using namespace own_parts;

int main(int argc, char** argv) {
  evenstep::Registry registry = evenstep::builtin();
  registry.add_solver("my-spring", [](const auto& request) { return std::make_unique<MySpring>(request); });
  registry.add_device("my-arm", [](const auto& request) { return std::make_unique<MyArm>(*request.grip); });
  registry.add_map("my-pacer", [](const auto& request) { return std::make_unique<MyPacer>(request); });
  registry.add_timing("my-gpu", my_gpu);
  return evenstep::command_line(argc, argv, registry);
}
