#include "evenstep/device/renderer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/matrix.hpp>

namespace evenstep {
namespace {

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

template <class Value>
Value mixed(const Value& a, const Value& b, double w) {
  return a + (b - a) * w;
}

Symmetric mixed(const Symmetric& a, const Symmetric& b, double w) {
  return {.xx = mixed(a.xx, b.xx, w),
          .yy = mixed(a.yy, b.yy, w),
          .zz = mixed(a.zz, b.zz, w),
          .xy = mixed(a.xy, b.xy, w),
          .xz = mixed(a.xz, b.xz, w),
          .yz = mixed(a.yz, b.yz, w)};
}

glm::dvec3 without_pull(const glm::dvec3& force_N, const glm::dvec3& outward) {
  return dot(outward, force_N) < 0 ? glm::dvec3(0) : force_N;
}

}  // namespace

Softened softened(const ContactRecord& record, double most_N_per_m) {
  assert(most_N_per_m > 0);
  const Axes of = axes_of(record.stiffness_N_per_m);
  const auto& [values, axes] = of;
  Softened soft{record, largest_value(of)};
  if (!(soft.stiffest_N_per_m > most_N_per_m) || !std::isfinite(soft.stiffest_N_per_m)) return soft;
  ContactRecord& contact = soft.record;
  Symmetric& k = contact.stiffness_N_per_m;
  for (std::size_t i = 0; i < 3; ++i) {
    if (values[i] <= most_N_per_m) continue;
    const glm::dvec3& v = axes[i];
    const double less = values[i] - most_N_per_m;
    k = {.xx = k.xx - less * v.x * v.x,
         .yy = k.yy - less * v.y * v.y,
         .zz = k.zz - less * v.z * v.z,
         .xy = k.xy - less * v.x * v.y,
         .xz = k.xz - less * v.x * v.z,
         .yz = k.yz - less * v.y * v.z};
    const double share = less / values[i];
    contact.force_N -= v * (dot(v, record.force_N) * share);
    contact.coupling_N_per_m -= glm::outerProduct(v, v * record.coupling_N_per_m) * share;
  }
  return soft;
}

Softened softened_together(const ContactRecord& record, double most_N_per_m) {
  assert(most_N_per_m > 0);
  Joint joint = joint_of(record.stiffness_N_per_m, record.coupling_N_per_m, record.other_stiffness_N_per_m);
  const JointAxes of = joint_axes_of(joint);
  Softened soft{record, largest_value(of)};
  if (!(soft.stiffest_N_per_m > most_N_per_m) || !std::isfinite(soft.stiffest_N_per_m)) return soft;
  const glm::dvec3 &force_N = record.force_N, &other_N = record.other_force_N;
  for (std::size_t i = 0; i < 6; ++i) {
    if (of.values[i] <= most_N_per_m) continue;
    std::array<double, 6> v{};
    for (std::size_t r = 0; r < 6; ++r) v[r] = of.axes[r][i];
    const double less = of.values[i] - most_N_per_m;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t c = 0; c < 6; ++c) joint[r][c] -= less * v[r] * v[c];
    const glm::dvec3 own{v[0], v[1], v[2]}, other{v[3], v[4], v[5]};
    soft.record.force_N -= own * ((dot(own, force_N) + dot(other, other_N)) * (less / of.values[i]));
  }
  soft.record.stiffness_N_per_m = {
      .xx = joint[0][0], .yy = joint[1][1], .zz = joint[2][2], .xy = joint[0][1], .xz = joint[0][2], .yz = joint[1][2]};
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 3; ++c)
      soft.record.coupling_N_per_m[static_cast<int>(c)][static_cast<int>(r)] = joint[r][3 + c];
  return soft;
}

ContactRecord with_part(const ContactRecord& record, StiffnessPart part) {
  ContactRecord contact = record;
  Symmetric& k = contact.stiffness_N_per_m;
  if (part == StiffnessPart::axes) k = {k.xx, k.yy, k.zz};
  if (part != StiffnessPart::normal || !record.unilateral) return contact;
  const glm::dvec3& n = record.normal;
  const double along = dot(n, k * n);
  k = {along * n.x * n.x, along * n.y * n.y, along * n.z * n.z, along * n.x * n.y, along * n.x * n.z, along * n.y * n.z};
  return contact;
}

AffineContact affine_contact(const ContactRecord& record, bool knows_gap) {
  AffineContact contact{.force_N = record.force_N,
                        .tool_m = record.tool_m,
                        .stiffness_N_per_m = record.stiffness_N_per_m,
                        .outward = record.unilateral ? record.normal : glm::dvec3(0),
                        .read_at = record.read_at,
                        .coupling_N_per_m = record.coupling_N_per_m,
                        .other_m = record.other_m};
  const bool apart = record.unilateral && record.gap_m > 0;
  if (apart && knows_gap) contact.force_N = record.stiffness_N_per_m * record.normal * -record.gap_m;
  if (apart && !knows_gap) contact.stiffness_N_per_m = {};
  return contact;
}

