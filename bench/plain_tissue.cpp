#include "plain_tissue.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <utility>

namespace evenstep::bench {
namespace {

constexpr int kNeighbour[18][3] = {{-1, 0, 0},  {1, 0, 0},  {0, -1, 0},  {0, 1, 0},  {0, 0, -1},  {0, 0, 1},
                                   {-1, -1, 0}, {1, -1, 0}, {-1, 1, 0},  {1, 1, 0},  {-1, 0, -1}, {1, 0, -1},
                                   {-1, 0, 1},  {1, 0, 1},  {0, -1, -1}, {0, 1, -1}, {0, -1, 1},  {0, 1, 1}};

struct Vector {
  float x, y, z;
};
template <class Scalar>
struct Vectors {
  Scalar* __restrict x;
  Scalar* __restrict y;
  Scalar* __restrict z;
};

[[gnu::always_inline]] inline Vector spring_force(const Vectors<const float>& u, const float* __restrict active,
                                                  const PlainConstants& c, std::ptrdiff_t i) {
  Vector f{0, 0, 0};
#pragma GCC unroll 18
  for (int s = 0; s < PlainConstants::kNeighbours; ++s) {
    const auto n = static_cast<std::size_t>(s);
    const std::ptrdiff_t j = i + c.offset[n];
    const float dx = (u.x[j] - u.x[i]) + c.rest_m[n][0];
    const float dy = (u.y[j] - u.y[i]) + c.rest_m[n][1];
    const float dz = (u.z[j] - u.z[i]) + c.rest_m[n][2];
    const float length = std::sqrt(dx * dx + dy * dy + dz * dz + FLT_MIN);
    const float factor = active[j] * (1 - c.length_m[n] / length);
    f.x += factor * dx;
    f.y += factor * dy;
    f.z += factor * dz;
  }
  return f;
}

[[gnu::noinline]] void advance_cells(std::ptrdiff_t begin, std::ptrdiff_t end, const Vectors<const float> u,
                                     const Vectors<float> next, const Vectors<float> v, const float* __restrict active,
                                     const float* __restrict mobile, const PlainConstants& c) {
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    const Vector f = spring_force(u, active, c, i);
    const float acceleration = c.acceleration * mobile[i], h = c.step_s * mobile[i];
    v.x[i] = v.x[i] * c.decay + f.x * acceleration;
    v.y[i] = v.y[i] * c.decay + f.y * acceleration;
    v.z[i] = v.z[i] * c.decay + f.z * acceleration;
    next.x[i] = u.x[i] + v.x[i] * h;
    next.y[i] = u.y[i] + v.y[i] * h;
    next.z[i] = u.z[i] + v.z[i] * h;
  }
}

[[gnu::noinline]] void divide_and_root(std::size_t count, const float* __restrict squares, float* __restrict sums,
                                       const std::array<float, PlainConstants::kNeighbours>& lengths) {
  for (std::size_t i = 0; i < count; ++i) {
    float sum = 0;
#pragma GCC unroll 18
    for (std::size_t s = 0; s < PlainConstants::kNeighbours; ++s) sum += lengths[s] / std::sqrt(squares[i] + lengths[s]);
    sums[i] = sum;
  }
}

}  // namespace

DivideAndRootFloor::DivideAndRootFloor(const TissueScene& scene)
    : squares_(static_cast<std::size_t>(scene.lattice[0] + 1) * static_cast<std::size_t>(scene.lattice[1] + 1) *
               static_cast<std::size_t>(scene.lattice[2])),
      sums_(squares_.size()) {
  for (std::size_t i = 0; i < squares_.size(); ++i) squares_[i] = 1 + static_cast<float>(i % 97) / 97;
}

void DivideAndRootFloor::step() {
  std::array<float, PlainConstants::kNeighbours> lengths;
  for (std::size_t s = 0; s < lengths.size(); ++s) lengths[s] = 1 + static_cast<float>(s) / 18;
  constexpr std::size_t kInCache = 2048;  // the number of cells, which are used again and again
  for (std::size_t done = 0; done < squares_.size(); done += kInCache)
    divide_and_root(std::min(kInCache, squares_.size() - done), squares_.data(), sums_.data(), lengths);
}

