#include "mujoco_models.h"

#include <cmath>
#include <numbers>

namespace engines {
namespace {

using evenstep::SolverError;
using evenstep::SolverFault;

const char* const kSliders = R"(
      <joint type="slide" axis="1 0 0" stiffness="{0}" damping="{1}"/>
      <joint type="slide" axis="0 1 0" stiffness="{0}" damping="{1}"/>
      <joint type="slide" axis="0 0 1" stiffness="{0}" damping="{1}"/>)";

/// The hand is a mocap body: MuJoCo puts it where it is told to and gives it no mass. A weld pulls the tool after it.
std::string hand(int tool, const glm::dvec3& at_m) {
  return fmt::format("\n    <body name=\"hand{}\" mocap=\"true\" pos=\"{} {} {}\"/>", tool, at_m.x, at_m.y, at_m.z);
}

/// A ball joint of three rows, as soft as the options say, between the hand and a body.
std::string hold(const Options& options, int tool, const std::string& body) {
  const double impedance = options.number("impedance", 0.99, 1e-4, 0.9999);
  return fmt::format(
      "\n    <connect name=\"hold{0}\" body1=\"hand{0}\" body2=\"{1}\" anchor=\"0 0 0\" solref=\"{2} 1\" "
      "solimp=\"{3} {3} 0.001\"/>",
      tool, body, options.number("weld", 0.0045, 0, 1e6), impedance);
}

/// A weld with all six rows. The sliders of a tool leave three of them.
std::string weld(const Options& options, int tool) {
  const double impedance = options.number("impedance", 0.99, 1e-4, 0.9999);
  return fmt::format(
      "\n    <weld name=\"hold{0}\" body1=\"hand{0}\" body2=\"tool{0}\" solref=\"{1} 1\" solimp=\"{2} {2} 0.001\"/>", tool,
      options.number("weld", 0.0045, 0, 1e6), impedance);
}

std::string option(const Options& options, double step_s, const char* gravity) {
  return fmt::format(
      "\n  <option timestep=\"{}\" integrator=\"{}\" iterations=\"{}\" tolerance=\"{}\" gravity=\"{}\">"
      "\n    <flag energy=\"enable\"/>\n  </option>",
      step_s, options.word("integrator", {"Euler", "RK4", "implicit"}), options.count("iterations", 100, 1, 10'000),
      options.number("tolerance", 1e-12, 0, 1), gravity);
}

std::string tool_body(int tool, const glm::dvec3& at_m, double mass_kg, double stiffness, double damping, bool touches) {
  return fmt::format("\n    <body name=\"tool{}\" pos=\"{} {} {}\">", tool, at_m.x, at_m.y, at_m.z) +
         fmt::format(fmt::runtime(kSliders), stiffness, damping) +
         fmt::format("\n      <geom type=\"sphere\" size=\"0.01\" mass=\"{}\"{}/>\n    </body>", mass_kg,
                     touches ? "" : " contype=\"0\" conaffinity=\"0\"");
}

std::string tool_xml(const Options& options, const evenstep::SolverRequest& request) {
  std::string bodies, welds;
  for (int tool = 0; tool < request.tool_count; ++tool) {
    bodies +=
        hand(tool, {}) + tool_body(tool, {}, options.number("mass", 0.05, 1e-9, 1e6),
                                   options.number("stiffness", 200, 0, 1e12), options.number("damping", 1, 0, 1e9), false);
    welds += weld(options, tool);
  }
  return fmt::format("<mujoco>{}\n  <worldbody>{}\n  </worldbody>\n  <equality>{}\n  </equality>\n</mujoco>\n",
                     option(options, request.step_s, "0 0 0"), bodies, welds);
}

/// Links of 2 cm, each on a ball joint with a spring in it. At rest each is turned by 10 degrees against the one before. So
/// they form a hook that bends and twists. The hand holds its end. (The end of a straight rod could not follow the hand,
/// because the rod does not stretch.)
std::string rod_xml(const Options& options, const evenstep::SolverRequest& request, glm::dvec3& end_m) {
  const int links = options.count("links", 8, 1, 100);
  const double mass_kg = options.number("mass", 0.05, 1e-9, 1e6);
  std::string open, close;
  for (int link = 0; link < links; ++link) {
    const double turned_rad = link * 10 * std::numbers::pi / 180;
    end_m += 0.02 * glm::dvec3(std::cos(turned_rad), std::sin(turned_rad), 0);
    open += fmt::format(
        "\n    <body name=\"link{}\" pos=\"{} 0 0\" euler=\"0 0 {}\">\n      <joint type=\"ball\" stiffness=\"{}\" "
        "damping=\"{}\"/>"
        "\n      <geom type=\"box\" pos=\"0.01 0 0\" size=\"0.01 0.005 0.005\" mass=\"{}\" contype=\"0\" "
        "conaffinity=\"0\"/>",
        link, link == 0 ? 0 : 0.02, link == 0 ? 0 : 10, options.number("stiffness", 0.5, 0, 1e9),
        options.number("damping", 0.005, 0, 1e9), mass_kg / links);
    close += "\n    </body>";
  }
  return fmt::format("<mujoco>{}\n  <worldbody>{}{}{}\n  </worldbody>\n  <equality>{}\n  </equality>\n</mujoco>\n",
                     option(options, request.step_s, "0 0 0"), hand(0, end_m), open, close,
                     hold(options, 0, fmt::format("link{}", links - 1)));
}

/// A soft box on a floor: particles on sliders, held together by tendons. A ball that the hand moves rests on it. The box
/// has about a hundred contacts, which come and go.
std::string box_xml(const Options& options, const evenstep::SolverRequest& request, glm::dvec3& above_m) {
  const int edge = options.count("edge", 4, 3, 20);
  const double half_m = 0.01 * (edge - 1);
  above_m = {0, 0, 2 * half_m + 0.02};  // the outer faces are where the balls end; the tool is as large as a ball
  return fmt::format(
      "<mujoco>{}\n  <size njmax=\"{}\" nconmax=\"{}\"/>\n  <worldbody>\n    <geom type=\"plane\" size=\"1 1 1\"/>{}{}"
      "\n    <body pos=\"0 0 {}\">\n      <composite type=\"box\" count=\"{} {} {}\" spacing=\"0.02\">"
      "\n        <joint kind=\"main\" stiffness=\"{}\" damping=\"{}\"/>"
      "\n        <geom type=\"sphere\" size=\"0.01\" mass=\"{}\"/>\n      </composite>\n    </body>"
      "\n  </worldbody>\n  <equality>{}\n  </equality>\n</mujoco>\n",
      option(options, request.step_s, "0 0 -9.81"), 100 * edge * edge, 20 * edge * edge, hand(0, above_m),
      tool_body(0, above_m, 0.005, 0, 0, true), half_m + 0.01, edge, edge, edge, options.number("stiffness", 200, 0, 1e9),
      options.number("damping", 1, 0, 1e9), options.number("mass", 0.05, 1e-9, 1e6) / (edge * edge * edge),
      weld(options, 0));
}

/// A body on sliders for each particle, and a tendon for each spring, which pulls along the line between its ends.
std::string particles_xml(const Options& options, const Particles& particles, double step_s) {
  std::string bodies, tendons;
  for (std::size_t n = 0; n < particles.rest_m.size(); ++n) {
    const glm::dvec3& at = particles.rest_m[n];
    const std::string site = fmt::format("<site name=\"p{}\" pos=\"{{}} {{}} {{}}\"/>", n);
    if (particles.is_fixed[n]) {
      bodies += fmt::format(fmt::runtime("\n    " + site), at.x, at.y, at.z);
      continue;
    }
    bodies += fmt::format(
        "\n    <body pos=\"{} {} {}\">{}\n      <inertial pos=\"0 0 0\" mass=\"{}\" diaginertia=\"1e-6 1e-6 1e-6\"/>"
        "\n      {}\n    </body>",
        at.x, at.y, at.z, fmt::format(fmt::runtime(kSliders), 0, 0), particles.mass_kg,
        fmt::format(fmt::runtime(site), 0, 0, 0));
  }
  for (const auto& [a, b] : particles.springs)
    tendons += fmt::format("\n    <spatial stiffness=\"{}\"><site site=\"p{}\"/><site site=\"p{}\"/></spatial>",
                           particles.stiffness_N_per_m, a, b);
  return fmt::format("<mujoco>{}\n  <worldbody>{}\n  </worldbody>\n  <tendon>{}\n  </tendon>\n</mujoco>\n",
                     option(options, step_s, "0 0 0"), bodies, tendons);
}

}  // namespace

MujocoScene mujoco_scene(const evenstep::SolverRequest& request) {
  const Options options(request.options, {"model", "integrator", "stiffness", "damping", "mass", "weld", "impedance",
                                          "iterations", "tolerance", "links", "edge", "particles"});
  MujocoScene scene;
  if (options.has_particles()) {
    scene.particles = options.particles();
    scene.xml = particles_xml(options, *scene.particles, request.step_s);
    return scene;
  }
  const std::string model = options.word("model", {"tool", "rod", "box"});
  if (model != "tool" && request.tool_count > 1)
    throw SolverError(SolverFault::bad_scene, fmt::format("the model '{}' has one tool, not {}", model, request.tool_count),
                      "one [[device]], or model = \"tool\"");
  scene.xml = model == "tool"  ? tool_xml(options, request)
              : model == "rod" ? rod_xml(options, request, scene.tool_rest_m)
                               : box_xml(options, request, scene.tool_rest_m);
  return scene;
}

}  // namespace engines
