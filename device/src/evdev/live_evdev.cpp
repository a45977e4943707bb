#include "evenstep/device/evdev/live_evdev.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "../live_sender.h"

namespace evenstep {
namespace {

using Node = std::shared_ptr<EvdevNode>;

/// How long a new effect and erase() wait for what is being sent. The kernel ends a transfer over USB after 5 s.
constexpr std::chrono::seconds kSettles{10};
/// A call may be interrupted by a signal.
constexpr int kTries = 3;

struct Order {
  std::optional<EvdevEffect> effect;  // to be uploaded; otherwise an event to be written
  EvdevEvent event;
  std::uint64_t number = 0;  // counts the effect's uploads
  bool newest = true;
};

struct Known {
  EvdevEffect effect;
  int node_id = -1;
  std::uint64_t asked = 0, answered = 0;  // uploads
  int error = 0;                          // of the last one that was answered
};

EvdevEffect without_force(EvdevEffect effect) {
  effect.id = -1;
  effect.level = 0;
  effect.conditions = {};
  return effect;
}

}  // namespace

struct LiveEvdev::State final : internal::LiveSender<Order, Node>::Cable {
  using Sender = internal::LiveSender<Order, Node>;
  State(std::unique_ptr<EvdevNode> node, std::function<EvdevNodes()> find, const WallClock& with, Duration patience)
      : find_again(std::move(find)), clock(with), reader(std::move(node)), writer(reader), info(reader->info()) {
    sender.emplace(clock, patience, *this);
  }

  HidWrite send(const Order& order) override;
  std::optional<Node> find() override;
  bool take_over(EvdevNode& node);
  int upload_new(EvdevEffect& effect);
  template <class Call>
  int ask(Call call);
  int known_gone(int error);