PlainTissue::PlainTissue(const TissueScene& scene, double step_s, int threads) : threads_(threads), step_s_(step_s) {
  constants_.step_s = static_cast<float>(step_s);
  constants_.acceleration = static_cast<float>(scene.stiffness_N_per_m * step_s / scene.particle_mass_kg);
  constants_.decay = static_cast<float>(1 - scene.damping_per_s * step_s);
  constants_.stiffness = static_cast<float>(scene.stiffness_N_per_m);
  const auto [nx, ny, nz] = scene.lattice;
  const std::ptrdiff_t px = nx + 1, py = ny + 1;
  first_ = px * py + px + 1;  // before and after come a plane, a row and a cell of ghosts
  end_ = first_ + px * py * nz;
  const auto cells = static_cast<std::size_t>(end_ + first_);
  const auto spacing = static_cast<float>(scene.spacing_m);
  for (std::size_t s = 0; s < PlainConstants::kNeighbours; ++s) {
    const auto [dx, dy, dz] = kNeighbour[s];
    constants_.offset[s] = dx + px * (dy + py * dz);
    constants_.rest_m[s] = {spacing * static_cast<float>(dx), spacing * static_cast<float>(dy),
                            spacing * static_cast<float>(dz)};
    const auto [x, y, z] = constants_.rest_m[s];
    constants_.length_m[s] = std::sqrt(x * x + y * y + z * z);
  }
  const std::vector<float> zeros(cells);
  now_ = next_ = velocity_ = {zeros, zeros, zeros};
  active_.resize(cells);
  mobile_.resize(cells);
  const ToolCoupling& grab = scene.tools.front();
  for (std::int64_t site = 0; site < scene.particle_count; ++site) {
    const std::int64_t x = site % nx, y = site / nx % ny, z = site / nx / ny;
    const std::ptrdiff_t cell = first_ + x + px * (y + py * z);
    active_[static_cast<std::size_t>(cell)] = 1;
    if (scene.fixed.z_min && z == 0) continue;
    const glm::dvec3 away_m = glm::dvec3(x, y, z) * scene.spacing_m - grab.center_m;
    const bool held = std::sqrt(away_m.x * away_m.x + away_m.y * away_m.y + away_m.z * away_m.z) <= grab.radius_m;
    mobile_[static_cast<std::size_t>(cell)] = held ? 0 : 1;
    if (held) grabbed_.push_back(cell);
  }
}

void PlainTissue::advance(std::ptrdiff_t begin, std::ptrdiff_t end) {
  advance_cells(begin, end, {now_.x.data(), now_.y.data(), now_.z.data()}, {next_.x.data(), next_.y.data(), next_.z.data()},
                {velocity_.x.data(), velocity_.y.data(), velocity_.z.data()}, active_.data(), mobile_.data(), constants_);
}

std::array<double, 3> PlainTissue::step(const std::array<double, 3>& offset_m) {
  const std::ptrdiff_t count = end_ - first_;
  if (threads_ == 1) {
    advance(first_, end_);
  } else {
#pragma omp parallel for schedule(static) num_threads(threads_)
    for (std::ptrdiff_t part = 0; part < threads_; ++part)
      advance(first_ + count * part / threads_, first_ + count * (part + 1) / threads_);
  }
  std::swap(now_, next_);
  for (const std::ptrdiff_t cell : grabbed_) {
    const auto i = static_cast<std::size_t>(cell);
    now_.x[i] = static_cast<float>(offset_m[0]);
    now_.y[i] = static_cast<float>(offset_m[1]);
    now_.z[i] = static_cast<float>(offset_m[2]);
    velocity_.x[i] = static_cast<float>((offset_m[0] - tool_m_[0]) / step_s_);
    velocity_.y[i] = static_cast<float>((offset_m[1] - tool_m_[1]) / step_s_);
    velocity_.z[i] = static_cast<float>((offset_m[2] - tool_m_[2]) / step_s_);
  }
  tool_m_ = offset_m;
  std::array<double, 3> force_N{};
  for (const std::ptrdiff_t cell : grabbed_) {
    const Vector f = spring_force({now_.x.data(), now_.y.data(), now_.z.data()}, active_.data(), constants_, cell);
    force_N[0] += static_cast<double>(f.x * constants_.stiffness);
    force_N[1] += static_cast<double>(f.y * constants_.stiffness);
    force_N[2] += static_cast<double>(f.z * constants_.stiffness);
  }
  return force_N;
}

}  // namespace evenstep::bench
