#include "evenstep/loop/exchange.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "rendered_schedule.h"

namespace evenstep {

namespace {

std::optional<Filter<glm::dvec3>> filter_of(const std::optional<FilterSpec>& spec, Rate rate) {
  if (!spec) return std::nullopt;
  return make_filter<glm::dvec3>(*spec, rate);
}

}  // namespace

Exchange::Link::Link(const LinkSpec& link)
    : spec(link),
      interaction(link.samples, link.interaction, link.spare),
      forces(internal::make_rendered_schedule(link)),
      interaction_filter(filter_of(link.interaction_filter, link.step_rate)),
      force_filter(filter_of(link.force_filter, link.ticks.rate)) {}

/// Every force is looked at once: by the first tick at which it is due, or that finds it gone.
void Exchange::Link::count(const TickInput& tick, ReadStatus found) {
  ++counts.ticks.at(static_cast<std::size_t>(found));
  std::int64_t due = 0;
  for (; next_due < tick.force_head; ++next_due) {
    const std::optional<RealTime> emission = forces->emission(next_due, tick.force_head);
    if (emission && *emission > tick.played_at) break;
    ++(emission ? due : counts.dropped);
  }
  counts.sent += due > 0;
  counts.overtaken += std::max<std::int64_t>(due - 1, 0);
}

Exchange::Exchange(const std::vector<LinkSpec>& links) {
  for (const LinkSpec& link : links) links_.emplace_back(link);
}

Exchange::~Exchange() = default;

std::uint64_t Exchange::forces(int tool) const { return links_[static_cast<std::size_t>(tool)].forces->head(); }

std::int64_t Exchange::pending_forces(int tool) const {
  return static_cast<std::int64_t>(forces(tool) - links_[static_cast<std::size_t>(tool)].next_due);
}

std::optional<RenderedContactsSummary> Exchange::contacts(int tool) const {
  return links_[static_cast<std::size_t>(tool)].forces->contacts();
}

std::optional<SourceCounts> Exchange::source_counts(int tool) const {
  return links_[static_cast<std::size_t>(tool)].forces->source_counts();
}

DeviceSample Exchange::sense(int tool, const Scheduler& scheduler) {
  const DeviceSample sample = read_device(tool, scheduler);
  Link& link = links_[static_cast<std::size_t>(tool)];
  link.sensed[1] = std::exchange(link.sensed[0], sample);
  // The forces are looked at before a step can have the sample. Otherwise a fast step could begin with this sample and end
  // before this tick looks: the step would need the tick, and the tick the step, and no replay could run either first.
  link.looked = look(tool, scheduler);
  // A position that is not new is the last sample again, which the ring already has.
  if (sample.fresh || !sample.taken_at)
    link.interaction.push(sample.time(), sample.position_m);
  else
    ++link.repeated_samples;
  return sample;
}

const glm::dvec3* Exchange::other_hand_m(int tool, const DeviceSample& sample) const {
  if (tool_count() != 2) return nullptr;
  for (const std::optional<DeviceSample>& other : links_[static_cast<std::size_t>(1 - tool)].sensed)
    if (other && other->read_at < sample.read_at) return &other->position_m;
  return nullptr;
}

Played Exchange::play(int tool, const DeviceSample& sample) {
  Link& link = links_[static_cast<std::size_t>(tool)];
  const TickInput& input = link.looked;
  Played played{input.played_at, link.forces->at(input.played_at, input.force_head, sample, other_hand_m(tool, sample)),
                link.forces->spring()};
  link.count(input, played.force_N.status);
  if (link.force_filter) played.force_N.value = link.force_filter->next(played.force_N.value);
  return played;
}

Reading<glm::dvec3> Exchange::hand(int tool, const Slot& slot) {
  Link& link = links_[static_cast<std::size_t>(tool)];
  const std::uint64_t head = interaction_head(tool);
  Reading<glm::dvec3> hand = link.interaction.hand(slot, head);
  if (link.interaction_filter && slot.kind != SlotKind::mapped) hand.value = link.interaction_filter->next(hand.value);
  return hand;
}

bool Exchange::must_wait(int tool, const Reading<glm::dvec3>& hand) const {
  const bool missing = hand.status == ReadStatus::underrun || hand.status == ReadStatus::empty;
  return missing && links_[static_cast<std::size_t>(tool)].spec.gate;
}

RealTime Exchange::next_sample(int tool, const Slot& slot, RealTime now) const {
  const SamplingGrid& ticks = links_[static_cast<std::size_t>(tool)].spec.ticks;
  const RealTime due = tick_time(ticks.rate, first_tick_at_or_after(ticks.rate, slot.read, ticks.origin), ticks.origin);
  if (due > now) return due;
  return tick_time(ticks.rate, first_tick_at_or_after(ticks.rate, now + Duration{1}, ticks.origin), ticks.origin);
}

void Exchange::respond(int tool, const StepEmission& emission, const ContactRecord& record) {
  links_[static_cast<std::size_t>(tool)].forces->push(emission, record);
}

TickInput Exchange::look(int tool, const Scheduler& scheduler) { return {{}, scheduler.live_now(), forces(tool)}; }
std::uint64_t Exchange::interaction_head(int tool) { return samples(tool); }

DeviceExchange::DeviceExchange(const std::vector<LinkSpec>& links, std::vector<HapticDevice*> devices,
                               std::vector<DeviceInputs>* keep)
    : Exchange(links), devices_(std::move(devices)), keep_(keep) {
  if (keep_) keep_->resize(devices_.size());
}

DeviceSample DeviceExchange::read_device(int tool, const Scheduler& scheduler) {
  const DeviceSample sample = devices_[static_cast<std::size_t>(tool)]->read(scheduler.live_now());
  if (keep_) (*keep_)[static_cast<std::size_t>(tool)].ticks.push_back({sample, {}, 0, ticks_run_++});
  return sample;
}

TickInput DeviceExchange::look(int tool, const Scheduler& scheduler) {
  const TickInput input = Exchange::look(tool, scheduler);
  if (keep_) {
    TickInput& kept = (*keep_)[static_cast<std::size_t>(tool)].ticks.back();
    kept.played_at = input.played_at;
    kept.force_head = input.force_head;
  }
  return input;
}

std::uint64_t DeviceExchange::interaction_head(int tool) {
  const std::uint64_t head = Exchange::interaction_head(tool);
  if (keep_) (*keep_)[static_cast<std::size_t>(tool)].interaction_heads.push_back(head);
  return head;
}

DeviceSpring DeviceExchange::render(int tool, const DeviceSpring& wanted) {
  const DeviceSpring rendered = devices_[static_cast<std::size_t>(tool)]->write_spring(wanted);
  if (keep_) (*keep_)[static_cast<std::size_t>(tool)].springs.push_back(rendered);
  return rendered;
}

IdealExchange::IdealExchange(const std::vector<LinkSpec>& links, std::vector<HapticDevice*> devices,
                             std::vector<ProgrammedMotion> motions)
    : DeviceExchange(links, std::move(devices)), motions_(std::move(motions)) {}

Reading<glm::dvec3> IdealExchange::hand(int tool, const Slot& slot) {
  return {position_m(motions_[static_cast<std::size_t>(tool)], slot.read), ReadStatus::inside, slot.read};
}

RecordedExchange::RecordedExchange(const std::vector<LinkSpec>& links, const std::vector<DeviceInputs>& inputs,
                                   bool use_heads)
    : Exchange(links),
      inputs_(inputs),
      use_heads_(use_heads),
      next_tick_(inputs.size(), 0),
      next_step_(inputs.size(), 0),
      next_spring_(inputs.size(), 0) {
  assert(inputs.size() == links.size());
}

bool RecordedExchange::next_tick_ready() const {
  const TickInput* next = nullptr;
  std::size_t next_tool = 0;
  for (std::size_t tool = 0; tool < inputs_.size(); ++tool) {
    if (next_tick_[tool] == inputs_[tool].ticks.size()) continue;
    const TickInput& candidate = inputs_[tool].ticks[next_tick_[tool]];
    if (next && next->order < candidate.order) continue;
    next = &candidate;
    next_tool = tool;
  }
  return next && next->force_head <= forces(static_cast<int>(next_tool));
}

bool RecordedExchange::next_step_ready() const {
  for (std::size_t tool = 0; tool < inputs_.size(); ++tool) {
    const auto& heads = inputs_[tool].interaction_heads;
    if (next_step_[tool] < heads.size() && heads[next_step_[tool]] > samples(static_cast<int>(tool))) return false;
  }
  return true;
}

bool RecordedExchange::samples_ahead(std::uint64_t by) const {
  for (std::size_t tool = 0; tool < inputs_.size(); ++tool) {
    const auto& heads = inputs_[tool].interaction_heads;
    if (next_step_[tool] < heads.size() && samples(static_cast<int>(tool)) >= heads[next_step_[tool]] + by) return true;
  }
  return false;
}

DeviceSample RecordedExchange::read_device(int tool, const Scheduler&) {
  const std::size_t device = static_cast<std::size_t>(tool);
  return inputs_[device].ticks.at(next_tick_[device]).sample;
}

TickInput RecordedExchange::look(int tool, const Scheduler&) {
  const std::size_t device = static_cast<std::size_t>(tool);
  TickInput input = inputs_[device].ticks.at(next_tick_[device]++);
  if (!use_heads_) input.force_head = forces(tool);
  return input;
}

std::uint64_t RecordedExchange::interaction_head(int tool) {
  const std::size_t device = static_cast<std::size_t>(tool);
  return use_heads_ ? inputs_[device].interaction_heads.at(next_step_[device]++) : samples(tool);
}

DeviceSpring RecordedExchange::render(int tool, const DeviceSpring&) {
  const std::size_t device = static_cast<std::size_t>(tool);
  if (!use_heads_ || next_spring_[device] == inputs_[device].springs.size()) return {};
  return inputs_[device].springs[next_spring_[device]++];
}

}  // namespace evenstep
