#include "evenstep/device/inverse3/inverse3_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

namespace evenstep {
namespace {

/// An id is sent back and printed, so no character in it may need to be escaped anywhere.
bool is_id(std::string_view text) {
  return !text.empty() && text.size() <= kLongestInverse3Id &&
         std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c <= '~' && c != '"' && c != '\\'; });
}

/// The callbacks of nlohmann's parser.
class MessageReader : public nlohmann::json_sax<nlohmann::json> {
 public:
  bool null() override { return other(); }
  bool boolean(bool value) override {
    if (where() != Where::status) return other();
    if (key_ == "calibrated") devices_.back().calibrated = value;
    if (key_ == "in_use") devices_.back().in_use = value;
    return true;
  }
  bool number_integer(number_integer_t value) override { return number(static_cast<double>(value)); }
  bool number_unsigned(number_unsigned_t value) override { return number(static_cast<double>(value)); }
  bool number_float(number_float_t value, const string_t&) override { return number(value); }
  bool string(string_t& text) override {
    if (where() != Where::device || key_ != "device_id") return other();
    if (!is_id(text)) return fail("a device_id is not 1 to 64 printable characters of ASCII");
    devices_.back().device_id = text;
    return true;
  }
  bool binary(binary_t&) override { return other(); }

  bool start_object(std::size_t) override {
    const Where from = where();
    if (path_.empty()) return enter(Where::message);
    if (from == Where::devices) {
      if (devices_.size() == kMostInverse3Devices) return fail(fmt::format("more than {} devices", kMostInverse3Devices));
      devices_.emplace_back();
      return enter(Where::device);
    }
    if (from == Where::device && key_ == "state") return enter(Where::state);
    if (from == Where::device && key_ == "status") return enter(Where::status);
    if (from == Where::state && key_ == "cursor_position") {
      position_ = {};
      return enter(Where::position);
    }
    return other() && enter(Where::elsewhere);
  }
  bool end_object() override {
    if (where() == Where::position && !take_position()) return false;
    if (where() == Where::device && devices_.back().device_id.empty()) return fail("a device has no device_id");
    path_.pop_back();
    return true;
  }
  bool start_array(std::size_t) override {
    if (where() == Where::message && key_ == "inverse3") return enter(Where::devices);
    return other() && enter(Where::elsewhere);
  }
  bool end_array() override {
    path_.pop_back();
    return true;
  }
  bool key(string_t& text) override {
    key_.assign(text, 0, std::min<std::size_t>(text.size(), 32));
    return true;
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception&) override {
    return fail(fmt::format("no JSON at byte {}", position));
  }

  Result<std::vector<Inverse3State>> finish() {
    if (!error_.empty()) return Failure(std::move(error_));
    return std::move(devices_);
  }

 private:
  enum class Where { elsewhere, message, devices, device, state, status, position };
  Where where() const { return path_.empty() ? Where::elsewhere : path_.back(); }

  bool enter(Where next) {
    if (path_.size() == kDeepestInverse3Message)
      return fail(fmt::format("nested more than {} deep", kDeepestInverse3Message));
    path_.push_back(next);
    return true;
  }
  bool fail(std::string why) {
    if (error_.empty()) error_ = std::move(why);
    return false;
  }
  bool number(double value) {
    if (where() != Where::position) return other();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (key_.size() == 1 && key_[0] == "xyz"[axis]) position_[axis] = value;
    }
    return true;
  }
  /// A value of a type that no field we use has; fails if such a field has it.
  bool other() {
    const bool is_used = (path_.empty()) || (where() == Where::message && key_ == "inverse3") || where() == Where::devices ||
                         (where() == Where::device && (key_ == "device_id" || key_ == "state" || key_ == "status")) ||
                         (where() == Where::state && key_ == "cursor_position") ||
                         (where() == Where::status && (key_ == "calibrated" || key_ == "in_use")) ||
                         (where() == Where::position && (key_ == "x" || key_ == "y" || key_ == "z"));
    if (!is_used) return true;
    return fail(path_.empty() || where() == Where::devices ? "a value where an object was expected"
                                                           : fmt::format("'{}' is of another type", key_));
  }
  /// Other clients read a missing coordinate as 0, but a hand that jumps to 0 would be pushed.
  bool take_position() {
    glm::dvec3 position_m;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!position_[axis]) return fail(fmt::format("'cursor_position' has no '{}'", "xyz"[axis]));
      if (!(std::abs(*position_[axis]) <= kInverse3Reach_m))
        return fail(fmt::format("'cursor_position' is more than {} m away", kInverse3Reach_m));
      position_m[static_cast<int>(axis)] = *position_[axis];
    }
    devices_.back().position_m = position_m;
    return true;
  }

  std::vector<Where> path_;
  std::string key_;
  std::array<std::optional<double>, 3> position_;
  std::vector<Inverse3State> devices_;
  std::string error_;
};

}  // namespace

