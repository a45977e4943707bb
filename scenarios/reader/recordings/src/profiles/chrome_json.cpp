// Trace events of Chrome, Perfetto's legacy export and PyTorch's profiler, as JSON: an array of events, or an object with
// one in "traceEvents". Complete events (X) have a length; begins and ends (B, E) nest in a thread. Times are microseconds,
// with fractions; displayTimeUnit is about the viewer and changes nothing. The file is read as a stream.
#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "decimal_time.h"
#include "profile_formats.h"

namespace evenstep::internal {
namespace {

constexpr std::int64_t kMicrosecond = 1000;
constexpr int kDeepest = 200;
constexpr std::size_t kLongestToken = std::size_t{16} << 20;
constexpr std::size_t kMostOpen = 1'000'000;  // begins without an end

/// The characters of a stream as iterators of the JSON reader. The stream ends early after a token of kLongestToken bytes,
/// so that the reader need not keep more.
class Characters {
 public:
  explicit Characters(Bytes& bytes) : bytes_(bytes) { refill(); }
  bool done() const { return piece_.empty(); }
  char current() const { return piece_.front(); }
  void advance() {
    piece_.remove_prefix(1);
    if (++since_token_ > kLongestToken) {
      too_long_ = true;
      piece_ = {};
    } else if (piece_.empty()) {
      refill();
    }
  }
  void token_ends() { since_token_ = 0; }
  bool too_long() const { return too_long_; }

 private:
  void refill() { piece_ = bytes_.next(); }
  Bytes& bytes_;
  std::string_view piece_;
  std::size_t since_token_ = 0;
  bool too_long_ = false;
};

class CharacterIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = char;

  CharacterIterator() = default;  ///< the end
  explicit CharacterIterator(Characters& characters) : characters_(&characters) {}
  char operator*() const { return characters_->current(); }
  CharacterIterator& operator++() {
    characters_->advance();
    return *this;
  }
  CharacterIterator operator++(int) {
    characters_->advance();
    return *this;
  }
  bool operator==(const CharacterIterator& other) const { return at_end() == other.at_end(); }

 private:
  bool at_end() const { return characters_ == nullptr || characters_->done(); }
  Characters* characters_ = nullptr;
};

/// One event, as far as it is known.
struct Event {
  std::string phase, name, category, process, thread, process_name;
  std::optional<std::int64_t> at_ns, length_ns;
  bool too_far = false;
};

/// What nlohmann's reader calls.
class EventReader : public nlohmann::json_sax<nlohmann::json> {
 public:
  EventReader(Characters& characters, ProfileBuilder& builder) : characters_(characters), builder_(builder) {}

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t number) override { return number_text(std::to_string(number)); }
  bool number_unsigned(number_unsigned_t number) override { return number_text(std::to_string(number)); }
  bool number_float(number_float_t, const string_t& text) override { return number_text(text); }
  bool string(string_t& text) override { return take(text), value(); }
  bool binary(binary_t&) override { return value(); }

  bool start_object(std::size_t) override {
    if (++depth_ > kDeepest) return too_deep();
    if (in_events_ && depth_ == events_depth_ + 1) event_ = {};
    if (in_event() && depth_ == events_depth_ + 2) in_args_ = key_ == "args";
    return value();
  }
  bool end_object() override {
    if (in_event() && depth_ == events_depth_ + 1) add_event();
    if (in_event() && depth_ == events_depth_ + 2) in_args_ = false;
    --depth_;
    return value();
  }
  bool start_array(std::size_t) override {
    if (++depth_ > kDeepest) return too_deep();
    if (depth_ == 1 || (depth_ == 2 && key_ == "traceEvents" && !in_events_)) {
      in_events_ = true;
      events_depth_ = depth_;
    }
    return value();
  }
  bool end_array() override {
    if (in_events_ && depth_ == events_depth_) in_events_ = false, found_events_ = true;
    --depth_;
    return value();
  }
  bool key(string_t& text) override {
    key_.assign(text, 0, std::min<std::size_t>(text.size(), 64));
    return value();
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) override {
    if (characters_.done() && in_events_ && depth_ <= events_depth_ + 1 && !characters_.too_long()) {
      // A program that crashed leaves a list without its end; what is before is whole.
      found_events_ = true;
      builder_.leave_out("ends of the file, which is cut off", event_.name);
    } else if (!builder_.failed() && !characters_.too_long()) {
      const std::string message = error.what();  // "[json.exception.parse_error.101] parse error at line …: …"
      const std::size_t after_code = message.find("] ");
      builder_.fail(fmt::format("is no JSON at byte {}: {}", position,
                                after_code == std::string::npos ? message : message.substr(after_code + 2)));
    }
    return false;
  }

