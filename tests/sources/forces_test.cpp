// The path of a source's forces between the lanes, without a loop around it.
#include <algorithm>
#include <vector>

#include "cases.h"
#include "catch.h"
#include "evenstep/scheduler/random.h"
#include "source_forces.h"

using namespace evenstep;

namespace {

struct Sent {
  StepEmission emission;
  RealTime ended;
  double force_N = 0;
};

/// 40 forces, about 5 ms apart, which a map emits 12 ms after their steps began. Some are lost and some come late.
std::vector<Sent> random_forces(std::uint64_t seed, bool travels) {
  const RandomStream draws(seed, "forces");
  std::uint64_t k = 0;
  const auto between = [&](std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(draws.below(k++, static_cast<std::uint64_t>(high - low + 1)));
  };
  std::vector<Sent> all;
  RealTime begin;
  for (int n = 0; n < 40; ++n, begin = begin + Duration{between(3'000'000, 7'000'000)}) {
    Sent sent;
    sent.ended = begin + Duration{between(100'000, 2'900'000)};
    sent.emission.slot = {begin, SlotKind::mapped};
    sent.emission.at = begin + Duration{12'000'000};
    sent.emission.arrives = sent.ended + Duration{travels ? between(0, 20'000'000) : 0};
    sent.emission.lost = travels && between(0, 9) == 0;
    sent.force_N = static_cast<double>(between(-1000, 1000));
    all.push_back(sent);
  }
  return all;
}

LinkSpec link_of(Resampling kind, Emission emission) {
  LinkSpec link;
  link.samples = 4;
  link.forces = 64;
  link.emission = emission;
  ResamplerSpec spec;
  spec.kind = kind;
  link.source = SourceForces{spec};
  return link;
}

/// Pushes the forces whose steps have ended by `at`.
template <class Push>
void push_until(RealTime at, const std::vector<Sent>& all, std::size_t& next, Push push) {
  for (; next < all.size() && all[next].ended <= at; ++next) push(all[next]);
}

ContactRecord record_of(const Sent& sent) {
  ContactRecord record;
  record.force_N = glm::dvec3(sent.force_N, 0, 0);
  return record;
}

}  // namespace

TEST_CASE("source forces: those that travel at once are played as a force schedule plays them, to the bit, 5,000 times") {
  for (std::uint64_t seed = 0; seed < testing::cases(5'000); ++seed) {
    const std::vector<Sent> all = random_forces(seed, false);
    for (const Emission emission : {Emission::hold, Emission::linear}) {
      const auto kind = emission == Emission::hold ? Resampling::scheduled_held : Resampling::scheduled;
      const auto source = internal::make_source_forces(link_of(kind, emission));
      ForceSchedule<glm::dvec3> schedule(64, emission);
      std::size_t next = 0;
      for (RealTime at; at < RealTime{250'000'000}; at = at + Duration{1'000'000}) {
        push_until(at, all, next, [&](const Sent& sent) {
          source->push(sent.emission, record_of(sent));
          schedule.push(sent.emission.at, record_of(sent).force_N);
        });
        const Reading<glm::dvec3> played = source->at(at, source->head(), {}, nullptr), expected = schedule.at(at);
        REQUIRE(played.value == expected.value);
        REQUIRE(played.status == expected.status);
        REQUIRE(played.newest == expected.newest);
      }
      REQUIRE(source->source_counts()->lost == 0);
      REQUIRE(source->source_counts()->reordered == 0);
    }
  }
}

TEST_CASE("source forces: a tick holds the newest of those that have arrived, and lost ones are counted, 5,000 times") {
  for (std::uint64_t seed = 0; seed < testing::cases(5'000); ++seed) {
    const std::vector<Sent> all = random_forces(seed, true);
    const auto source = internal::make_source_forces(link_of(Resampling::newest, Emission::hold));
    std::size_t next = 0;
    for (RealTime at; at < RealTime{400'000'000}; at = at + Duration{1'000'000}) {
      push_until(at, all, next, [&](Sent sent) {
        sent.emission.slot.kind = SlotKind::newest;
        source->push(sent.emission, record_of(sent));
      });
      const Reading<glm::dvec3> played = source->at(at, source->head(), {}, nullptr);
      const Sent* newest = nullptr;  // searched anew each time, in any order of arrival
      for (const Sent& sent : all) {
        if (!sent.emission.lost && sent.emission.arrives <= at) newest = &sent;
      }
      REQUIRE((played.status == ReadStatus::empty) == (newest == nullptr));
      if (newest != nullptr) REQUIRE(played.value.x == newest->force_N);
    }
    const auto lost = std::count_if(all.begin(), all.end(), [](const Sent& sent) { return sent.emission.lost; });
    std::int64_t reordered = 0;
    for (std::size_t n = 0; n < all.size(); ++n) {
      reordered += !all[n].emission.lost &&
                   std::any_of(all.begin() + static_cast<std::ptrdiff_t>(n), all.end(), [&](const Sent& later) {
                     return !later.emission.lost && later.emission.arrives < all[n].emission.arrives;
                   });
    }
    REQUIRE(source->source_counts()->lost == lost);
    REQUIRE(source->source_counts()->reordered == reordered);
    for (std::uint64_t n = 0; n < all.size(); ++n)
      REQUIRE(source->emission(n, source->head()).has_value() == !all[n].emission.lost);
  }
}

TEST_CASE("source forces: a chunk continues the line through its force and the one before, in 2,000 lines") {
  for (std::uint64_t seed = 0; seed < testing::cases(2'000); ++seed) {
    const RandomStream draws(seed, "line");
    const double slope = 200 * draws.uniform(0) - 100;
    LinkSpec link = link_of(Resampling::newest, Emission::linear);
    ChunkSpec chunk;
    chunk.entries = 30;
    chunk.every = Duration{10'000'000};
    link.source = SourceForces{chunk};
    const auto source = internal::make_source_forces(link);
    for (int n = 0; n < 5; ++n) {
      Sent sent;
      sent.emission.slot = {RealTime{n * 100'000'000}, SlotKind::newest};
      sent.emission.at = sent.emission.arrives = RealTime{n * 100'000'000 + 60'000'000};
      sent.force_N = 5 + slope * 0.1 * n;
      source->push(sent.emission, record_of(sent));
    }
    for (int ms = 460; ms < 690; ms += 7) {
      const Reading<glm::dvec3> played = source->at(RealTime{ms * 1'000'000LL}, source->head(), {}, nullptr);
      REQUIRE(played.status == ReadStatus::inside);
      REQUIRE(played.value.x == Approx(5 + slope * 1e-3 * ms).epsilon(1e-9));
    }
    REQUIRE(source->at(RealTime{700'000'000}, source->head(), {}, nullptr).status == ReadStatus::underrun);
  }
}

TEST_CASE("source forces: an engine interpolates by the loop's own time, else by when a step began, in 2,000 schedules") {
  for (std::uint64_t seed = 0; seed < testing::cases(2'000); ++seed) {
    const RandomStream draws(seed, "engine");
    const bool has_clock = draws.uniform(0) < 0.5;
    LinkSpec link = link_of(Resampling::interpolated, Emission::linear);
    ResamplerSpec spec;
    spec.kind = Resampling::interpolated;
    spec.period = Duration{10'000'000};
    link.source = SourceForces{spec};
    const auto source = internal::make_source_forces(link);
    for (std::int64_t n = 0; n < 20; ++n) {
      Sent sent;
      // A step runs in the first frame after the end of its time, and then takes some.
      const RealTime due{(n + 1) * 10'000'000},
          began = due + Duration{static_cast<std::int64_t>(4e6 * draws.uniform(static_cast<std::uint64_t>(100 + n)))};
      sent.emission.slot = {began, SlotKind::newest};
      sent.emission.at = sent.emission.arrives = began + Duration{500'000};
      if (has_clock) sent.emission.simulated = SimTime{n * 10'000'000};
      sent.force_N = static_cast<double>(n * n);
      source->push(sent.emission, record_of(sent));
      const RealTime from = has_clock ? due : began, tick = sent.emission.at + Duration{1'000'000};
      const double share = n == 0 ? 1 : static_cast<double>((tick - from).ns) / 1e7;
      const Reading<glm::dvec3> played = source->at(tick, source->head(), {}, nullptr);
      REQUIRE(played.status == ReadStatus::inside);
      REQUIRE(played.value.x ==
              Approx(sent.force_N - (1 - share) * static_cast<double>(n == 0 ? 0 : 2 * n - 1)).margin(1e-9));
    }
  }
}
