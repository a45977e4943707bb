#pragma once
/// A map of your own, for strategy `foreign`: it says at which real time each step's slot is. evenstep adds lead and latency
/// to it, computes the least of both, and does everything else that it does for its own maps (slot_map.h).
///
///   class Every2ms final : public evenstep::ForeignMap {
///     void boundary(std::int64_t, evenstep::RealTime) override {}
///     std::optional<evenstep::RealTime> slot(std::int64_t n) override { return evenstep::RealTime{n * 2'000'000}; }
///   };
///   registry.add_map("every-2-ms", [](const evenstep::MapRequest&) { return std::make_unique<Every2ms>(); });
///
/// A map runs alone in the sizing pass, and again in each run: told the same times it must give the same slots.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "evenstep/time/time.h"

namespace evenstep {

/// What a map is made for.
struct MapRequest {
  std::string name;            ///< the name it is registered under
  std::string options = "{}";  ///< of [remap] foreign, as a JSON object, keys in alphabetical order; unread by evenstep
  Rate step_rate{450, 1};      ///< 1 / step_size: steps per second of simulation time
  std::uint64_t seed = 1;      ///< [run] seed: all that may be drawn at random follows from it
};

/// It is told what a causal map can know, in the order in which it happens. Any function may throw std::exception: the run
/// then stops with its message and the map's name.
class ForeignMap {
 public:
  virtual ~ForeignMap() = default;
  /// A segment began at `begin`; the next step is n, counted from 0. n and `begin` never decrease.
  virtual void boundary(std::int64_t n, RealTime begin) = 0;
  /// Step n begins (called before slot(n)) or has ended, at the time that it would have without a gate.
  virtual void began(std::int64_t /*n*/, RealTime /*at*/) {}
  virtual void ended(std::int64_t /*n*/, RealTime /*at*/) {}
  /// When step n would be due if steps were even, at most kFarthestSlot from where it begins; nullopt while the map does not
  /// know yet. Called once for each step, in order. If a slot is not after the one before it, the emission time is repaired
  /// (emission_repairs).
  virtual std::optional<RealTime> slot(std::int64_t n) = 0;
};

/// A slot farther from its step is an error: rings would have to hold all that lies between.
inline constexpr Duration kFarthestSlot{60'000'000'000};

/// Makes a map; called by any thread, several times per run. Throws std::exception if it cannot.
using MapFactory = std::function<std::unique_ptr<ForeignMap>(const MapRequest& request)>;

}  // namespace evenstep