  void finish() {
    if (characters_.too_long()) builder_.fail(fmt::format("a text in it is longer than {} bytes", kLongestToken));
    if (builder_.failed()) return;
    if (!found_events_) builder_.fail("is JSON without \"traceEvents\"");
    for (const auto& [thread, begins] : open_) {
      for (const Open& begin : begins)
        builder_.leave_out("begins without an end", builder_.profile().names[begin.name].text);
    }
    for (std::string& source : builder_.profile().sources) {
      const auto named = process_names_.find(source);
      if (named != process_names_.end()) source += " " + named->second;
    }
  }

 private:
  struct Open {
    std::uint32_t name;
    std::int64_t at_ns;
  };

  bool in_event() const { return in_events_ && depth_ > events_depth_; }
  bool value() {
    characters_.token_ends();
    return !builder_.failed();
  }
  bool too_deep() {
    builder_.fail(fmt::format("is nested more than {} deep", kDeepest));
    return false;
  }
  bool number_text(const std::string& text) { return take(text), value(); }

  /// Keeps a value of the event's own, not of what is nested in it.
  void take(const std::string& text) {
    if (!in_event()) return;
    if (depth_ == events_depth_ + 2 && in_args_ && key_ == "name") event_.process_name = text.substr(0, kLongestName);
    if (depth_ != events_depth_ + 1) return;
    if (key_ == "ph") event_.phase = text.substr(0, 4);
    if (key_ == "name") event_.name = text.substr(0, kLongestName);
    if (key_ == "cat") event_.category = text.substr(0, 100);
    if (key_ == "pid") event_.process = text.substr(0, 100);
    if (key_ == "tid") event_.thread = text.substr(0, 100);
    if (key_ == "ts") event_.at_ns = decimal_time_ns(text, kMicrosecond);
    if (key_ == "dur") event_.length_ns = decimal_time_ns(text, kMicrosecond);
  }

  void add_event();
  void end_event(std::uint32_t source);

  Characters& characters_;
  ProfileBuilder& builder_;
  int depth_ = 0, events_depth_ = 0;
  bool in_events_ = false, in_args_ = false, found_events_ = false;
  std::string key_;
  Event event_;
  std::map<std::pair<std::string, std::string>, std::vector<Open>> open_;  ///< by process and thread
  std::map<std::string, std::string, std::less<>> process_names_;
  std::size_t open_count_ = 0;
};

/// What Chrome's categories are called here: those of GPUs are the same for all readers.
std::string_view category_of(const std::string& category) {
  if (category == "gpu_memcpy" || category == "gpu_memset") return "copy";
  return category;
}

void EventReader::add_event() {
  if (event_.phase == "M" && event_.name == "process_name" && process_names_.size() < 1000)
    process_names_["process " + event_.process] = event_.process_name.substr(0, 100);
  if (event_.phase != "X" && event_.phase != "B" && event_.phase != "E") return;  // instants, counters, flows: no intervals
  if (!event_.at_ns || *event_.at_ns < -kFurthestTime_ns) return builder_.leave_out("events without a time", event_.name);
  const std::uint32_t source = builder_.source("process " + event_.process);
  if (event_.phase == "E") return end_event(source);
  const std::uint32_t name = builder_.name(event_.name, category_of(event_.category));
  if (event_.phase == "X") {
    if (!event_.length_ns || *event_.length_ns > kFurthestTime_ns - std::max<std::int64_t>(*event_.at_ns, 0))
      return builder_.leave_out("complete events without a length", event_.name);
    return builder_.add(name, source, *event_.at_ns, *event_.at_ns + *event_.length_ns);
  }
  if (++open_count_ > kMostOpen) return builder_.fail(fmt::format("more than {} begins without an end", kMostOpen));
  open_[{event_.process, event_.thread}].push_back({name, *event_.at_ns});
}

/// An end belongs to the last begin of its thread; its own name may be missing.
void EventReader::end_event(std::uint32_t source) {
  const auto thread = open_.find({event_.process, event_.thread});
  if (thread == open_.end() || thread->second.empty()) return builder_.leave_out("ends without a begin", event_.name);
  const Open begin = thread->second.back();
  thread->second.pop_back();
  if (thread->second.empty()) open_.erase(thread);
  --open_count_;
  builder_.add(begin.name, source, begin.at_ns, *event_.at_ns);
}

}  // namespace

bool is_chrome_json(std::string_view first_bytes) {
  const std::size_t first = first_bytes.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  return first != std::string_view::npos && (first_bytes[first] == '{' || first_bytes[first] == '[');
}

void read_chrome_json(ProfileInput& input, const ProfileOptions&, ProfileBuilder& builder) {
  builder.profile().format = "trace events (JSON)";
  builder.profile().time_base = "us, as trace events have them";
  Characters characters(input.bytes);
  EventReader reader(characters, builder);
  (void)nlohmann::json::sax_parse(CharacterIterator(characters), CharacterIterator(), &reader);
  reader.finish();
}

}  // namespace evenstep::internal
