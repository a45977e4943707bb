#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <utility>

#include "evenstep/remap/remapper.h"
#include "evenstep_remap.h"

using namespace evenstep;

namespace {

struct HandAt {
  Slot slot;
  ReadStatus status;
  RealTime newest;
};

}  // namespace

/// The handle, for any number of components, with the state that is needed to check each call before it is made.
struct evenstep_remap {
  explicit evenstep_remap(std::uint32_t size) : components(size) {}
  virtual ~evenstep_remap() = default;
  virtual void sample(RealTime now, const double* position) = 0;
  virtual ReadStatus force(RealTime now, double* force) = 0;
  virtual void segment(RealTime begin) = 0;
  virtual HandAt begin_step(RealTime now, std::optional<SimTime> simulated, double* position) = 0;
  virtual RealTime end_step(RealTime now, const double* force) = 0;
  virtual RemapCounts counts() const = 0;

  const std::uint32_t components;
  std::int64_t last_sample_ns = INT64_MIN;                             // device thread
  std::int64_t last_segment_ns = INT64_MIN, last_step_ns = INT64_MIN;  // simulation thread
  bool step_open = false;                                              // simulation thread
};

namespace {

template <std::size_t N>
class Sized final : public evenstep_remap {
 public:
  using Value = std::array<double, N>;
  explicit Sized(const RemapperOptions& options) : evenstep_remap(N), remap_(options) {}
  void sample(RealTime now, const double* position) override { remap_.sample(now, value(position)); }
  ReadStatus force(RealTime now, double* force) override {
    const Reading<Value> reading = remap_.force(now);
    std::copy(reading.value.begin(), reading.value.end(), force);
    return reading.status;
  }
  void segment(RealTime begin) override { remap_.segment(begin); }
  HandAt begin_step(RealTime now, std::optional<SimTime> simulated, double* position) override {
    const auto [slot, hand] = remap_.begin_step(now, simulated);
    std::copy(hand.value.begin(), hand.value.end(), position);
    return {slot, hand.status, hand.newest};
  }
  RealTime end_step(RealTime now, const double* force) override { return remap_.end_step(now, value(force)).at; }
  RemapCounts counts() const override { return remap_.counts(); }

 private:
  static Value value(const double* components) {
    Value value;
    std::copy_n(components, N, value.begin());
    return value;
  }
  Remapper<Value> remap_;
};

template <std::size_t... index>
std::unique_ptr<evenstep_remap> make(std::uint32_t components, const RemapperOptions& options,
                                     std::index_sequence<index...>) {
  std::unique_ptr<evenstep_remap> made;
  ((components == index + 1 ? void(made = std::make_unique<Sized<index + 1>>(options)) : void()), ...);
  return made;
}

thread_local char last_error[200] = "";

template <class... Arguments>
int refuse(int code, const char* format, Arguments... arguments) {
  std::snprintf(last_error, sizeof last_error, format, arguments...);
  return code;
}

/// The first thing wrong with an argument; later checks are skipped.
class Check {
 public:
  explicit Check(const char* function) : function_(function) {}
  int code() const { return code_; }

  Check& pointer(const char* name, const void* pointer) {
    if (code_ == 0 && pointer == nullptr) wrong(EVENSTEP_REMAP_INVALID, "%s: %s is NULL", function_, name);
    return *this;
  }
  Check& range(const char* name, std::int64_t value, std::int64_t least, std::int64_t most) {
    if (code_ == 0 && (value < least || value > most))
      wrong(EVENSTEP_REMAP_INVALID, "%s: %s is %lld, not in %lld to %lld", function_, name, static_cast<long long>(value),
            static_cast<long long>(least), static_cast<long long>(most));
    return *this;
  }
  Check& time(const char* name, std::int64_t ns) {
    return range(name, ns, -EVENSTEP_REMAP_FURTHEST_NS, EVENSTEP_REMAP_FURTHEST_NS);
  }
  Check& length(const char* name, std::int64_t ns, std::int64_t least = 0) {
    return range(name, ns, least, EVENSTEP_REMAP_LONGEST_NS);
  }
  Check& after(const char* name, std::int64_t ns, std::int64_t before_ns) {
    if (code_ == 0 && ns < before_ns)
      wrong(EVENSTEP_REMAP_ORDER, "%s: %s is %lld ns, before the time of the last one, %lld ns", function_, name,
            static_cast<long long>(ns), static_cast<long long>(before_ns));
    return *this;
  }
  Check& finite(const char* name, const double* values, std::uint32_t count) {
    for (std::uint32_t i = 0; i < count && code_ == 0; ++i)
      if (!std::isfinite(values[i])) wrong(EVENSTEP_REMAP_INVALID, "%s: %s[%u] is not finite", function_, name, i);
    return *this;
  }
  Check& that(bool holds, int code, const char* text) {
    if (code_ == 0 && !holds) wrong(code, "%s: %s", function_, text);
    return *this;
  }
  Check& size(std::uint32_t given, std::size_t known) {
    if (code_ == 0 && given != known)
      wrong(EVENSTEP_REMAP_ABI_SIZE,
            "%s: struct_size is %u, and this library (ABI %d) knows %u: set it to sizeof the struct", function_, given,
            EVENSTEP_REMAP_ABI, static_cast<unsigned>(known));
    return *this;
  }