  const std::function<EvdevNodes()> find_again;
  const WallClock& clock;
  Node reader;  // for the threads that call
  Node writer;  // for the thread that sends
  const EvdevInfo info;
  std::mutex mutex;  // guards what follows
  std::map<int, Known> effects;
  int next_id = 0;
  bool grabbed = false;
  std::optional<Sender> sender;  // the last member, because it uses all others
};

HidWrite LiveEvdev::State::send(const Order& order) {
  EvdevEffect effect = order.effect.value_or(EvdevEffect{});
  EvdevEvent event = order.event;
  {
    const std::lock_guard lock(mutex);
    const int number = order.effect ? effect.id : event.code;
    const auto known = effects.find(number);
    if (order.effect && known == effects.end()) return HidWrite::rejected;
    if (order.effect) effect.id = static_cast<std::int16_t>(known->second.node_id);
    if (!order.effect && known != effects.end()) event.code = static_cast<std::uint16_t>(known->second.node_id);
  }
  int error = EINTR;
  for (int tries = 0; tries < kTries && error == EINTR; ++tries)
    error = order.effect ? writer->upload(effect) : writer->write(event);
  if (order.effect) {
    const std::lock_guard lock(mutex);
    if (const auto known = effects.find(order.effect->id); known != effects.end()) {
      known->second.answered = order.number;
      known->second.error = error;
    }
  }
  return error == 0 ? HidWrite::ok : error == ENODEV ? HidWrite::gone : HidWrite::rejected;
}

std::optional<Node> LiveEvdev::State::find() {
  for (std::unique_ptr<EvdevNode>& one : find_again()) {
    Node node = std::move(one);
    if (take_over(*node)) return writer = std::move(node);
  }
  return std::nullopt;
}

/// The node of a device appears before its force feedback works: until then it refuses the effects, and the device is looked
/// for again.
bool LiveEvdev::State::take_over(EvdevNode& node) {
  std::map<int, EvdevEffect> anew;
  {
    const std::lock_guard lock(mutex);
    if (grabbed && node.grab() != 0) return false;
    for (const auto& [id, known] : effects) anew[id] = without_force(known.effect);
  }
  for (auto& [id, effect] : anew) {
    if (node.upload(effect) != 0) return false;
  }
  const std::lock_guard lock(mutex);
  for (auto& [id, known] : effects) {
    known.node_id = anew[id].id;
    known.answered = known.asked;
    known.error = 0;
  }
  return true;
}

/// Makes a call on the thread of the caller.
template <class Call>
int LiveEvdev::State::ask(Call call) {
  if (sender->presence() != internal::Presence::here) return ENXIO;
  return known_gone(call(*reader));
}

/// ENODEV is returned only when the device is no longer looked for.
int LiveEvdev::State::known_gone(int error) {
  return error == ENODEV && sender->lose() != internal::Presence::gone ? ENXIO : error;
}

int LiveEvdev::State::upload_new(EvdevEffect& effect) {
  sender->wait_until_sent(kSettles);
  return ask([&](EvdevNode& node) {
    const int error = node.upload(effect);
    if (error != 0) return error;
    const std::lock_guard lock(mutex);
    const int node_id = effect.id;
    effect.id = static_cast<std::int16_t>(next_id++);
    effects[effect.id] = {effect, node_id};
    return error;
  });
}

LiveEvdev::LiveEvdev(std::unique_ptr<EvdevNode> node, std::function<EvdevNodes()> find, const WallClock& clock,
                     Duration patience)
    : state_(std::make_unique<State>(std::move(node), std::move(find), clock, patience)) {}
LiveEvdev::~LiveEvdev() = default;

EvdevRead LiveEvdev::read(std::span<EvdevEvent> events) {
  const auto without_device = [](internal::Presence presence) {
    return EvdevRead{presence == internal::Presence::gone ? EvdevRead::Status::gone : EvdevRead::Status::away};
  };
  if (const internal::Presence presence = state_->sender->presence(); presence != internal::Presence::here)
    return without_device(presence);
  if (auto returned = state_->sender->take_returned()) {
    state_->reader = *std::move(returned);
    return {EvdevRead::Status::returned};
  }
  const EvdevRead got = state_->reader->read(events);
  for (EvdevEvent& event : events.first(std::min(got.count, events.size()))) event.at = state_->clock.at(event.at.ns);
  return got.status == EvdevRead::Status::gone ? without_device(state_->sender->lose()) : got;
}

bool LiveEvdev::tells_times() const { return state_->reader->tells_times(); }

int LiveEvdev::write(const EvdevEvent& event) {
  const auto same = [&](const Order& other) {
    return !other.effect && other.event.type == event.type && other.event.code == event.code;
  };
  const HidWrite put = state_->sender->put(true, same, [&](Order& slot) { slot = {.effect = {}, .event = event}; });
  return put == HidWrite::ok ? 0 : put == HidWrite::gone ? ENODEV : ENXIO;
}

int LiveEvdev::upload(EvdevEffect& effect) {
  if (effect.id < 0) return state_->upload_new(effect);
  std::uint64_t number = 0;
  {
    const std::lock_guard lock(state_->mutex);
    const auto known = state_->effects.find(effect.id);
    if (known == state_->effects.end() || known->second.effect.type != effect.type) return EINVAL;
    known->second.effect = effect;
    number = ++known->second.asked;
  }
  const auto same = [&](const Order& other) { return other.effect && other.effect->id == effect.id; };
  const HidWrite put =
      state_->sender->put(true, same, [&](Order& slot) { slot = {.effect = effect, .event = {}, .number = number}; });
  return put == HidWrite::ok ? 0 : put == HidWrite::gone ? ENODEV : ENXIO;
}

EvdevNode::Upload LiveEvdev::uploaded(int id) {
  const std::lock_guard lock(state_->mutex);
  const auto known = state_->effects.find(id);
  if (known == state_->effects.end()) return Upload::refused;
  if (known->second.answered < known->second.asked) return Upload::waits;
  return known->second.error == 0 ? Upload::taken : Upload::refused;
}

int LiveEvdev::erase(int id) {
  state_->sender->wait_until_sent(kSettles);
  int node_id = id;
  {
    const std::lock_guard lock(state_->mutex);
    const auto known = state_->effects.find(id);
    if (known == state_->effects.end()) return EINVAL;
    node_id = known->second.node_id;
  }
  const int error = state_->ask([&](EvdevNode& node) { return node.erase(node_id); });
  const std::lock_guard lock(state_->mutex);
  if (error != EINTR) state_->effects.erase(id);
  return error;
}

int LiveEvdev::grab() {
  const int error = state_->ask([](EvdevNode& node) { return node.grab(); });
  const std::lock_guard lock(state_->mutex);
  state_->grabbed = state_->grabbed || error == 0;
  return error;
}

int LiveEvdev::axis(std::uint16_t code, EvdevAxis& axis) {
  int error = EAGAIN;
  state_->sender->between_sends([&] { error = state_->reader->axis(code, axis); });
  return state_->known_gone(error);
}

int LiveEvdev::effect_count(int& count) {
  return state_->ask([&](EvdevNode& node) { return node.effect_count(count); });
}
bool LiveEvdev::has_axis(std::uint16_t code) { return state_->reader->has_axis(code); }
bool LiveEvdev::has_feedback(std::uint16_t code) { return state_->reader->has_feedback(code); }
int LiveEvdev::set_axis(std::uint16_t code, const EvdevAxis& axis) {
  return state_->ask([&](EvdevNode& node) { return node.set_axis(code, axis); });
}
const EvdevInfo& LiveEvdev::info() const { return state_->info; }
WriteTimes LiveEvdev::write_times() const { return state_->sender->times(); }
std::int64_t LiveEvdev::times_unplugged() const { return state_->sender->times_unplugged(); }

}  // namespace evenstep
