// evenstep with MuJoCo and Bullet, if they are installed. Example: `engines run tests/engines/mujoco.toml`
#include "engines.h"
#include "evenstep/apps/command_line.h"

int main(int argc, char** argv) {
  evenstep::Registry registry = evenstep::builtin();
#ifdef ENGINES_MUJOCO
  registry.add_solver("mujoco", engines::make_mujoco);
#endif
#ifdef ENGINES_BULLET
  registry.add_solver("bullet", engines::make_bullet);
#endif
  return evenstep::command_line(argc, argv, registry);
}