Result<std::vector<Inverse3State>> read_inverse3_message(std::string_view message) {
  if (message.size() > kLongestInverse3Message) return Failure(fmt::format("longer than {} bytes", kLongestInverse3Message));
  MessageReader reader;
  nlohmann::json::sax_parse(message.begin(), message.end(), &reader);
  return reader.finish();
}

std::string inverse3_force_message(std::string_view device_id, const glm::dvec3& force_N) {
  assert(is_id(device_id) && std::isfinite(force_N.x) && std::isfinite(force_N.y) && std::isfinite(force_N.z));
  return fmt::format(
      R"({{"inverse3":[{{"device_id":"{}","commands":{{"set_cursor_force":{{"values":{{"x":{},"y":{},"z":{}}}}}}}}}]}})",
      device_id, force_N.x, force_N.y, force_N.z);
}

std::string inverse3_inventory_message() { return R"({"session":{"force_render_full_state":{}}})"; }

namespace {

std::optional<unsigned> number_up_to(std::string_view text, unsigned most) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size() || value > most) return std::nullopt;
  return value;
}

/// The first of the four numbers of 1.2.3.4.
std::optional<unsigned> first_of_ipv4(std::string_view text) {
  std::optional<unsigned> first;
  for (int part = 0; part < 4; ++part) {
    const std::size_t dot = part < 3 ? text.find('.') : text.size();
    if (dot == std::string_view::npos) return std::nullopt;
    const auto number = number_up_to(text.substr(0, dot), 255);
    if (!number) return std::nullopt;
    if (part == 0) first = number;
    text.remove_prefix(std::min(text.size(), dot + 1));
  }
  return first;
}

bool is_ipv6(std::string_view text) {
  return !text.empty() && text.size() < 46 && text.find(':') != std::string_view::npos &&
         text.find_first_not_of("0123456789abcdefABCDEF:.") == std::string_view::npos;
}

}  // namespace

Result<Inverse3Address> read_inverse3_address(std::string_view text) {
  const auto refuse = [](const char* why) { return Failure(fmt::format("{}; write ws://127.0.0.1:10001#049D", why)); };
  Inverse3Address address;
  if (text.size() > 256) return refuse("the address of a service is longer than 256 characters");
  address.text = text;
  constexpr std::string_view kScheme = "ws://";
  if (!text.starts_with(kScheme)) return refuse("the address of a service begins with ws://");
  text.remove_prefix(kScheme.size());
  if (const std::size_t mark = text.find('#'); mark != std::string_view::npos) {
    address.device_id = text.substr(mark + 1);
    if (!is_id(address.device_id)) return refuse("after # the id of a device is expected");
    text = text.substr(0, mark);
  }
  if (text.ends_with('/')) text.remove_suffix(1);
  const bool has_brackets = text.starts_with('[') && text.find(']') != std::string_view::npos;
  const std::size_t end_of_host = has_brackets ? text.find(']') + 1 : std::min(text.find(':'), text.size());
  std::string_view host = text.substr(0, end_of_host), port = text.substr(end_of_host);
  if (!port.empty()) {
    const auto number = port.front() == ':' ? number_up_to(port.substr(1), 65535) : std::nullopt;
    if (!number || *number == 0) return refuse("after : a port from 1 to 65535 is expected");
    address.port = *number;
  }
  if (has_brackets) host = host.substr(1, host.size() - 2);
  if (host == "localhost") host = "127.0.0.1";
  const std::optional<unsigned> first = has_brackets ? std::nullopt : first_of_ipv4(host);
  if (!(has_brackets ? is_ipv6(host) : first.has_value()))
    return refuse("the host is not localhost, 1.2.3.4 or [::1] (no name is looked up)");
  address.host = host;
  address.is_loopback = has_brackets ? host == "::1" : *first == 127;
  return address;
}

}  // namespace evenstep