 private:
  template <class... Arguments>
  void wrong(int code, const char* format, Arguments... arguments) {
    code_ = refuse(code, format, arguments...);
  }
  const char* function_;
  int code_ = 0;
};

int check(const evenstep_remap_options& o) {
  Check check("evenstep_remap_create");
  check.size(o.struct_size, sizeof o)
      .range("components", o.components, 1, EVENSTEP_REMAP_MOST_COMPONENTS)
      .length("lead_ns", o.lead_ns, -EVENSTEP_REMAP_LONGEST_NS)
      .length("latency_ns", o.latency_ns)
      .range("emission", o.emission, EVENSTEP_REMAP_HOLD, EVENSTEP_REMAP_LINEAR)
      .range("adapts", o.adapts, 0, 1)
      .that(o.bandwidth_Hz >= 1e-3 && o.bandwidth_Hz <= 1e3, EVENSTEP_REMAP_INVALID, "bandwidth_Hz is not in 1e-3 to 1e3")
      .range("sample_capacity", o.sample_capacity, 2, EVENSTEP_REMAP_MOST_ENTRIES)
      .range("force_capacity", o.force_capacity, 2, EVENSTEP_REMAP_MOST_ENTRIES)
      .length("sample_window_ns", o.sample_window_ns)
      .length("sample_furthest_ns", o.sample_furthest_ns)
      .length("force_window_ns", o.force_window_ns)
      .length("force_furthest_ns", o.force_furthest_ns);
  if (o.adapts == 0) return check.code();
  return check.length("adapt_least_ns", o.adapt_least_ns)
      .length("adapt_start_ns", o.adapt_start_ns, o.adapt_least_ns)
      .length("adapt_most_ns", o.adapt_most_ns, o.adapt_start_ns)
      .length("adapt_window_ns", o.adapt_window_ns, 1)
      .length("adapt_margin_ns", o.adapt_margin_ns)
      .range("adapt_slew_ppm", o.adapt_slew_ppm, 0, kMostSlew_ppm)
      .code();
}

RemapperOptions options_of(const evenstep_remap_options& o) {
  RemapperOptions options{.lead = {o.lead_ns},
                          .latency = {o.latency_ns},
                          .emission = o.emission == EVENSTEP_REMAP_HOLD ? Emission::hold : Emission::linear,
                          .bandwidth_Hz = o.bandwidth_Hz,
                          .past_newest_sample = {{o.sample_window_ns}, {o.sample_furthest_ns}},
                          .past_newest_force = {{o.force_window_ns}, {o.force_furthest_ns}},
                          .interaction_capacity = o.sample_capacity,
                          .force_capacity = o.force_capacity};
  if (o.adapts != 0) {
    options.adapt = AdaptiveLatencyOptions{.start = {o.adapt_start_ns},
                                           .least = {o.adapt_least_ns},
                                           .most = {o.adapt_most_ns},
                                           .window = {o.adapt_window_ns},
                                           .margin = {o.adapt_margin_ns},
                                           .slew_ppm = o.adapt_slew_ppm};
  }
  return options;
}

static_assert(static_cast<int>(ReadStatus::inside) == EVENSTEP_REMAP_INSIDE);
static_assert(static_cast<int>(ReadStatus::underrun) == EVENSTEP_REMAP_UNDERRUN);
static_assert(static_cast<int>(ReadStatus::overrun) == EVENSTEP_REMAP_OVERRUN);
static_assert(static_cast<int>(ReadStatus::empty) == EVENSTEP_REMAP_EMPTY);

}  // namespace

