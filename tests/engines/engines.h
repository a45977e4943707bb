#pragma once
// Physics engines of others as solvers of evenstep. Nothing in evenstep knows them: this folder shows how to add an engine
// (docs/parts/engines.md).

#include <memory>

#include "evenstep/sim/foreign_solver.h"

namespace engines {

/// MuJoCo, [scene] name = "mujoco". Options, with their defaults (a [case] hands over particles, and then there is no
/// model):
///   model      = "tool"       a body of `mass` on three sliders, each with `stiffness` and `damping`, welded to the hand
///                "rod"        a hook of `links` boxes on ball joints, clamped at one end, the other end held by the hand
///                "box"        a soft box, MuJoCo's composite of `edge`^3 balls, on a floor, pressed by a ball at the hand
///   integrator = "Euler"      "RK4", "implicit"
///   stiffness  = 200 N/m (rod: N m/rad), damping = 1 N s/m (rod: N m s/rad), mass = 0.05 kg, links = 8, edge = 4
///   weld       = 0.0045 s     time constant of the weld; MuJoCo makes it two steps if it is shorter
///   impedance  = 0.99         of the weld: the share of the constraint in the tool's acceleration
///   iterations = 100, tolerance = 1e-12: where the constraint solver stops
/// The force on the hand is that of the rows of the weld (with "rod", of a ball joint) in the constraint solver.
std::unique_ptr<evenstep::ForeignSolver> make_mujoco(const evenstep::SolverRequest& request);

/// Bullet, [scene] name = "bullet".
///   model      = "tool"       a body of `mass` on a spring to the world of `stiffness` and `damping`
///                "soft"       a cloth of `edge` x `edge` nodes (btSoftBody), held at its corners, anchored to the tool
///   coupling   = 2000 N/m, coupling_damping = 10 N s/m: the 6-DoF spring between the hand and the tool
///   stiffness  = 200 N/m, damping = 0 N s/m, mass = 0.05 kg; for "soft" stiffness = 0.5, damping = 0.05, edge = 9
///   iterations = 50           of the constraint solver
///   limit      = false        lets Bullet soften springs that it finds too stiff for the step
/// The force on the hand is the one that Bullet reports for that spring (btJointFeedback).
std::unique_ptr<evenstep::ForeignSolver> make_bullet(const evenstep::SolverRequest& request);

}  // namespace engines