AffineContact lerp(const AffineContact& a, const AffineContact& b, double w) {
  const auto later_ns = static_cast<std::int64_t>(static_cast<double>((b.read_at - a.read_at).ns) * w);
  return {.force_N = mixed(a.force_N, b.force_N, w),
          .tool_m = mixed(a.tool_m, b.tool_m, w),
          .stiffness_N_per_m = mixed(a.stiffness_N_per_m, b.stiffness_N_per_m, w),
          .outward = mixed(a.outward, b.outward, w),
          .read_at = a.read_at + Duration{later_ns},
          .coupling_N_per_m = mixed(a.coupling_N_per_m, b.coupling_N_per_m, w),
          .other_m = mixed(a.other_m, b.other_m, w)};
}

double fade(Duration age) {
  const std::int64_t faded_ns = std::clamp<std::int64_t>((age - kFadeAfter).ns, 0, kFadeFor.ns);
  return 1 - static_cast<double>(faded_ns) / static_cast<double>(kFadeFor.ns);
}

glm::dvec3 LocalRenderer::force_N(const AffineContact& scheduled, Duration age, const glm::dvec3& hand_m,
                                  const glm::dvec3* other_m) const {
  glm::dvec3 correction_N = scheduled.stiffness_N_per_m * (scheduled.tool_m - hand_m);
  if (other_m) correction_N += scheduled.coupling_N_per_m * (scheduled.other_m - *other_m);
  return without_pull((scheduled.force_N + correction_N * alpha_) * fade(age), scheduled.outward);
}

SmithRenderer::SmithRenderer(const SpringMode& mode, Duration memory, Duration period)
    : mode_(mode),
      longest_step_s_(std::min(25e-6, std::sqrt(mode.mass_kg / (mode.contact_N_per_m + mode.ground_N_per_m)) / 20)),
      outputs_(static_cast<std::size_t>(memory.ns / period.ns) + 2) {
  assert(mode.contact_N_per_m > 0 && mode.ground_N_per_m > 0 && mode.mass_kg > 0 && mode.damping_N_s_per_m >= 0);
  assert(memory.ns >= 0 && period.ns > 0);
}

void SmithRenderer::rest_at(const glm::dvec3& hand_m) {
  mass_m_ = hand_m * (mode_.contact_N_per_m / (mode_.contact_N_per_m + mode_.ground_N_per_m));
  velocity_m_per_s_ = glm::dvec3(0);
  hand_m_ = hand_m;
  kept_ = 0;
}

void SmithRenderer::advance(Duration by, const glm::dvec3& hand_m) {
  const int steps = static_cast<int>(std::ceil(seconds(by) / longest_step_s_));
  const double step_s = seconds(by) / steps;
  const double inverse_mass = 1 / mode_.mass_kg;
  for (int i = 0; i < steps; ++i) {
    const glm::dvec3 x = mixed(hand_m_, hand_m, static_cast<double>(i) / steps);
    const glm::dvec3 pull_N =
        (x - mass_m_) * mode_.contact_N_per_m - mass_m_ * mode_.ground_N_per_m - velocity_m_per_s_ * mode_.damping_N_s_per_m;
    velocity_m_per_s_ += pull_N * (inverse_mass * step_s);
    mass_m_ += velocity_m_per_s_ * step_s;
  }
  hand_m_ = hand_m;
}

const SmithRenderer::Output& SmithRenderer::back(std::size_t ticks) const {
  return outputs_[(next_ + outputs_.size() - 1 - ticks) % outputs_.size()];
}

glm::dvec3 SmithRenderer::output_at(RealTime at) const {
  if (back(0).at <= at) return back(0).force_N;
  for (std::size_t ticks = 1; ticks < kept_; ++ticks) {
    const Output &earlier = back(ticks), &later = back(ticks - 1);
    if (earlier.at > at) continue;
    const double w = static_cast<double>((at - earlier.at).ns) / static_cast<double>((later.at - earlier.at).ns);
    return mixed(earlier.force_N, later.force_N, w);
  }
  return back(kept_ - 1).force_N;
}

glm::dvec3 SmithRenderer::force_N(const AffineContact& scheduled, Duration age, RealTime now, const glm::dvec3& hand_m) {
  const Duration since = kept_ > 0 ? now - back(0).at : Duration{};
  if (kept_ == 0 || since.ns > 0) {
    if (kept_ == 0 || since > kFadeAfter)
      rest_at(hand_m);
    else
      advance(since, hand_m);
    outputs_[next_] = {now, (hand_m - mass_m_) * -mode_.contact_N_per_m};
    next_ = (next_ + 1) % outputs_.size();
    kept_ = std::min(kept_ + 1, outputs_.size());
  }
  const glm::dvec3 correction_N = back(0).force_N - output_at(scheduled.read_at);
  return without_pull((scheduled.force_N + correction_N) * fade(age), scheduled.outward);
}

}  // namespace evenstep
