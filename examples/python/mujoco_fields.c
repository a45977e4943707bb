/* Where the fields lie in MuJoCo's structures, which Python cannot know by itself. All else is called in libmujoco. */
#include <mujoco/mujoco.h>

double* applied_N(mjData* data, int body) { return data->xfrc_applied + 6 * body; }
const double* position_m(const mjData* data) { return data->qpos; }
void set_step_s(mjModel* model, double step_s) { model->opt.timestep = step_s; }
int warnings(const mjData* data) {
  int all = 0;
  for (int kind = 0; kind < mjNWARNING; ++kind) all += data->warning[kind].number;
  return all;
}