uint32_t evenstep_remap_abi() { return EVENSTEP_REMAP_ABI; }
const char* evenstep_remap_last_error() { return last_error; }

int evenstep_remap_options_init(evenstep_remap_options* options, uint32_t struct_size) {
  const Check check = Check(__func__).pointer("options", options).size(struct_size, sizeof *options);
  if (check.code() != 0) return check.code();
  const RemapperOptions defaults;
  const AdaptiveLatencyOptions adapt;
  *options = {};
  options->struct_size = struct_size;
  options->components = 3;
  options->emission = EVENSTEP_REMAP_LINEAR;
  options->bandwidth_Hz = defaults.bandwidth_Hz;
  options->sample_capacity = static_cast<uint32_t>(defaults.interaction_capacity);
  options->force_capacity = static_cast<uint32_t>(defaults.force_capacity);
  options->adapt_window_ns = adapt.window.ns;
  options->adapt_margin_ns = adapt.margin.ns;
  options->adapt_slew_ppm = adapt.slew_ppm;
  return EVENSTEP_REMAP_OK;
}

namespace {

int create(const char* function, const evenstep_remap_options& options, const std::optional<Clocked>& clock,
           evenstep_remap** remap) {
  if (const int code = check(options); code != 0) return code;
  RemapperOptions all = options_of(options);
  all.clocked = clock;
  constexpr auto sizes = std::make_index_sequence<EVENSTEP_REMAP_MOST_COMPONENTS>();
  try {
    *remap = make(options.components, all, sizes).release();
    return EVENSTEP_REMAP_OK;
  } catch (const std::bad_alloc&) {
    return refuse(EVENSTEP_REMAP_MEMORY, "%s: not enough memory for rings of %u and %u entries", function,
                  options.sample_capacity, options.force_capacity);
  } catch (const std::exception& error) {
    return refuse(EVENSTEP_REMAP_BROKEN, "%s: %s", function, error.what());
  }
}

}  // namespace

int evenstep_remap_create(const evenstep_remap_options* options, evenstep_remap** remap) {
  const Check pointers = Check(__func__).pointer("remap", remap).pointer("options", options);
  if (remap != nullptr) *remap = nullptr;
  return pointers.code() != 0 ? pointers.code() : create(__func__, *options, std::nullopt, remap);
}

int evenstep_remap_create_clocked(const evenstep_remap_options* options, const evenstep_remap_clock* clock,
                                  evenstep_remap** remap) {
  Check check = Check(__func__).pointer("remap", remap).pointer("options", options).pointer("clock", clock);
  if (remap != nullptr) *remap = nullptr;
  if (check.code() == 0) check.size(clock->struct_size, sizeof *clock);
  if (check.code() != 0) return check.code();
  check.range("steps", clock->steps, 1, 1'000'000'000)
      .range("seconds", clock->seconds, 1, 1'000'000'000)
      .length("dropped_jump_ns", clock->dropped_jump_ns);
  if (check.code() != 0) return check.code();
  Clocked map{.step_rate = {clock->steps, clock->seconds}};
  if (clock->dropped_jump_ns > 0) map.most = {clock->dropped_jump_ns};
  return create(__func__, *options, map, remap);
}

void evenstep_remap_destroy(evenstep_remap* remap) { delete remap; }

int evenstep_remap_sample(evenstep_remap* remap, int64_t now_ns, const double* position) {
  Check check = Check(__func__).pointer("remap", remap).pointer("position", position).time("now_ns", now_ns);
  if (check.code() != 0) return check.code();
  check.after("now_ns", now_ns, remap->last_sample_ns).finite("position", position, remap->components);
  if (check.code() != 0) return check.code();
  remap->last_sample_ns = now_ns;
  remap->sample({now_ns}, position);
  return EVENSTEP_REMAP_OK;
}

int evenstep_remap_force(evenstep_remap* remap, int64_t now_ns, double* force, uint32_t* status) {
  const Check check = Check(__func__).pointer("remap", remap).pointer("force", force).time("now_ns", now_ns);
  if (check.code() != 0) return check.code();
  const ReadStatus read = remap->force({now_ns}, force);
  if (status != nullptr) *status = static_cast<uint32_t>(read);
  return EVENSTEP_REMAP_OK;
}

int evenstep_remap_segment(evenstep_remap* remap, int64_t begin_ns) {
  Check check = Check(__func__).pointer("remap", remap).time("begin_ns", begin_ns);
  if (check.code() != 0) return check.code();
  check.after("begin_ns", begin_ns, remap->last_segment_ns)
      .that(!remap->step_open, EVENSTEP_REMAP_ORDER, "a step has begun and not ended");
  if (check.code() != 0) return check.code();
  remap->last_segment_ns = begin_ns;
  remap->segment({begin_ns});
  return EVENSTEP_REMAP_OK;
}

namespace {

int begin_step(const char* function, evenstep_remap* remap, int64_t now_ns, std::optional<SimTime> simulated,
               double* position, evenstep_remap_read* read) {
  Check check = Check(function).pointer("remap", remap).pointer("position", position).time("now_ns", now_ns);
  if (read != nullptr) check.size(read->struct_size, sizeof *read);
  if (check.code() != 0) return check.code();
  check.that(!remap->step_open, EVENSTEP_REMAP_ORDER, "the step before has not ended")
      .after("now_ns", now_ns, remap->last_step_ns);
  if (check.code() != 0) return check.code();
  remap->step_open = true;
  remap->last_step_ns = now_ns;
  const HandAt hand = remap->begin_step({now_ns}, simulated, position);
  if (read != nullptr)
    *read = {.struct_size = sizeof *read,
             .status = static_cast<uint32_t>(hand.status),
             .read_ns = hand.slot.read.ns,
             .newest_ns = hand.newest.ns,
             .has_slot = hand.slot.kind == SlotKind::mapped ? 1U : 0U,
             .reserved = 0};
  return EVENSTEP_REMAP_OK;
}

}  // namespace

int evenstep_remap_begin_step(evenstep_remap* remap, int64_t now_ns, double* position, evenstep_remap_read* read) {
  return begin_step(__func__, remap, now_ns, std::nullopt, position, read);
}

int evenstep_remap_begin_step_at(evenstep_remap* remap, int64_t now_ns, int64_t simulated_ns, double* position,
                                 evenstep_remap_read* read) {
  const Check check = Check(__func__).time("simulated_ns", simulated_ns);
  if (check.code() != 0) return check.code();
  return begin_step(__func__, remap, now_ns, SimTime{simulated_ns}, position, read);
}

int evenstep_remap_end_step(evenstep_remap* remap, int64_t now_ns, const double* force, int64_t* emission_ns) {
  Check check = Check(__func__).pointer("remap", remap).pointer("force", force).time("now_ns", now_ns);
  if (check.code() != 0) return check.code();
  check.that(remap->step_open, EVENSTEP_REMAP_ORDER, "no step has begun")
      .after("now_ns", now_ns, remap->last_step_ns)
      .finite("force", force, remap->components);
  if (check.code() != 0) return check.code();
  remap->step_open = false;
  remap->last_step_ns = now_ns;
  const RealTime emission = remap->end_step({now_ns}, force);
  if (emission_ns != nullptr) *emission_ns = emission.ns;
  return EVENSTEP_REMAP_OK;
}

int evenstep_remap_get_counts(const evenstep_remap* remap, evenstep_remap_counts* counts) {
  Check check = Check(__func__).pointer("remap", remap).pointer("counts", counts);
  if (check.code() == 0) check.size(counts->struct_size, sizeof *counts);
  if (check.code() != 0) return check.code();
  const auto [steps, acquiring, late_forces, latest_force, hand, force] = remap->counts();
  *counts = {.struct_size = sizeof *counts,
             .reserved = 0,
             .steps = steps,
             .acquiring = acquiring,
             .late_forces = late_forces,
             .latest_force_ns = latest_force.ns,
             .hand_inside = hand.inside,
             .hand_held = hand.held,
             .hand_extrapolated = hand.extrapolated,
             .hand_overruns = hand.overruns,
             .hand_empty = hand.empty,
             .force_inside = force.inside,
             .force_held = force.held,
             .force_extrapolated = force.extrapolated,
             .force_overruns = force.overruns,
             .force_empty = force.empty};
  return EVENSTEP_REMAP_OK;
}
